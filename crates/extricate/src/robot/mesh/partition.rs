//! Divides connected triangles into solids and surfaces: solids may touch along edges, and walls
//! may be inside.

use super::edges::{Side, all_edges_even, connected, same_edge, sorted_sides};
use super::part::Part;
use super::walls;
use crate::math::Vec3;

/// Divides an edge-connected group of triangles into parts.
pub fn parts_of(vertices: &[Vec3], group: Vec<[u32; 3]>) -> Vec<Part> {
    let rings =
        |sides: &[Side]| sides.chunk_by(same_edge).map(<[Side]>::len).fold((2, 2), |(l, m), n| (l.min(n), m.max(n)));
    let (least, most) = rings(&sorted_sides(&group));
    if (least, most) == (2, 2) {
        return vec![Part::new(vertices, group)];
    }
    let (solids, rest) = closed_patches(group.clone());
    let mut parts: Vec<Part> = solids.into_iter().map(|solid| Part::new(vertices, solid)).collect();
    if rest.is_empty() {
        return parts;
    }
    let rest = Part::new(vertices, rest);
    let is_plain = most == 2 || rest.closed && rest.agrees;
    let patches = |triangles| {
        let (mut solids, rest) = closed_patches(triangles);
        solids.extend(Some(rest).filter(|rest| !rest.is_empty()));
        solids
    };
    let found = if is_plain { None } else { walls::without_walls(vertices, &group, &parts, &rest, patches) };
    let (found, left_out) = found.unwrap_or_else(|| (vec![rest], 0));
    parts.extend(found);
    parts[0].walls = left_out;
    parts
}

/// Splits an edge-connected group into the solids that only touch the rest along edges, and that
/// rest.
///
/// If solids overlap at an edge of four triangles, nothing says which two belong together: their
/// walls may lie in one plane. So a solid is a closed set that edges of exactly two triangles
/// connect; each is oriented by itself.
pub fn closed_patches(group: Vec<[u32; 3]>) -> (Vec<Vec<[u32; 3]>>, Vec<[u32; 3]>) {
    let patches = connected(group, |triangle| *triangle, |ring| ring.len() == 2);
    // Two triangles back to back are a fold, not a solid.
    let is_solid = |patch: &Vec<[u32; 3]>| patch.len() > 3 && all_edges_even(patch);
    let (solids, others): (Vec<_>, Vec<_>) = patches.into_iter().partition(is_solid);
    (solids, others.concat())
}

//! Which solids and surfaces triangles make up that edges connect: solids may touch along edges, and
//! walls may stand inside.

use super::edges::{Side, all_edges_even, connected, same_edge, sorted_sides};
use super::part::Part;
use super::walls;
use crate::math::Vec3;

/// The parts that an edge-connected group of triangles consists of.
pub fn parts_of(vertices: &[Vec3], group: Vec<[u32; 3]>) -> Vec<Part> {
    let rings =
        |sides: &[Side]| sides.chunk_by(same_edge).map(<[Side]>::len).fold((2, 2), |(l, m), n| (l.min(n), m.max(n)));
    let (least, most) = rings(&sorted_sides(&group));
    if (least, most) == (2, 2) {
        return vec![Part::new(vertices, group)];
    }
    let patches = closed_patches(group.clone());
    let parts: Vec<Part> = patches.into_iter().map(|patch| Part::new(vertices, patch)).collect();
    if most == 2 || parts.iter().all(|part| part.closed && part.agrees) {
        return parts;
    }
    walls::without_walls(vertices, &group, closed_patches).unwrap_or(parts)
}

/// The solids of an edge-connected group that only touch the rest along edges, and that rest.
///
/// Where four triangles share an edge, nothing says which two belong together if solids overlap
/// there: their walls may lie in one plane. So a solid is what edges of two triangles hold
/// together, if that is closed; the winding of each is then its own matter.
fn closed_patches(group: Vec<[u32; 3]>) -> Vec<Vec<[u32; 3]>> {
    let patches = connected(group, |triangle| *triangle, |ring| ring.len() == 2);
    // Two triangles back to back are a fold, not a solid.
    let is_solid = |patch: &Vec<[u32; 3]>| patch.len() > 3 && all_edges_even(patch);
    let (mut solids, others): (Vec<_>, Vec<_>) = patches.into_iter().partition(is_solid);
    if !others.is_empty() {
        solids.push(others.concat());
    }
    solids
}

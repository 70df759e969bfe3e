//! Sorts triangles into connected components: solids, cavities and surfaces.

use robust::{Coord, orient2d};

use super::cavities;
use super::edges::edge_connected;
use super::part::{Component, Part};
use super::partition::parts_of;
use super::seams::{self, Welding};
use crate::math::Vec3;

/// Changes to the triangles of a file that its author may not have meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mending {
    /// Welding that closed components, if any did.
    pub welding: Option<Welding>,
    /// Number of triangles inside solids that are left out.
    pub walls: usize,
}

/// Sorts triangles (of three different vertices each) into components in order of appearance, each
/// cavity behind its solid. Drops repeated triangles and those without area, and orients closed
/// components outward, cavities into the cavity. Also returns what was mended.
pub(crate) fn components(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<Component>, Mending) {
    let groups = edge_connected(triangles, |triangle| *triangle);
    let mut parts: Vec<Part> = groups.into_iter().flat_map(|group| parts_of(vertices, group)).collect();
    let welding = if parts.iter().all(|part| part.closed) { None } else { seams::close(vertices, &mut parts) };
    let mending = Mending { welding, walls: parts.iter().map(|part| part.walls).sum() };
    cavities::turn(vertices, &mut parts);
    let mut sorted = Vec::new();
    let mut components = Vec::new();
    for Part { triangles, closed, .. } in parts {
        let start = sorted.len();
        sorted.extend(triangles.into_iter().filter(|t| !on_a_line(t.map(|index| &vertices[index as usize]))));
        if sorted.len() > start {
            components.push(Component { triangles: start..sorted.len(), closed });
        }
    }
    (sorted, components, mending)
}

/// Whether three points lie exactly on a line, as they do if and only if their three projections
/// do.
fn on_a_line([a, b, c]: [&Vec3; 3]) -> bool {
    let flat = |i: usize, j: usize| {
        let at = |p: &Vec3| Coord { x: p[i], y: p[j] };
        orient2d(at(a), at(b), at(c)) == 0.0
    };
    flat(0, 1) && flat(1, 2) && flat(2, 0)
}

#[cfg(test)]
mod tests;

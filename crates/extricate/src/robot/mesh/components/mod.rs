//! Connected components of triangles: solids, cavities and surfaces in order. Not welding.

use robust::{Coord, orient2d};

use super::cavities;
use super::edges::edge_connected;
use super::part::{Component, Part};
use super::partition::parts_of;
use super::seams::{self, Welding};
use crate::math::Vec3;

/// What was done to the triangles of a file that its author may not have meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mending {
    /// What was welded to close some.
    pub welding: Option<Welding>,
    /// How many triangles inside solids are left out.
    pub walls: usize,
}

/// Sorts triangles (of three different vertices each) into components in order of appearance,
/// cavities behind the solids that they are in, drops those that repeat another and those without
/// area, and turns closed components outward, cavities into the cavity. Says what was mended.
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

/// Whether three points lie exactly on a line (so do their three projections, and only then).
fn on_a_line([a, b, c]: [&Vec3; 3]) -> bool {
    let flat = |i: usize, j: usize| {
        let at = |p: &Vec3| Coord { x: p[i], y: p[j] };
        orient2d(at(a), at(b), at(c)) == 0.0
    };
    flat(0, 1) && flat(1, 2) && flat(2, 0)
}

#[cfg(test)]
mod tests;

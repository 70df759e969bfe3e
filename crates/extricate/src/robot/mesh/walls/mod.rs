//! Walls: triangles inside a solid, which hang on its surface along edges of three triangles or
//! more. Not what bounds a solid by itself (`part`).

use super::cavities::{LEAST, volume_and_area, winding_number};
use super::edges::{Side, all_edges_even, edge_connected, find, same_edge, sorted_sides};
use super::part::{Part, distinct, sort_by_angle};
use crate::math::Vec3;

/// Solid angles that may be computed to see that what is left out is inside: a second.
const MOST_ANGLES: usize = 10_000_000;
/// Triangles that are left out of which so many are looked at, at most and at least.
const ASKED: std::ops::RangeInclusive<usize> = 4..=256;

/// What triangles that hang together by edges consist of.
#[derive(Default)]
struct Sorted {
    /// What separates the inside from the outside: every edge is even.
    boundary: Vec<[u32; 3]>,
    /// What has the outside on both sides.
    sheets: Vec<[u32; 3]>,
    /// What has the inside on both sides.
    walls: Vec<[u32; 3]>,
}

/// The parts of triangles that hang together by edges, if some of these edges have three triangles
/// or more: walls inside are left out, and sheets outside are parts of their own. `None` if nothing
/// is separated from the outside, or if nothing is to be left out.
///
/// `patches` divides a boundary into solids.
pub(crate) fn without_walls(
    vertices: &[Vec3],
    group: &[[u32; 3]],
    patches: impl Fn(Vec<[u32; 3]>) -> Vec<Vec<[u32; 3]>>,
) -> Option<Vec<Part>> {
    let triangles = distinct(group);
    let mut sides = sorted_sides(&triangles);
    if sides.chunk_by(same_edge).all(|ring| ring.len() < 3) {
        return None;
    }
    let Sorted { boundary, sheets, walls } = by_cells(vertices, &triangles, &mut sides);
    if boundary.is_empty() || walls.is_empty() && sheets.is_empty() || !all_edges_even(&boundary) {
        return None;
    }
    let solids = edge_connected(boundary, |triangle| *triangle).into_iter().flat_map(patches);
    let mut parts: Vec<Part> = solids.map(|solid| Part::new(vertices, solid)).collect();
    if !are_inside(vertices, &parts, &walls) {
        return None;
    }
    parts[0].walls = walls.len();
    parts.extend(edge_connected(sheets, |t| *t).into_iter().map(|sheet| Part::new(vertices, sheet)));
    Some(parts)
}

/// Sorts triangles that hang together by edges by what is on their two sides.
///
/// The two sides of every triangle look into cells. Two sides that face each other around an edge
/// look into the same one. Of a cell with an end the triangles around it, turned to face out of it,
/// enclose a positive volume; of the outside that is negative.
fn by_cells(vertices: &[Vec3], triangles: &[[u32; 3]], sides: &mut [Side]) -> Sorted {
    // The front of a triangle, to which its normal points, is at 2 t, its back at 2 t + 1.
    let mut cell_of: Vec<u32> = (0..2 * triangles.len() as u32).collect();
    for ring in sides.chunk_by_mut(same_edge) {
        if ring.len() > 2 {
            sort_by_angle(vertices, triangles, ring);
        }
        for (k, side) in ring.iter().enumerate() {
            let next = &ring[(k + 1) % ring.len()];
            // A triangle that runs along the edge has its front where angles grow.
            let onward = 2 * side.triangle + u32::from(!side.forward);
            let back = 2 * next.triangle + u32::from(next.forward);
            let (onward, back) = (find(&mut cell_of, onward), find(&mut cell_of, back));
            cell_of[onward.max(back) as usize] = onward.min(back);
        }
    }
    let origin = triangles.first().map_or(Vec3::zeros(), |first| vertices[first[0] as usize]);
    let mut volumes = vec![0.0; 2 * triangles.len()];
    for (t, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|index| vertices[index as usize] - origin);
        let part = a.dot(&b.cross(&c)) / 6.0;
        volumes[find(&mut cell_of, 2 * t as u32) as usize] -= part;
        volumes[find(&mut cell_of, 2 * t as u32 + 1) as usize] += part;
    }
    let least = LEAST * volume_and_area(vertices, triangles).1.powf(1.5);
    let mut found = Sorted::default();
    for (t, triangle) in triangles.iter().enumerate() {
        let mut is_outside = |side: usize| volumes[find(&mut cell_of, side as u32) as usize] < -least;
        match (is_outside(2 * t), is_outside(2 * t + 1)) {
            (true, true) => found.sheets.push(*triangle),
            (false, false) => found.walls.push(*triangle),
            _ => found.boundary.push(*triangle),
        }
    }
    found
}

/// Whether closed parts together wind around triangles, as far as some of these tell: surfaces that
/// cross themselves may not.
fn are_inside(vertices: &[Vec3], parts: &[Part], triangles: &[[u32; 3]]) -> bool {
    let boundary: Vec<[u32; 3]> = parts.iter().flat_map(|part| part.triangles.iter().copied()).collect();
    let asked = (MOST_ANGLES / boundary.len().max(1)).clamp(*ASKED.start(), *ASKED.end());
    let middle = |t: &[u32; 3]| t.map(|index| vertices[index as usize]).iter().sum::<Vec3>() / 3.0;
    let mut some = triangles.iter().step_by(triangles.len().div_ceil(asked).max(1));
    some.all(|t| winding_number(vertices, &boundary, &middle(t)) > 0.75)
}

#[cfg(test)]
mod tests;

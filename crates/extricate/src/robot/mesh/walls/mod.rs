//! Walls: triangles inside a solid, which hang on its surface along edges of three triangles or
//! more. Not what bounds a solid by itself (`part`).

use std::collections::HashSet;
use std::f64::consts::TAU;

use rayon::prelude::*;

use super::cavities::{LEAST, volume_and_area, winding_number};
use super::edges::{Side, all_edges_even, edge_connected, find, same_edge, sorted_sides};
use super::part::{Part, SAME_ANGLE, distinct, sort_by_angle, sorted};
use crate::math::Vec3;

/// Solid angles that may be computed to see that what is left out is inside: some seconds.
const MOST_ANGLES: usize = 50_000_000;

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

/// The parts of what is not in `solids` of triangles that hang together by edges, if some of these
/// edges have three triangles or more: walls inside are left out, and sheets outside are parts of
/// their own; and how many walls there are. `None` if `rest` has to stay what it is.
///
/// `solids` are closed by themselves and stay whatever is around them: the order around an edge
/// may be wrong if they cross what they hang on. `rest` is all the others as one part; if that is
/// closed, none of it becomes a sheet. `patches` divides triangles into solids and what is left.
pub(crate) fn without_walls(
    vertices: &[Vec3],
    group: &[[u32; 3]],
    solids: &[Part],
    rest: &Part,
    patches: impl Fn(Vec<[u32; 3]>) -> Vec<Vec<[u32; 3]>>,
) -> Option<(Vec<Part>, usize)> {
    let triangles = distinct(group);
    let mut sides = sorted_sides(&triangles);
    if sides.chunk_by(same_edge).all(|ring| ring.len() < 3) {
        return None;
    }
    let in_solids: HashSet<[u32; 3]> = solids.iter().flat_map(|solid| &solid.triangles).map(sorted).collect();
    let of_rest = |mut found: Vec<[u32; 3]>| {
        found.retain(|triangle| !in_solids.contains(&sorted(triangle)));
        found
    };
    let cells = by_cells(vertices, &triangles, &mut sides);
    let [boundary, sheets, walls] = [cells.boundary, cells.sheets, cells.walls].map(of_rest);
    let is_separated = !boundary.is_empty() || !solids.is_empty();
    let is_left_out = !walls.is_empty() || !sheets.is_empty() && !rest.closed;
    if !is_separated || !is_left_out || rest.closed && !sheets.is_empty() || !all_edges_even(&boundary) {
        return None;
    }
    let divided = |triangles| {
        let groups = edge_connected(triangles, |triangle: &[u32; 3]| *triangle);
        groups.into_iter().flat_map(&patches).map(|patch| Part::new(vertices, patch))
    };
    let mut parts: Vec<Part> = divided(boundary).collect();
    let closed: Vec<&Part> = solids.iter().chain(&parts).collect();
    if !are_inside(vertices, &closed, &walls) {
        return None;
    }
    parts.extend(divided(sheets));
    Some((parts, walls.len()))
}

/// Sorts triangles that hang together by edges by what is on their two sides.
///
/// The two sides of every triangle look into cells. Two sides that face each other around an edge
/// look into the same one; two triangles in one plane face each other twice, and what is around
/// them does not notice. Of more than two in one plane nothing says which comes first, so what is
/// around them becomes one cell. Of a cell with an end the triangles around it, turned to face out
/// of it, enclose a positive volume; of the outside that is negative.
fn by_cells(vertices: &[Vec3], triangles: &[[u32; 3]], sides: &mut [Side]) -> Sorted {
    // The front of a triangle, to which its normal points, is at 2 t, its back at 2 t + 1.
    let mut cell_of: Vec<u32> = (0..2 * triangles.len() as u32).collect();
    for ring in sides.chunk_by_mut(same_edge) {
        join_around(vertices, triangles, ring, |one, other| {
            let (one, other) = (find(&mut cell_of, one), find(&mut cell_of, other));
            cell_of[one.max(other) as usize] = one.min(other);
        });
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

/// Joins the sides of triangles that face each other around one edge.
fn join_around(vertices: &[Vec3], triangles: &[[u32; 3]], ring: &mut [Side], mut join: impl FnMut(u32, u32)) {
    // A triangle that runs along the edge has its front where angles grow.
    let onward = |side: &Side| 2 * side.triangle + u32::from(!side.forward);
    let back = |side: &Side| 2 * side.triangle + u32::from(side.forward);
    let mut face = |sides: &[Side]| {
        for (k, side) in sides.iter().enumerate() {
            join(onward(side), back(&sides[(k + 1) % sides.len()]));
        }
    };
    if ring.len() < 3 {
        return face(ring);
    }
    let angles = sort_by_angle(vertices, triangles, ring);
    // Angles that are no numbers are those of triangles without area: they may be anywhere.
    let is_next = |k: usize| {
        let gap = (angles[k] - angles[(k + ring.len() - 1) % ring.len()]).rem_euclid(TAU);
        gap >= SAME_ANGLE
    };
    let first = (0..ring.len()).find(|&k| is_next(k)).unwrap_or(0);
    let order: Vec<usize> = (0..ring.len()).map(|k| (first + k) % ring.len()).collect();
    let mut single = Vec::with_capacity(ring.len());
    for plane in order.chunk_by(|_, &k| !is_next(k)) {
        let plane: Vec<Side> = plane.iter().map(|&k| ring[k]).collect();
        match plane.len() {
            2 => face(&plane),
            1 => single.extend(plane),
            _ => {
                plane.iter().for_each(|side| face(&[*side]));
                single.extend(plane);
            }
        }
    }
    face(&single);
}

/// Whether closed parts together wind around triangles, as far as the middles of these and their
/// corners tell that no closed part has; `false` if that costs too much.
fn are_inside(vertices: &[Vec3], parts: &[&Part], triangles: &[[u32; 3]]) -> bool {
    let boundary: Vec<[u32; 3]> = parts.iter().flat_map(|part| part.triangles.iter().copied()).collect();
    let shared: HashSet<u32> = boundary.as_flattened().iter().copied().collect();
    let mut corners: Vec<u32> = triangles.as_flattened().to_vec();
    corners.sort_unstable();
    corners.dedup();
    corners.retain(|index| !shared.contains(index));
    let middle = |t: &[u32; 3]| t.map(|index| vertices[index as usize]).iter().sum::<Vec3>() / 3.0;
    let mut asked: Vec<Vec3> = triangles.iter().map(middle).collect();
    asked.extend(corners.iter().map(|&index| vertices[index as usize]));
    if asked.len().saturating_mul(boundary.len()) > MOST_ANGLES {
        return false;
    }
    // One that faces against the others may be a cavity.
    let is_mixed = parts.iter().any(|part| !part.was_inward);
    let winding = |point: &Vec3| {
        let around = |part: &&Part| {
            let around = winding_number(vertices, &part.triangles, point);
            if is_mixed && part.was_inward { -around } else { around }
        };
        parts.iter().map(around).sum::<f64>()
    };
    asked.par_iter().all(|point| winding(point) > 0.75)
}

#[cfg(test)]
mod tests;

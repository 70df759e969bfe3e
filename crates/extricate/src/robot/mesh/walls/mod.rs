//! Walls: triangles inside a solid that meet its surface along edges of three triangles or more.
//! `part` handles what bounds a solid by itself.

use std::collections::HashSet;
use std::f64::consts::TAU;

use rayon::prelude::*;

use super::cavities::{MIN_CAVITY_VOLUME_SHARE, volume_and_area, winding_number};
use super::edges::{Side, all_edges_even, edge_connected, find, same_edge, sorted_sides};
use super::part::{COPLANAR_ANGLE_RAD, Part, distinct, sort_by_angle, sorted};
use crate::math::Vec3;

/// Largest number of solid angles to compute to verify that walls are inside: some seconds.
const MAX_SOLID_ANGLES: usize = 50_000_000;

/// Connected triangles, by what is on their two sides.
#[derive(Default)]
struct Sorted {
    /// Triangles between the inside and the outside.
    boundary: Vec<[u32; 3]>,
    /// Triangles with the outside on both sides.
    sheets: Vec<[u32; 3]>,
    /// Triangles with the inside on both sides.
    walls: Vec<[u32; 3]>,
}

/// Divides the triangles of `group` that are not in `solids` into parts, and leaves out walls
/// inside; also returns their number. Sheets outside become parts of their own. `None` if `rest`
/// has to stay as it is, as it does if no edge has three triangles or more.
///
/// `solids` are closed by themselves and stay as they are: the order around an edge may be wrong if
/// they cross what they touch. `rest` is everything else as one part; if that is closed, none of it
/// becomes a sheet. `patches` divides triangles into solids and the rest.
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

/// Sorts connected triangles by what is on their two sides.
///
/// Each side of a triangle faces a cell, and sides that face each other around an edge face the
/// same one. Two triangles in one plane face each other on both sides and do not affect the cells
/// around them. The order of more than two in one plane is unknown, so the cells around them become
/// one. The triangles around a bounded cell, oriented out of it, enclose a positive volume; for the
/// outside it is negative.
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
    let least = MIN_CAVITY_VOLUME_SHARE * volume_and_area(vertices, triangles).1.powf(1.5);
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
    // The front of a triangle that runs forward along the edge faces growing angles.
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
    // The angle of a triangle without area is NaN, and its place in the order does not matter.
    let is_next = |k: usize| {
        let gap = (angles[k] - angles[(k + ring.len() - 1) % ring.len()]).rem_euclid(TAU);
        gap >= COPLANAR_ANGLE_RAD
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

/// Whether closed parts together wind around all triangles, judged by their middles and by the
/// corners that no closed part has; `false` if that costs too much.
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
    if asked.len().saturating_mul(boundary.len()) > MAX_SOLID_ANGLES {
        return false;
    }
    // A part that faces against the others may be a cavity.
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

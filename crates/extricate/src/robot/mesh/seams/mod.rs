//! Seams: open edges whose two sides are no farther apart than f32 can resolve. `openings` measures
//! wider ones.

use std::collections::HashSet;

use super::cavities::volume_and_area;
use super::edges::{edge_connected, odd_edges};
use super::part::{Part, sorted};
use super::partition::parts_of;
use super::weld::weld_within;
use crate::math::Vec3;

/// Largest distance of two corners that a seam joins, as a share of the mesh's size or of its
/// farthest coordinate. It is eight units in the last place of f32 for numbers just above a power
/// of two. Exporters that transform triangle by triangle are off by one or two units in each
/// coordinate. Of 155 meshes of public robots that had open parts, a millionth of the size closes
/// ten.
const MAX_SEAM_SHARE: f64 = 1.0 / (1 << 20) as f64;
/// The same as a share of the mesh's size alone, for meshes far from their origin.
const MAX_SEAM_SIZE_SHARE: f64 = 1e-4;

/// Welding of corners that closed parts of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Welding {
    /// Number of corners that were moved onto others.
    pub corners: usize,
    /// Length of the farthest of these moves \[m\].
    pub farthest: f64,
    /// Number of parts of the mesh that this closed.
    pub closed: usize,
}

/// Welds corners of open edges if that closes a part of the mesh: first each part by itself, then
/// all that are left together. What does not become closed stays as it was.
pub(crate) fn close(vertices: &[Vec3], parts: &mut Vec<Part>) -> Option<Welding> {
    let tolerance = tolerance(vertices)?;
    let (mut closed, open): (Vec<Part>, Vec<Part>) = std::mem::take(parts).into_iter().partition(|part| part.closed);
    let mut welding = Welding { corners: 0, farthest: 0.0, closed: 0 };
    let mut left = Vec::new();
    for part in open {
        // No solid has fewer than four faces.
        let found = if part.triangles.len() < 4 { None } else { welded(vertices, &part.triangles, tolerance) };
        match found.filter(|found| found.left.is_empty()) {
            Some(found) => {
                welding.add(&found.welding);
                closed.extend(found.parts);
            }
            None => left.extend(part.triangles),
        }
    }
    if let Some(found) = welded(vertices, &left, tolerance) {
        welding.add(&found.welding);
        closed.extend(found.parts);
        left = found.left;
    }
    closed.extend(edge_connected(left, |t| *t).into_iter().map(|group| Part::new(vertices, group)));
    *parts = closed;
    (welding.closed > 0).then_some(welding)
}

fn tolerance(vertices: &[Vec3]) -> Option<f64> {
    let first = vertices.first()?;
    let (low, high) = vertices.iter().fold((*first, *first), |(low, high), v| (low.inf(v), high.sup(v)));
    let size = (high - low).norm();
    let farthest = low.amax().max(high.amax()).max(size);
    Some((MAX_SEAM_SHARE * farthest).min(MAX_SEAM_SIZE_SHARE * size))
        .filter(|tolerance| *tolerance > 0.0 && tolerance.is_finite())
}

impl Welding {
    fn add(&mut self, more: &Welding) {
        self.corners += more.corners;
        self.farthest = self.farthest.max(more.farthest);
        self.closed += more.closed;
    }
}

struct Closing {
    parts: Vec<Part>,
    /// Triangles that are in none of the parts.
    left: Vec<[u32; 3]>,
    welding: Welding,
}

/// Corners of open edges in ascending order, and the corners that they are welded to.
struct Seams {
    corners: Vec<u32>,
    to: Vec<u32>,
}

impl Seams {
    fn of(vertices: &[Vec3], triangles: &[[u32; 3]], tolerance: f64) -> Self {
        let mut corners = odd_edges(triangles).concat();
        corners.sort_unstable();
        corners.dedup();
        let points: Vec<Vec3> = corners.iter().map(|&index| vertices[index as usize]).collect();
        let (kept, map) = weld_within(&points, tolerance);
        // Of corners that are welded together, the first one is kept.
        let mut first = vec![u32::MAX; kept.len()];
        corners.iter().zip(&map).rev().for_each(|(&index, &place)| first[place as usize] = index);
        Self { to: map.into_iter().map(|place| first[place as usize]).collect(), corners }
    }

    fn moved(&self, index: u32) -> u32 {
        self.corners.binary_search(&index).map_or(index, |at| self.to[at])
    }
}

/// Welds what can be welded; `None` if nothing becomes closed.
fn welded(vertices: &[Vec3], triangles: &[[u32; 3]], tolerance: f64) -> Option<Closing> {
    let seams = Seams::of(vertices, triangles, tolerance);
    if seams.corners == seams.to {
        return None;
    }
    let moved: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|index| seams.moved(index))).collect();
    let whole: Vec<usize> = (0..moved.len()).filter(|&t| has_three_corners(&moved[t])).collect();
    let mut in_solid: HashSet<u32> = HashSet::new();
    let mut is_closed = vec![false; moved.len()];
    let mut parts = Vec::new();
    for group in edge_connected(whole, |&t| moved[t]) {
        let found = parts_of(vertices, group.iter().map(|&t| moved[t]).collect());
        let is_solid = |part: &Part| part.closed && is_thick(vertices, &part.triangles, tolerance);
        let (solids, others): (Vec<Part>, Vec<Part>) = found.into_iter().partition(is_solid);
        if solids.is_empty() {
            continue;
        }
        // Walls inside are in none of the parts, and go with the solids.
        let others: HashSet<[u32; 3]> = others.iter().flat_map(|part| &part.triangles).map(sorted).collect();
        for &t in group.iter().filter(|&&t| !others.contains(&sorted(&moved[t]))) {
            is_closed[t] = true;
            in_solid.extend(moved[t]);
        }
        parts.extend(solids);
    }
    // A sliver that welding shrinks to a line was part of a seam.
    let shrunk = |t: usize| !has_three_corners(&moved[t]) && moved[t].iter().any(|index| in_solid.contains(index));
    let left = (0..moved.len()).filter(|&t| !is_closed[t] && !shrunk(t)).map(|t| triangles[t]).collect();
    let mut ways: Vec<(u32, u32)> = Vec::new();
    for (from, to) in (0..moved.len()).filter(|&t| is_closed[t]).map(|t| (triangles[t], moved[t])) {
        ways.extend(from.into_iter().zip(to).filter(|(from, to)| from != to));
    }
    ways.sort_unstable();
    ways.dedup();
    let way = |(from, to): &(u32, u32)| (vertices[*from as usize] - vertices[*to as usize]).norm();
    let farthest = ways.iter().map(way).fold(0.0, f64::max);
    let welding = Welding { corners: ways.len(), farthest, closed: parts.len() };
    (welding.closed > 0).then_some(Closing { parts, left, welding })
}

fn has_three_corners([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// Whether the enclosed volume is thicker on average than the tolerance; the two sides of one sheet
/// enclose nothing.
fn is_thick(vertices: &[Vec3], triangles: &[[u32; 3]], tolerance: f64) -> bool {
    let (volume, area) = volume_and_area(vertices, triangles);
    volume.abs() > tolerance * area
}

#[cfg(test)]
mod tests;

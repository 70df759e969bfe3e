//! Cavities: closed parts of a mesh that lie within another one and face the other way.

use std::collections::HashSet;

use super::part::Part;
use crate::math::Vec3;

/// Largest number of corners of a part to test for lying in another one; fewer if parts are many
/// and large. There are no cavities if fewer than [`MIN_CORNERS`] can be tested.
const MAX_CORNERS: usize = 256;
const MIN_CORNERS: usize = 4;
/// Largest number of solid angles to compute for one mesh; they take some seconds.
const MAX_SOLID_ANGLES: usize = 50_000_000;
/// Largest number of closed parts in a mesh with cavities: all pairs of parts are compared.
const MAX_CLOSED_PARTS: usize = 20_000;
/// Smallest volume of a cavity, as a share of its area to the power of 3/2: less is the rounding of
/// flat parts. A ball has 0.09.
pub(super) const MIN_CAVITY_VOLUME_SHARE: f64 = 1e-9;

/// A closed part, its bounding box and its volume.
struct Shell {
    part: usize,
    low: Vec3,
    high: Vec3,
    volume: f64,
}

/// Orients cavities to face into the cavity, and puts each behind the solid that it is in.
///
/// Winding numbers decide. Every closed part counts 1 in what it encloses, except those that face
/// against the outermost part around them. They count -1 if the others around them add up to 1, so
/// that what they enclose is outside. If two solids that face outward overlap, nothing in both
/// becomes a cavity. A mesh whose parts all face inward is taken to be wound the other way.
pub(crate) fn turn(vertices: &[Vec3], parts: &mut Vec<Part>) {
    let closed = || parts.iter().filter(|part| part.closed);
    let inward = closed().filter(|part| part.was_inward).count();
    let count = closed().count();
    if inward == 0 || inward == count || count > MAX_CLOSED_PARTS {
        return;
    }
    let mut shells: Vec<Shell> =
        (0..parts.len()).filter(|&part| parts[part].closed).map(|part| Shell::new(vertices, parts, part)).collect();
    shells.sort_by(|a, b| b.volume.total_cmp(&a.volume).then(a.part.cmp(&b.part)));
    let Some(asked) = corners_to_ask(&shells, parts) else { return };
    let mut counts = vec![1; shells.len()];
    let mut outermost: Vec<usize> = Vec::with_capacity(shells.len());
    let mut solid_of: Vec<Option<usize>> = vec![None; parts.len()];
    for k in 0..shells.len() {
        // Only larger parts, which come first, can hold a part.
        let holds = |other: &usize| shells[*other].holds(&shells[k], vertices, parts, asked);
        let around: Vec<usize> = (0..k).filter(holds).collect();
        let side = |shell: usize| parts[shells[shell].part].was_inward;
        outermost.push(around.first().map_or(k, |first| outermost[*first]));
        let within: i32 = around.iter().map(|other| counts[*other]).sum();
        // If a part contradicts itself, nothing faces against it.
        let says_its_side = parts[shells[outermost[k]].part].agrees;
        if says_its_side && side(k) != side(outermost[k]) && within == 1 && shells[k].is_spacious(vertices, parts) {
            counts[k] = -1;
            let solid = around.iter().rev().find(|other| counts[**other] == 1);
            solid_of[shells[k].part] = solid.map(|solid| shells[*solid].part);
        }
    }
    let mut cavities: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    (0..parts.len())
        .filter_map(|part| Some((part, solid_of[part]?)))
        .for_each(|(part, solid)| cavities[solid].push(part));
    let mut taken: Vec<Option<Part>> = std::mem::take(parts).into_iter().map(Some).collect();
    for part in 0..taken.len() {
        if solid_of[part].is_none() {
            parts.extend(taken[part].take());
            for &cavity in &cavities[part] {
                let mut cavity = taken[cavity].take();
                cavity.iter_mut().flat_map(|cavity| &mut cavity.triangles).for_each(|triangle| triangle.swap(1, 2));
                parts.extend(cavity);
            }
        }
    }
}

/// Number of corners of each part that can be tested; `None` if that is too few to decide anything.
fn corners_to_ask(shells: &[Shell], parts: &[Part]) -> Option<usize> {
    let mut angles: usize = 0;
    for (k, shell) in shells.iter().enumerate() {
        let around = shells[..k].iter().filter(|other| other.may_hold(shell));
        angles = angles.saturating_add(around.map(|other| parts[other.part].triangles.len()).sum());
        if angles > MAX_SOLID_ANGLES / MIN_CORNERS {
            return None;
        }
    }
    Some((MAX_SOLID_ANGLES / angles.max(1)).min(MAX_CORNERS))
}

impl Shell {
    fn new(vertices: &[Vec3], parts: &[Part], part: usize) -> Self {
        let triangles = &parts[part].triangles;
        let corners = || triangles.as_flattened().iter().map(|&index| &vertices[index as usize]);
        let first = corners().next().copied().unwrap_or_default();
        let (low, high) = corners().fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)));
        Self { part, low, high, volume: volume_and_area(vertices, triangles).0 }
    }

    /// Whether the box of `other` lies within this one.
    fn may_hold(&self, other: &Shell) -> bool {
        (0..3).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// Whether the box of a triangle meets this one.
    fn may_meet(&self, [a, b, c]: [&Vec3; 3]) -> bool {
        let (low, high) = (a.inf(b).inf(c), a.sup(b).sup(c));
        (0..3).all(|k| low[k] <= self.high[k] && self.low[k] <= high[k])
    }

    /// Whether all of `other` lies within, judged by its box and by some of its corners that the
    /// two do not share.
    fn holds(&self, other: &Shell, vertices: &[Vec3], parts: &[Part], most: usize) -> bool {
        if !self.may_hold(other) {
            return false;
        }
        let corners = parts[other.part].triangles.as_flattened();
        let own = &parts[self.part].triangles;
        // A corner on a face has the winding number 0.5.
        let is_within = |&at: &u32| winding_number(vertices, own, &vertices[at as usize]).abs() > 0.75;
        if !own.iter().any(|t| other.may_meet(t.map(|index| &vertices[index as usize]))) {
            // No triangle meets the box of `other`, so all of that is within, or none of it.
            return corners.first().is_some_and(is_within);
        }
        let shared: HashSet<u32> = own.as_flattened().iter().copied().collect();
        let mut asked =
            corners.iter().step_by(corners.len().div_ceil(most)).filter(|at| !shared.contains(at)).peekable();
        asked.peek().is_some() && asked.all(is_within)
    }

    fn is_spacious(&self, vertices: &[Vec3], parts: &[Part]) -> bool {
        encloses(volume_and_area(vertices, &parts[self.part].triangles))
    }
}

fn encloses((volume, area): (f64, f64)) -> bool {
    volume.abs() > MIN_CAVITY_VOLUME_SHARE * area.powf(1.5)
}

/// Whether triangles enclose a cavity, that is, face inward.
pub(crate) fn face_inward(vertices: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let (volume, area) = volume_and_area(vertices, triangles);
    volume < 0.0 && encloses((volume, area))
}

/// Signed volume [m^3], positive if triangles face outward, and area [m^2].
pub(crate) fn volume_and_area(vertices: &[Vec3], triangles: &[[u32; 3]]) -> (f64, f64) {
    let Some(first) = triangles.first() else { return (0.0, 0.0) };
    let origin = vertices[first[0] as usize];
    triangles.iter().fold((0.0, 0.0), |(volume, area), t| {
        let [a, b, c] = t.map(|index| vertices[index as usize] - origin);
        (volume + a.dot(&b.cross(&c)) / 6.0, area + 0.5 * (b - a).cross(&(c - a)).norm())
    })
}

/// How often triangles wind around a point.
///
/// # Source
/// A. Van Oosterom and J. Strackee, "The solid angle of a plane triangle", 1983,
/// doi:10.1109/TBME.1983.325207.
pub(super) fn winding_number(vertices: &[Vec3], triangles: &[[u32; 3]], point: &Vec3) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|index| vertices[index as usize] - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests;

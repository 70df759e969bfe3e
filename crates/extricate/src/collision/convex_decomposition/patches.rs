//! Thin convex pieces along the surface of a mesh whose hollows convex cells fill. Its triangles
//! are split until the hull of each group follows the surface; groups are joined again if one hull
//! does.
//!
//! Together they hold the surface, not the inside of a solid.

use std::collections::{BTreeSet, HashMap};

use rayon::prelude::*;

use super::cells::{Divider, NOTCH_FACES, NOTCH_POINTS, ROUGH_NOTCH_FACES, distinct};
use super::surface_points::surface_points;
use crate::math::Vec3;
use crate::robot::TriangleMesh;

type Triangle = [Vec3; 3];

/// Groups of more triangles are halved in the middle: the exact place matters only once they are
/// small.
const MAX_TRIANGLES_COMPARED: usize = 96;
/// Points of the surface beside which notches are searched for while cuts are compared.
const ROUGH_NOTCH_POINTS: usize = 32;
/// Widest gaps per axis at which a group may be split.
const GAPS_PER_AXIS: usize = 4;
/// Triangles whose normals have a smaller cosine with that of the largest triangle are split from
/// it. Both values are tried.
const SAME_SIDE_COSINES: [f64; 2] = [0.9, 0.5];
/// Weight of the shallower side beside the deeper one when cuts are compared.
const SHALLOW_SIDE_WEIGHT: f64 = 0.2;
/// More patches than this are not joined: pairs of neighbours would be too many.
const MAX_JOINED_PATCHES: usize = 512;

pub struct Patch {
    triangles: Vec<Triangle>,
    pub hull: TriangleMesh,
    /// How far the hull stands out of the mesh \[m\].
    pub depth: f64,
}

/// Returns the groups of triangles that share corners.
pub fn connected(triangles: &[Triangle]) -> Vec<Vec<Triangle>> {
    fn root(parents: &mut [usize], mut at: usize) -> usize {
        while parents[at] != at {
            parents[at] = parents[parents[at]];
            at = parents[at];
        }
        at
    }
    let mut parents: Vec<usize> = (0..triangles.len()).collect();
    let mut first: HashMap<[u64; 3], usize> = HashMap::new();
    for (at, triangle) in triangles.iter().enumerate() {
        for point in triangle {
            let other = *first.entry(key(point)).or_insert(at);
            let (a, b) = (root(&mut parents, at), root(&mut parents, other));
            parents[a.max(b)] = a.min(b);
        }
    }
    let (mut places, mut groups): (HashMap<usize, usize>, Vec<Vec<Triangle>>) = Default::default();
    for (at, triangle) in triangles.iter().enumerate() {
        let place = *places.entry(root(&mut parents, at)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[place].push(*triangle);
    }
    groups
}

/// Returns the bits of a corner; equal corners have equal bits.
fn key(point: &Vec3) -> [u64; 3] {
    [point.x, point.y, point.z].map(|x| (x + 0.0).to_bits())
}

impl Divider<'_> {
    /// Returns the hull of triangles if it stands out of the mesh by no more than `tolerance`
    /// \[m\].
    pub fn convex(&self, triangles: &[Triangle], tolerance: f64) -> Option<TriangleMesh> {
        let (hull, depth) = self.measured(triangles, NOTCH_FACES, NOTCH_POINTS);
        (depth <= tolerance).then_some(hull)
    }

    /// Splits a group of triangles into patches that stand out of the mesh by no more than
    /// `tolerance` \[m\], or into `most` of them.
    pub fn patches(&self, triangles: Vec<Triangle>, tolerance: f64, most: usize) -> Vec<Patch> {
        let mut patches = vec![self.patch(triangles)];
        loop {
            // All patches that stand out too far are split at once, or only the deepest if `most`
            // allows no more.
            let mut deep: Vec<usize> = (0..patches.len()).filter(|at| patches[*at].depth > tolerance).collect();
            deep.sort_by(|i, j| patches[*j].depth.total_cmp(&patches[*i].depth).then(i.cmp(j)));
            deep.truncate(most.saturating_sub(patches.len()));
            if deep.is_empty() {
                return self.joined(patches, tolerance);
            }
            deep.sort_unstable();
            let parted: Vec<[Patch; 2]> = deep.par_iter().map(|at| self.parted(&patches[*at].triangles)).collect();
            for (at, [one, other]) in deep.into_iter().zip(parted) {
                patches[at] = one;
                patches.push(other);
            }
        }
    }

    fn patch(&self, triangles: Vec<Triangle>) -> Patch {
        let (hull, depth) = self.measured(&triangles, NOTCH_FACES, NOTCH_POINTS);
        Patch { triangles, hull, depth }
    }

    /// Returns the hull of triangles, and how far it stands out of the mesh \[m\].
    fn measured(&self, triangles: &[Triangle], faces: usize, points: usize) -> (TriangleMesh, f64) {
        let hull = self.hull(&distinct(triangles.iter().flatten().copied().collect()));
        if triangles.len() == 1 {
            return (hull, 0.0);
        }
        let notch = self.notch(&hull, faces, &surface_points(triangles, points), &mut Vec::new());
        (hull, notch.map_or(0.0, |notch| notch.depth))
    }

    /// Splits triangles into two groups: at the middle, at a gap, or by the direction they face,
    /// whichever leaves the least depth.
    fn parted(&self, triangles: &[Triangle]) -> [Patch; 2] {
        let middles: Vec<Vec3> = triangles.iter().map(|[a, b, c]| (a + b + c) / 3.0).collect();
        let order = |axis: usize| {
            let mut order: Vec<usize> = (0..triangles.len()).collect();
            order.sort_by(|i, j| middles[*i][axis].total_cmp(&middles[*j][axis]).then(i.cmp(j)));
            order
        };
        let first_of = |order: &[usize], count: usize| {
            let mut is_first = vec![false; triangles.len()];
            order[..count].iter().for_each(|at| is_first[*at] = true);
            is_first
        };
        let split = |is_first: &[bool]| {
            let mut sides = [Vec::new(), Vec::new()];
            triangles.iter().zip(is_first).for_each(|(t, is_first)| sides[usize::from(*is_first)].push(*t));
            sides
        };
        let (low, high) = middles.iter().fold((middles[0], middles[0]), |(low, high), p| (low.inf(p), high.sup(p)));
        let mut choices = vec![first_of(&order((high - low).imax()), triangles.len() / 2)];
        if triangles.len() <= MAX_TRIANGLES_COMPARED {
            for axis in [0, 1, 2] {
                let order = order(axis);
                let gap = |k: usize| middles[order[k]][axis] - middles[order[k - 1]][axis];
                let mut gaps: Vec<usize> = (1..order.len()).collect();
                gaps.sort_by(|i, j| gap(*j).total_cmp(&gap(*i)).then(i.cmp(j)));
                let wide = gaps.iter().copied().take(GAPS_PER_AXIS).filter(|k| gap(*k) > self.thickness);
                choices.extend(wide.chain([order.len() / 2]).map(|count| first_of(&order, count)));
            }
            let normal = |[a, b, c]: &Triangle| (b - a).cross(&(c - a));
            let largest = triangles.iter().map(normal).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
            let main = largest.and_then(|normal| normal.try_normalize(0.0)).unwrap_or_else(Vec3::x);
            let faces = |t: &Triangle, least: f64| normal(t).dot(&main).abs() > least * normal(t).norm();
            choices.extend(SAME_SIDE_COSINES.map(|least| triangles.iter().map(|t| faces(t, least)).collect()));
            choices.retain(|is_first: &Vec<bool>| is_first.contains(&true) && is_first.contains(&false));
        }
        let cost = |is_first: &Vec<bool>| {
            let [a, b] = split(is_first).map(|side| self.measured(&side, ROUGH_NOTCH_FACES, ROUGH_NOTCH_POINTS).1);
            a.max(b) + SHALLOW_SIDE_WEIGHT * a.min(b)
        };
        let best = match &choices[..] {
            [only] => only,
            _ => {
                let costs: Vec<f64> = choices.iter().map(cost).collect();
                let best = (0..costs.len()).min_by(|i, j| costs[*i].total_cmp(&costs[*j]));
                &choices[best.unwrap_or(0)]
            }
        };
        split(best).map(|side| self.patch(side))
    }

    /// Joins neighbours whose common hull follows the surface, those that fit best first.
    fn joined(&self, mut patches: Vec<Patch>, tolerance: f64) -> Vec<Patch> {
        while patches.len() <= MAX_JOINED_PATCHES {
            let corners: Vec<BTreeSet<[u64; 3]>> =
                patches.iter().map(|patch| patch.triangles.iter().flatten().map(key).collect()).collect();
            let follows = |at: usize| patches[at].depth <= tolerance;
            let are_neighbours = |i: usize, j: usize| corners[i].intersection(&corners[j]).nth(1).is_some();
            let all = (0..patches.len()).flat_map(|i| (i + 1..patches.len()).map(move |j| (i, j)));
            let pairs: Vec<(usize, usize)> =
                all.filter(|&(i, j)| follows(i) && follows(j) && are_neighbours(i, j)).collect();
            let joined = |(i, j): (usize, usize)| {
                let patch = self.patch([&patches[i].triangles[..], &patches[j].triangles].concat());
                (patch.depth <= tolerance).then_some((i, j, patch))
            };
            let mut found: Vec<(usize, usize, Patch)> = pairs.into_par_iter().filter_map(joined).collect();
            found.sort_by(|a, b| a.2.depth.total_cmp(&b.2.depth).then((a.0, a.1).cmp(&(b.0, b.1))));
            let (mut is_gone, mut new) = (vec![false; patches.len()], Vec::new());
            for (i, j, patch) in found {
                if !is_gone[i] && !is_gone[j] {
                    (is_gone[i], is_gone[j]) = (true, true);
                    new.push(patch);
                }
            }
            if new.is_empty() {
                break;
            }
            let kept = patches.into_iter().zip(is_gone).filter(|(_, is_gone)| !is_gone).map(|(patch, _)| patch);
            patches = kept.chain(new).collect();
        }
        patches
    }
}

//! Thin convex pieces along the surface of a mesh whose hollows convex cells fill: its triangles,
//! parted until the hull of each group follows the surface, then joined again where one hull does.
//!
//! Together they hold the surface, not the inside of a solid.

use std::collections::{BTreeSet, HashMap};

use rayon::prelude::*;

use super::cells::{Divider, FACES_GLANCED_AT, FACES_LOOKED_AT, POINTS_LOOKED_AT, distinct};
use super::surface_points::surface_points;
use crate::math::Vec3;
use crate::robot::TriangleMesh;

type Triangle = [Vec3; 3];

/// Groups of more triangles are halved in the middle: where exactly matters once they are small.
const FEW_TRIANGLES: usize = 96;
/// Points of the surface that are looked at while cuts are compared.
const POINTS_GLANCED_AT: usize = 32;
/// Widest gaps along an axis at which a group may be parted.
const GAPS: usize = 4;
/// Triangles whose normals have a smaller cosine with that of the largest one are parted from it.
const SAME_SIDE: [f64; 2] = [0.9, 0.5];
/// What the less deep side counts beside the deeper one if cuts are compared.
const OTHER_SIDE: f64 = 0.2;
/// Patches among which neighbours are looked for that are one: of more, the pairs are too many.
const MOST_JOINED: usize = 512;

/// A group of triangles and its hull.
pub struct Patch {
    triangles: Vec<Triangle>,
    pub hull: TriangleMesh,
    /// How far the hull stands out of the mesh \[m\].
    pub depth: f64,
}

/// Groups of triangles that share corners.
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

/// The bits of a corner: equal corners have equal ones.
fn key(point: &Vec3) -> [u64; 3] {
    [point.x, point.y, point.z].map(|x| (x + 0.0).to_bits())
}

impl Divider<'_> {
    /// The hull of triangles that stands out of the mesh by no more than `tolerance` \[m\], if it
    /// does not.
    pub fn convex(&self, triangles: &[Triangle], tolerance: f64) -> Option<TriangleMesh> {
        let (hull, depth) = self.measured(triangles, FACES_LOOKED_AT, POINTS_LOOKED_AT);
        (depth <= tolerance).then_some(hull)
    }

    /// Patches of a group of triangles that stand out of the mesh by less than `tolerance` \[m\],
    /// or `most` of them.
    pub fn patches(&self, triangles: Vec<Triangle>, tolerance: f64, most: usize) -> Vec<Patch> {
        let mut patches = vec![self.patch(triangles)];
        loop {
            // All that stand out too far at once; the deepest, if there is no room for all.
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
        let (hull, depth) = self.measured(&triangles, FACES_LOOKED_AT, POINTS_LOOKED_AT);
        Patch { triangles, hull, depth }
    }

    /// The hull of triangles, and how far it stands out of the mesh \[m\].
    fn measured(&self, triangles: &[Triangle], faces: usize, points: usize) -> (TriangleMesh, f64) {
        let hull = self.hull(&distinct(triangles.iter().flatten().copied().collect()));
        if triangles.len() == 1 {
            return (hull, 0.0);
        }
        let notch = self.notch(&hull, faces, &surface_points(triangles, points), &mut Vec::new());
        (hull, notch.map_or(0.0, |notch| notch.depth))
    }

    /// Two groups of triangles: those of a half, of one side of a gap, or that face another way,
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
        if triangles.len() <= FEW_TRIANGLES {
            for axis in [0, 1, 2] {
                let order = order(axis);
                let gap = |k: usize| middles[order[k]][axis] - middles[order[k - 1]][axis];
                let mut gaps: Vec<usize> = (1..order.len()).collect();
                gaps.sort_by(|i, j| gap(*j).total_cmp(&gap(*i)).then(i.cmp(j)));
                let wide = gaps.iter().copied().take(GAPS).filter(|k| gap(*k) > self.thickness);
                choices.extend(wide.chain([order.len() / 2]).map(|count| first_of(&order, count)));
            }
            let normal = |[a, b, c]: &Triangle| (b - a).cross(&(c - a));
            let largest = triangles.iter().map(normal).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
            let main = largest.and_then(|normal| normal.try_normalize(0.0)).unwrap_or_else(Vec3::x);
            let faces = |t: &Triangle, least: f64| normal(t).dot(&main).abs() > least * normal(t).norm();
            choices.extend(SAME_SIDE.map(|least| triangles.iter().map(|t| faces(t, least)).collect()));
            choices.retain(|is_first: &Vec<bool>| is_first.contains(&true) && is_first.contains(&false));
        }
        let cost = |is_first: &Vec<bool>| {
            let [a, b] = split(is_first).map(|side| self.measured(&side, FACES_GLANCED_AT, POINTS_GLANCED_AT).1);
            a.max(b) + OTHER_SIDE * a.min(b)
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

    /// Neighbours whose common hull follows the surface become one, those that fit best first.
    fn joined(&self, mut patches: Vec<Patch>, tolerance: f64) -> Vec<Patch> {
        while patches.len() <= MOST_JOINED {
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

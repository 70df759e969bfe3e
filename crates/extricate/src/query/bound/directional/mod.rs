//! The lower bound over the directions in which two convex bodies can part.
//!
//! In a free configuration, two bodies that overlap at the query have parted along some direction
//! `n`. Any two points that are chosen for `n` have then parted by `m - n . (a - b)`. That takes
//! the distance that [`least_reach`] proves, so
//!
//! `depth >= min over n of max over a, b of reach(n, a, b)`
//!
//! The minimum is over a sphere, however many degrees of freedom there are; [`Cells`] cover it.

use arrayvec::ArrayVec;

use super::cells::{Candidate, Cells, Parting};
use super::reach::{Curvature, ReachScratch, least_reach, reach_by_rate, rough_reaches};
use crate::collision::ConvexPair;
use crate::math::{LANES, Pose, Vec3, vectorized};
use crate::metric::Metric;
use crate::metric::pair_motion::{Lanes, PairMotion, PairMotions, lanes};
use crate::query::context::Context;
use crate::scene::MetricKind;

/// Memory that [`directional`] and [`promise`] reuse.
#[derive(Debug, Default)]
pub struct DirectionalScratch {
    motion: PairMotion,
    motions: PairMotions,
    reach: ReachScratch,
    cells: Cells,
}

/// Returns a distance (metric units), at most `ceiling`, below which the two sets cannot have
/// parted.
///
/// # Guarantee
/// Proved: the sets overlap at every configuration nearer than this.
pub fn directional(
    context: &Context,
    poses: &[Pose],
    pair: &ConvexPair,
    ceiling: f64,
    most_splits: usize,
    scratch: &mut DirectionalScratch,
) -> f64 {
    let DirectionalScratch { motion, motions, reach, cells } = scratch;
    let mut from_here = FromHere::of(context, poses, pair, ceiling, (motion, motions, reach));
    cells.cover(pair, None, &mut from_here, ceiling, most_splits).max(0.0)
}

/// Estimates the most that [`directional`] may prove, from the support points along 26 directions.
pub fn promise(
    context: &Context,
    poses: &[Pose],
    pair: &ConvexPair,
    ceiling: f64,
    scratch: &mut DirectionalScratch,
) -> f64 {
    let DirectionalScratch { motion, motions, reach, .. } = scratch;
    let mut from_here = FromHere::of(context, poses, pair, ceiling, (motion, motions, reach));
    let along = |k: usize| Vec3::new((k % 3) as f64 - 1.0, (k / 3 % 3) as f64 - 1.0, (k / 9) as f64 - 1.0).normalize();
    let directions = (0..27).filter(|k| *k != 13).map(along);
    let candidates: ArrayVec<Candidate<1>, 26> = directions
        .map(|n| {
            let [a, b] = pair.supports(&n);
            Candidate { points: [a, b], needs: [(n, pair.keeps() - n.dot(&(a - b)))] }
        })
        .collect();
    let least = |some: &[Candidate<1>]| from_here.rough(some, ceiling).into_iter().fold(ceiling, f64::min);
    candidates.chunks(LANES).map(least).fold(ceiling, f64::min)
}

struct FromHere<'a> {
    metric: &'a Metric,
    poses: &'a [Pose],
    motion: &'a mut PairMotion,
    /// Curvature of the placed points, computed on the first request.
    curvature: Option<Curvature>,
    ceiling: f64,
    motions: &'a mut PairMotions,
    memory: &'a mut ReachScratch,
}

impl<'a> FromHere<'a> {
    fn of(
        context: &'a Context<'a>,
        poses: &'a [Pose],
        pair: &ConvexPair,
        ceiling: f64,
        (motion, motions, memory): (&'a mut PairMotion, &'a mut PairMotions, &'a mut ReachScratch),
    ) -> Self {
        let (metric, scene) = (context.metric, context.checker.scene());
        let bodies = scene.pairs[pair.pair().index()];
        let frames = [bodies.first, bodies.second].map(|body| scene.bodies[body].frame);
        metric.pair_motion(poses, frames, |v| context.is_locked(v), motion);
        Self { metric, poses, motion, curvature: None, ceiling, motions, memory }
    }

    fn curvature(&mut self) -> Curvature {
        *self.curvature.get_or_insert_with(|| Curvature::of(self.motion, self.ceiling))
    }

    fn rough<const N: usize>(&mut self, candidates: &[Candidate<N>], enough: f64) -> Lanes {
        let mut bounds = [enough; LANES];
        let ceiling = self.ceiling;
        if self.metric.kind() != MetricKind::Joint {
            for (Candidate { points, needs }, bound) in candidates.iter().zip(&mut bounds) {
                self.place(points.each_ref());
                let distances = needs.map(|(_, needed)| reach_by_rate(self.motion, needed, ceiling));
                *bound = distances.into_iter().fold(*bound, f64::min);
            }
            return bounds;
        }
        let Self { motion, motions, .. } = self;
        let points: ArrayVec<[Vec3; 2], LANES> = candidates.iter().map(|candidate| candidate.points).collect();
        vectorized(
            #[inline(always)]
            || {
                motion.place_all(&points, ceiling, motions);
                for corner in 0..N {
                    let need = |lane: usize| &candidates.get(lane).unwrap_or(&candidates[0]).needs[corner];
                    let n = [0, 1, 2].map(|axis| lanes(|lane| need(lane).0[axis]));
                    let reaches = rough_reaches(motions, &n, &lanes(|lane| need(lane).1), ceiling);
                    bounds.iter_mut().zip(reaches).for_each(|(bound, reach)| *bound = bound.min(reach));
                }
            },
        );
        bounds
    }
}

impl Parting for FromHere<'_> {
    fn place(&mut self, points: [&Vec3; 2]) {
        self.metric.place_points(self.poses, points, self.motion);
        self.curvature = None;
    }

    fn least_distance(&mut self, needs: &[(Vec3, f64); 3], enough: f64) -> f64 {
        let curvature = self.curvature();
        least_reach(self.motion, &curvature, needs, (enough, self.ceiling), self.memory)
    }

    fn rough_distances(&mut self, candidates: &[Candidate], enough: f64) -> Lanes {
        self.rough(candidates, enough)
    }
}

#[cfg(test)]
mod tests;

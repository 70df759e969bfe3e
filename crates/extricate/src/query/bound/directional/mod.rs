//! The lower bound that looks at the direction in which two convex bodies part.
//!
//! In a free configuration, two bodies that overlap at the query have parted along some direction
//! `n`: for any two points chosen for it, by `m - n . (a - b)`. That takes the distance that
//! [`reach`] proves, so
//!
//! `depth >= min over n of max over a, b of reach(n, a, b)`
//!
//! The minimum is over a sphere, whatever the degrees of freedom; [`Cells`] cover it.

use super::cells::{Cells, Parting};
use super::reach::{Curvature, ReachScratch, linear_reach, reach, rough_reach};
use crate::collision::ConvexPair;
use crate::math::{Pose, Vec3};
use crate::metric::Metric;
use crate::metric::pair_motion::PairMotion;
use crate::query::context::Context;

/// Memory that bounds reuse.
#[derive(Debug, Default)]
pub struct DirectionalScratch {
    motion: PairMotion,
    reach: ReachScratch,
    cells: Cells,
}

/// A distance (metric units) below which the two sets cannot have parted, at most `ceiling`.
///
/// # Guarantee
/// Proved, for every configuration nearer than it.
pub fn directional(
    context: &Context,
    poses: &[Pose],
    pair: &ConvexPair,
    ceiling: f64,
    most_splits: usize,
    scratch: &mut DirectionalScratch,
) -> f64 {
    let DirectionalScratch { motion, reach, cells } = scratch;
    let mut from_here = FromHere::of(context, poses, pair, ceiling, (motion, reach));
    cells.cover(pair, None, &mut from_here, ceiling, most_splits).max(0.0)
}

/// About the most that [`directional`] may come to: what the points that are supported along a few
/// directions bound there.
pub fn promise(
    context: &Context,
    poses: &[Pose],
    pair: &ConvexPair,
    ceiling: f64,
    scratch: &mut DirectionalScratch,
) -> f64 {
    let DirectionalScratch { motion, reach, .. } = scratch;
    let mut from_here = FromHere::of(context, poses, pair, ceiling, (motion, reach));
    let mut least = ceiling;
    for k in (0..27).filter(|k| *k != 13) {
        let n = Vec3::new((k % 3) as f64 - 1.0, (k / 3 % 3) as f64 - 1.0, (k / 9) as f64 - 1.0).normalize();
        let [a, b] = pair.supports(&n);
        from_here.place([&a, &b]);
        let needed = pair.keeps() - n.dot(&(a - b));
        if from_here.linear_distance(&n, needed) < least {
            least = least.min(from_here.rough_distance(&n, needed));
        }
    }
    least
}

struct FromHere<'a> {
    metric: &'a Metric,
    poses: &'a [Pose],
    motion: &'a mut PairMotion,
    /// Of the points that are looked at, once it is requested.
    curvature: Option<Curvature>,
    ceiling: f64,
    memory: &'a mut ReachScratch,
}

impl<'a> FromHere<'a> {
    fn of(
        context: &'a Context<'a>,
        poses: &'a [Pose],
        pair: &ConvexPair,
        ceiling: f64,
        (motion, memory): (&'a mut PairMotion, &'a mut ReachScratch),
    ) -> Self {
        let (metric, scene) = (context.metric, context.checker.scene());
        let bodies = scene.pairs[pair.pair().index()];
        let frames = [bodies.first, bodies.second].map(|body| scene.bodies[body].frame);
        metric.pair_motion(poses, frames, |v| context.is_locked(v), motion);
        Self { metric, poses, motion, curvature: None, ceiling, memory }
    }

    fn curvature(&mut self) -> Curvature {
        *self.curvature.get_or_insert_with(|| Curvature::of(self.motion, self.ceiling))
    }
}

impl Parting for FromHere<'_> {
    fn place(&mut self, points: [&Vec3; 2]) {
        self.metric.place_points(self.poses, points, self.motion);
        self.curvature = None;
    }

    fn linear_distance(&mut self, n: &Vec3, needed: f64) -> f64 {
        linear_reach(self.motion, n, needed)
    }

    fn distance(&mut self, n: &Vec3, needed: f64, enough: f64) -> f64 {
        let curvature = self.curvature();
        reach(self.motion, &curvature, n, needed, (enough, self.ceiling), self.memory)
    }

    fn rough_distance(&mut self, n: &Vec3, needed: f64) -> f64 {
        let curvature = self.curvature();
        rough_reach(self.motion, &curvature, n, needed, self.ceiling)
    }
}

#[cfg(test)]
mod tests;

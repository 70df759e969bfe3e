//! The proved lower bound on the penetration depth.
//!
//! A ball inside a link whose centre lies deep in a solid must travel at least
//! `depth + radius + clearance` before the pair is clear. Two convex shapes of penetration depth
//! `p` stay in collision while no point of one moves, relative to the other, by `p + clearance`.
//! Otherwise a plane that separates them afterwards, moved back by that much, would have separated
//! them before. The motion bound turns these lengths into distances between configurations.
//!
//! Read next: `inner_balls`, `combined` (all bounds together), `directional` (the bound by
//! directions), `cells`, `reach`, `branch_and_bound`.

pub mod branch_and_bound;
mod cells;
pub mod combined;
mod directional;
mod half_spaces;
pub mod proof;
pub(crate) mod reach;

use std::cmp::Ordering;

use super::context::Context;
use super::inner_balls::{BALLS, Balls, QUICK_BALLS, SURFACE_POINTS};
use crate::collision::{CheckScratch, ConvexOverlap};
use crate::math::{LANES, Pose, vectorized};
use crate::metric::motion_bound::{BoundedPoint, MotionPath};
use crate::scene::MetricKind;

const MAX_BLOCKS: usize = (BALLS + SURFACE_POINTS).div_ceil(LANES);

/// How much work a bound by balls may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundEffort {
    /// Uses a few balls of each body. Depths in a mesh come from the balls inside it, and distances
    /// from one chord of the motion bound.
    Quick,
    /// Uses all balls and their depths in the solid itself.
    Close,
}

/// Raises `bound` by the penetration depth of two convex shapes. The motion bound is a convex
/// function of the point, so over a shape it is largest at a corner of any box around the shape.
fn raise_by_overlap(
    context: &Context,
    overlap: &ConvexOverlap,
    poses: &[Pose],
    mut bound: f64,
    ceiling: f64,
    path: &mut MotionPath,
) -> f64 {
    let scene = context.checker.scene();
    let pair = scene.pairs[overlap.pair.index()];
    let frames = [scene.bodies[pair.first].frame, scene.bodies[pair.second].frame];
    let needed = overlap.depth + context.checker.clearance_of(overlap.pair.index());
    for (of, relative_to, corners) in
        [(frames[0], frames[1], overlap.corners[0]), (frames[1], frames[0], overlap.corners[1])]
    {
        context.metric.motion_between(poses, of, relative_to, path);
        let mut allowed = ceiling;
        for position in corners {
            let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
            context.metric.motion_of(poses, &point, path);
            if path.bound(allowed) >= needed {
                let start = bound + MIN_GAIN_SHARE * allowed;
                let low = (start, path.bound(start));
                allowed = distance_along(path, low, allowed, needed, BoundEffort::Close).unwrap_or(bound);
            }
            if allowed <= bound {
                break;
            }
        }
        bound = bound.max(allowed);
    }
    bound
}

/// Raises `bound` by the balls of one body in the solid of another.
fn raise(
    context: &Context,
    ([carrier, solid], clearance): ([usize; 2], f64),
    poses: &[Pose],
    mut bound: f64,
    (look, ceiling): (BoundEffort, f64),
    path: &mut MotionPath,
    check: &mut CheckScratch,
) -> f64 {
    let scene = context.checker.scene();
    let (of, relative_to) = (scene.bodies[carrier].frame, scene.bodies[solid].frame);
    let Balls { all, blocks } = &*context.balls.bodies[carrier];
    let most_balls = if look == BoundEffort::Quick { QUICK_BALLS } else { usize::MAX };
    // Depths in the triangles of a mesh take longer than all else. Open meshes hold no balls.
    let inside = Some(&*context.balls.bodies[solid])
        .filter(|inside| look == BoundEffort::Quick && !context.checker.is_convex(solid) && inside.hold_some());
    let pose_solid_carrier = poses[relative_to].inverse().then(&poses[of]);
    context.metric.motion_between(poses, of, relative_to, path);
    let levers = path.levers();
    let mut start = bound + MIN_GAIN_SHARE * ceiling;
    // Balls that may prove most go first: the others then seldom need an exact depth.
    let (mut order, mut count) = ([BallPromise::default(); BALLS + SURFACE_POINTS], 0);
    vectorized(
        #[inline(always)]
        || {
            let mut depths = [[0.0; LANES]; MAX_BLOCKS];
            let blocks = &blocks[..most_balls.min(all.len()).div_ceil(LANES)];
            let (centres, depths) = (blocks.iter().map(|block| &block.centres), &mut depths[..blocks.len()]);
            match inside {
                Some(balls) => balls.depths(&pose_solid_carrier, centres, depths),
                None => context.checker.solid_depth_bounds(solid, &pose_solid_carrier, centres, depths),
            }
            for ((first, block), depths) in (0..).step_by(LANES).zip(blocks).zip(depths) {
                let rates = levers.squared_rates(&poses[of].points(&block.centres));
                let (mut mosts, mut squares) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    mosts[lane] = depths[lane] + block.radii[lane] + clearance;
                    squares[lane] = mosts[lane] * mosts[lane] / rates[lane];
                }
                for (lane, (most, square)) in mosts.into_iter().zip(squares).enumerate() {
                    if most > 0.0 && square > start * start && first + lane < most_balls {
                        order[count] = BallPromise { square, most, at: first + lane };
                        count += 1;
                    }
                }
            }
        },
    );
    let order = &mut order[..count];
    order.sort_unstable_by(BallPromise::greatest_first);
    for &BallPromise { square, most, at } in order.iter() {
        let ball = &all[at];
        if square <= start * start {
            break;
        }
        let (position, point_solid) = (poses[of].point(&ball.centre), pose_solid_carrier.point(&ball.centre));
        let mut point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: true };
        context.metric.motion_of(poses, &point, path);
        let mut low = (start, path.bound(start));
        // Even if its centre moves as little as a point of the solid, the ball is too shallow.
        if most <= low.1 {
            continue;
        }
        let besides = ball.radius + clearance;
        let depth = match inside {
            Some(_) => Some(most - besides),
            None => context.checker.solid_depth_above(solid, &point_solid, low.1 - besides, check),
        };
        let Some(depth) = depth else { continue };
        if depth < 0.0 && context.metric.kind() == MetricKind::MaxDisplacement {
            point.inside_relative_to = false;
            context.metric.motion_of(poses, &point, path);
            low.1 = path.bound(start);
        }
        let needed = depth + besides;
        bound = distance_along(path, low, ceiling, needed, look).unwrap_or(bound);
        start = bound + MIN_GAIN_SHARE * ceiling;
    }
    bound
}

/// An upper bound on what a ball may prove, from boxes around solids and from levers alone.
#[derive(Clone, Copy, Default)]
struct BallPromise {
    /// Square of the distance between configurations that the ball cannot exceed; infinite if the
    /// levers bound nothing.
    square: f64,
    /// Upper bound on how far the ball has to move \[m\].
    most: f64,
    at: usize,
}

impl BallPromise {
    fn greatest_first(&self, other: &Self) -> Ordering {
        other.square.total_cmp(&self.square).then(other.most.total_cmp(&self.most)).then(self.at.cmp(&other.at))
    }
}

/// Stops raising a bound once it can gain at most this share of its ceiling.
const MIN_GAIN_SHARE: f64 = 1e-4;

/// Share by which quotients are lowered to stay below the exact ones after rounding.
const ROUNDING: f64 = 1e-12;

/// Returns nearly the largest distance in `[low.0, ceiling]` within which a path moves by less than
/// `needed`; see [`largest_distance`]. If motion is proportional to distance, it is their quotient,
/// whatever `low` is.
pub fn distance_along(
    path: &mut MotionPath,
    low: (f64, f64),
    ceiling: f64,
    needed: f64,
    look: BoundEffort,
) -> Option<f64> {
    let Some(factor) = path.factor() else {
        return largest_distance(low, ceiling, needed, look, |d| path.bound(d));
    };
    let quotient = (needed / factor * (1.0 - ROUNDING)).min(ceiling);
    (quotient > low.0).then_some(quotient)
}

/// Returns nearly the largest distance in `[low.0, ceiling]` for which `moved` is below `needed`,
/// or `None` if there is none. `low.1` is `moved(low.0)`.
///
/// `moved` has to grow from 0 and be convex, as motion bounds are. It is then at least proportional
/// beyond `low`, which bounds the search; and a chord lies above it, so it meets `needed` on the
/// safe side. Near-linear functions take two or three steps. A quick bound takes the first chord
/// without evaluating `moved` there, which loses 0.003 of the bound.
pub fn largest_distance(
    mut low: (f64, f64),
    ceiling: f64,
    needed: f64,
    look: BoundEffort,
    mut moved: impl FnMut(f64) -> f64,
) -> Option<f64> {
    if ceiling <= low.0 || low.1 >= needed {
        return None;
    }
    let end = ceiling.min(low.0 * (needed / low.1));
    let mut high = (end, moved(end));
    if high.1 < needed {
        return Some(end);
    }
    for _ in 0..20 {
        let share = (needed - low.1) / (high.1 - low.1);
        let middle = low.0 + (high.0 - low.0) * (share * (1.0 - 1e-9));
        if look == BoundEffort::Quick {
            return Some(middle);
        }
        let at = moved(middle);
        let gained = middle - low.0;
        if at < needed {
            low = (middle, at);
        } else {
            high = (middle, at);
        }
        if gained <= MIN_GAIN_SHARE * ceiling {
            break;
        }
    }
    Some(low.0)
}

#[cfg(test)]
mod tests;

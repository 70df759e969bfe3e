//! The proved lower bound on the penetration depth.
//!
//! A ball inside a link whose centre lies deep in a solid must travel at least `depth + radius + clearance` before the pair
//! is clear. And two convex shapes of penetration depth `p` stay in collision while no point of one moves, relative to the other,
//! by `p + clearance`: a plane that parts them afterwards, moved back by that much, would part them before. The motion bound
//! turns these lengths into distances between configurations.
//!
//! Read next: `bound` (what proves what), `directional` (the bound by directions), `cells`, `reach`,
//! `branches` (branch and bound), `groups`.

pub mod bound;
pub mod branches;
mod cells;
mod directional;
pub mod groups;
mod half_spaces;
mod interior;
mod reach;

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;

use super::context::Context;
use crate::collision::{CheckScratch, Checker, ConvexOverlap};
use crate::math::{LANES, Pose, Vec3, vectorized};
use crate::metric::motion_bound::{BoundedPoint, MotionPath};
use crate::scene::MetricSpec;

/// Balls inside every body of a scene, computed once.
pub struct InteriorBalls {
    bodies: Vec<Arc<Balls>>,
    /// The same balls in coordinates of the solids, for scenes in which they stand elsewhere; and
    /// where the solids are.
    solids: Vec<(Arc<[Ball]>, Pose)>,
}

/// Those of a body: the first few are large and spread out, the others follow by size.
struct Balls {
    all: Vec<Ball>,
    /// The same, for vector instructions.
    blocks: Vec<BallBlock>,
}

/// Eight balls; a place without one has the radius minus infinity.
struct BallBlock {
    /// Frame coordinates \[m\], axis by axis.
    centres: [[f64; LANES]; 3],
    /// \[m\].
    radii: [f64; LANES],
}

/// A ball inside a body.
#[derive(Debug, Clone, Copy)]
struct Ball {
    /// Frame coordinates \[m\].
    centre: Vec3,
    /// \[m\]; 0 for a point of the surface.
    radius: f64,
}

/// Most balls a body.
const BALLS: usize = 24;
/// Balls a body that a quick bound looks at, the first.
const QUICK_BALLS: usize = 6;
/// Surface points a body, spread out.
const SURFACE_POINTS: usize = 24;
/// Blocks of them.
const MOST_BLOCKS: usize = (BALLS + SURFACE_POINTS).div_ceil(LANES);

/// Share of a radius by which the distance from a centre may be wrong that is told by a power: more than the root of the rounding errors of two squares.
const LOST: f64 = 4e-8;

/// How closely a bound looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// At a few balls of each body; balls inside a mesh tell how deep they lie in it, and one chord of the motion bound how far that is.
    Quick,
    /// At all balls, and at how deep they lie.
    Close,
}

impl InteriorBalls {
    /// Looks for balls in every body of the checker's scene, on a grid and on the surface; takes
    /// those of `before` where it has the same solid.
    pub fn new(checker: &Checker, before: Option<(&Checker, &Self)>) -> Self {
        let count = checker.scene().bodies.len();
        let twins = before.map_or_else(|| vec![None; count], |(old, _)| checker.same_solids(old));
        let known = |body: usize| Some(Arc::clone(&before?.1.solids[twins[body]?].0));
        let first = checker.first_of_equal_solids();
        let of_first =
            |body: usize| known(body).or_else(|| (first[body] == body).then(|| interior::balls(checker, body).into()));
        let made: Vec<Option<Arc<[Ball]>>> = (0..count).into_par_iter().map(of_first).collect();
        let of_equal = |body: usize| made[body].clone().or_else(|| made[first[body]].clone());
        let solid = |body: usize| (of_equal(body).unwrap_or_default(), checker.pose_frame_solid(body));
        let solids: Vec<(Arc<[Ball]>, Pose)> = (0..count).map(solid).collect();
        let unmoved = |body: usize| {
            let (twin, known) = (twins[body]?, before?.1);
            (known.solids[twin].1 == solids[body].1).then(|| Arc::clone(&known.bodies[twin]))
        };
        let placed = |body: usize| Balls::new(&solids[body].1, &solids[body].0).into();
        let bodies = (0..count).map(|body| unmoved(body).unwrap_or_else(|| placed(body))).collect();
        Self { bodies, solids }
    }
}

impl Balls {
    fn new(pose_frame_solid: &Pose, solid: &[Ball]) -> Self {
        let placed = |ball: &Ball| Ball { centre: pose_frame_solid.point(&ball.centre), ..*ball };
        let all: Vec<Ball> = solid.iter().map(placed).collect();
        let blocks = all.chunks(LANES).map(BallBlock::new).collect();
        Self { all, blocks }
    }

    /// Whether there are any but points of the surface.
    fn hold_some(&self) -> bool {
        self.all.first().is_some_and(|ball| ball.radius > 0.0)
    }

    /// Lower bounds \[m\] on the signed depth of points in the solid, eight an entry, given axis by axis in a frame with the pose `pose_body_points`;
    /// into `depths`, as far as that is long: how deep they lie in one of the balls.
    #[inline(always)]
    fn depths<'a>(
        &self,
        pose_body_points: &Pose,
        points: impl Iterator<Item = &'a [[f64; LANES]; 3]>,
        depths: &mut [[f64; LANES]],
    ) {
        for (points, depths) in points.zip(depths) {
            let [x, y, z] = pose_body_points.points(points);
            // Of the ball of greatest power, which is mostly the one that the point lies deepest in, and takes no root to find.
            let (mut powers, mut radii) = ([f64::NEG_INFINITY; LANES], [0.0; LANES]);
            for Ball { centre, radius } in self.all.iter().take_while(|ball| ball.radius > 0.0) {
                for lane in 0..LANES {
                    let (dx, dy, dz) = (x[lane] - centre.x, y[lane] - centre.y, z[lane] - centre.z);
                    let power = radius * radius - (dx * dx + dy * dy + dz * dz);
                    let is_greater = power > powers[lane];
                    radii[lane] = if is_greater { *radius } else { radii[lane] };
                    powers[lane] = if is_greater { power } else { powers[lane] };
                }
            }
            for lane in 0..LANES {
                let square = radii[lane] * radii[lane] - powers[lane];
                // Near a centre, half of the digits of its distance are lost.
                depths[lane] = radii[lane] * (1.0 - LOST) - (if square > 0.0 { square } else { 0.0 }).sqrt();
            }
        }
    }
}

impl BallBlock {
    fn new(balls: &[Ball]) -> Self {
        let mut block = Self { centres: [[0.0; LANES]; 3], radii: [f64::NEG_INFINITY; LANES] };
        for (lane, ball) in balls.iter().enumerate() {
            (0..3).for_each(|axis| block.centres[axis][lane] = ball.centre[axis]);
            block.radii[lane] = ball.radius;
        }
        block
    }
}

/// Raises `bound` by the penetration depth of two convex shapes. The motion bound is a convex function of the point, so over a
/// shape it is largest at a corner of any box around it.
fn raise_by_overlap(
    context: &Context,
    overlap: &ConvexOverlap,
    poses: &[Pose],
    mut bound: f64,
    ceiling: f64,
    path: &mut MotionPath,
) -> f64 {
    let scene = context.checker.scene();
    let pair = scene.pairs[overlap.pair];
    let frames = [scene.bodies[pair.first].frame, scene.bodies[pair.second].frame];
    let needed = overlap.depth + context.checker.clearance_of(overlap.pair);
    for (of, relative_to, corners) in
        [(frames[0], frames[1], overlap.corners[0]), (frames[1], frames[0], overlap.corners[1])]
    {
        context.metric.motion_between(poses, of, relative_to, path);
        // The least of what the corners allow.
        let mut allowed = ceiling;
        for position in corners {
            let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
            context.metric.motion_of(poses, &point, path);
            if path.bound(allowed) >= needed {
                let start = bound + STEP * allowed;
                let low = (start, path.bound(start));
                allowed = largest_distance(low, allowed, needed, Look::Close, |d| path.bound(d)).unwrap_or(bound);
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
    (look, ceiling): (Look, f64),
    path: &mut MotionPath,
    check: &mut CheckScratch,
) -> f64 {
    let scene = context.checker.scene();
    let (of, relative_to) = (scene.bodies[carrier].frame, scene.bodies[solid].frame);
    let Balls { all, blocks } = &*context.balls.bodies[carrier];
    let most_balls = if look == Look::Quick { QUICK_BALLS } else { usize::MAX };
    // A look at the triangles of a mesh takes longer than all else; open ones hold no balls.
    let inside = Some(&*context.balls.bodies[solid])
        .filter(|inside| look == Look::Quick && !context.checker.is_convex(solid) && inside.hold_some());
    let pose_solid_carrier = poses[relative_to].inverse().then(&poses[of]);
    context.metric.motion_between(poses, of, relative_to, path);
    let levers = path.levers();
    let mut start = bound + STEP * ceiling;
    // Those that may prove most first: the others then seldom need a look.
    let (mut order, mut count) = ([Promise::default(); BALLS + SURFACE_POINTS], 0);
    vectorized(
        #[inline(always)]
        || {
            let mut depths = [[0.0; LANES]; MOST_BLOCKS];
            let blocks = &blocks[..most_balls.min(all.len()).div_ceil(LANES)];
            let centres = blocks.iter().map(|block| &block.centres);
            let depths = &mut depths[..blocks.len()];
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
                        order[count] = Promise { square, most, at: first + lane };
                        count += 1;
                    }
                }
            }
        },
    );
    let order = &mut order[..count];
    order.sort_unstable_by(Promise::greatest_first);
    for &Promise { square, most, at } in order.iter() {
        let ball = &all[at];
        if square <= start * start {
            break;
        }
        let (position, point_solid) = (poses[of].point(&ball.centre), pose_solid_carrier.point(&ball.centre));
        let mut point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: true };
        context.metric.motion_of(poses, &point, path);
        let mut low = (start, path.bound(start));
        // Too shallow to raise the bound, even if the point moves as little as one inside would.
        if most <= low.1 {
            continue;
        }
        let besides = ball.radius + clearance;
        let depth = match inside {
            Some(_) => Some(most - besides),
            None => context.checker.solid_depth_above(solid, &point_solid, low.1 - besides, check),
        };
        let Some(depth) = depth else { continue };
        if depth < 0.0 && context.metric.kind() == MetricSpec::MaxDisplacement {
            point.inside_relative_to = false;
            context.metric.motion_of(poses, &point, path);
            low.1 = path.bound(start);
        }
        let needed = depth + besides;
        bound = largest_distance(low, ceiling, needed, look, |d| path.bound(d)).unwrap_or(bound);
        start = bound + STEP * ceiling;
    }
    bound
}

/// What a ball may prove, seen from boxes around solids and from levers alone.
#[derive(Clone, Copy, Default)]
struct Promise {
    /// Square of a distance between configurations that the ball proves no more than; infinite where levers tell nothing.
    square: f64,
    /// Farthest that the ball may have to go \[m\].
    most: f64,
    /// Which ball.
    at: usize,
}

impl Promise {
    fn greatest_first(&self, other: &Self) -> Ordering {
        other.square.total_cmp(&self.square).then(other.most.total_cmp(&self.most)).then(self.at.cmp(&other.at))
    }
}

/// A bound that can be raised by less than this share of its ceiling is left.
const STEP: f64 = 1e-4;

/// The largest distance in `[low.0, ceiling]`, up to a little, for which `moved` is below `needed`: seen, or in a quick look by convexity
/// alone. `None` where there is none. `low.1` is `moved(low.0)`.
///
/// `moved` grows from 0 and is convex, as motion bounds are. So it is at least proportional beyond `low`, which tells where to stop
/// looking; and a chord lies above it and so meets `needed` on the safe side. Near-linear ones take two or three steps; a quick look takes the
/// first chord and does not look there: 0.003 of the bound is lost.
pub fn largest_distance(
    mut low: (f64, f64),
    ceiling: f64,
    needed: f64,
    look: Look,
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
        if look == Look::Quick {
            return Some(middle);
        }
        let at = moved(middle);
        let gained = middle - low.0;
        if at < needed {
            low = (middle, at);
        } else {
            high = (middle, at);
        }
        if gained <= STEP * ceiling {
            break;
        }
    }
    Some(low.0)
}

#[cfg(test)]
mod tests;

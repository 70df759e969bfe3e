//! Balls inside bodies, from which bounds prove how far bodies overlap.

use std::sync::Arc;

use rayon::prelude::*;

use crate::collision::{Checker, largest_balls, shared_shape};
use crate::math::{LANES, Pose, Vec3};

/// Balls inside every body of a scene, computed once.
pub struct InnerBalls {
    /// Balls of each body.
    pub bodies: Vec<Arc<Balls>>,
    /// The same balls in coordinates of the solids, and the pose of each solid in its frame. Scenes
    /// in which solids are placed elsewhere reuse them.
    solids: Vec<(Arc<[Ball]>, Pose)>,
}

/// Balls of a body: the first few are large and spread out, the others follow by size, and points
/// of the surface end the list.
pub struct Balls {
    /// The balls one after another.
    pub all: Vec<Ball>,
    /// The same balls, eight a block, for vector instructions.
    pub blocks: Vec<BallBlock>,
}

/// Eight balls; an unused lane has the radius minus infinity.
pub struct BallBlock {
    /// Centres in frame coordinates \[m\], axis by axis.
    pub centres: [[f64; LANES]; 3],
    /// Radii of the balls \[m\].
    pub radii: [f64; LANES],
}

/// A ball inside a body.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Centre in frame coordinates \[m\].
    pub centre: Vec3,
    /// Radius \[m\]; 0 for a point of the surface.
    pub radius: f64,
}

/// Most balls with a positive radius in each body.
pub const BALLS: usize = 24;
/// Number of balls of each body, the first ones, that a quick bound uses (lab L097).
pub const QUICK_BALLS: usize = 6;
/// Most points on the surface of each body, spread out.
pub const SURFACE_POINTS: usize = 24;
/// Share of the radius by which rounding may falsify a distance from the centre that is computed
/// from a power. It exceeds the root of the rounding errors of two squares.
const CENTRE_ROUNDING: f64 = 4e-8;

impl InnerBalls {
    /// Finds balls in every body of the checker's scene, and points on its surface. Reuses those of
    /// `before` for bodies with the same solid.
    pub fn new(checker: &Checker, before: Option<(&Checker, &Self)>) -> Self {
        let scene = checker.scene();
        let count = scene.bodies.len();
        let twins = before.map_or_else(|| vec![None; count], |(old, _)| checker.same_solids(old));
        let known = |body: usize| Some(Arc::clone(&before?.1.solids[twins[body]?].0));
        let first = checker.first_of_equal_solids();
        let of_first = |body: usize| known(body).or_else(|| (first[body] == body).then(|| balls(checker, body).into()));
        let is_shared =
            |body: usize| scene.bodies[body].parts.iter().any(|part| shared_shape(&part.geometry).is_some());
        // A change of the scene that adds no mesh needs no threads.
        let made: Vec<Option<Arc<[Ball]>>> = match before {
            Some(_) if !(0..count).any(|body| known(body).is_none() && is_shared(body)) => {
                (0..count).map(of_first).collect()
            }
            _ => (0..count).into_par_iter().map(of_first).collect(),
        };
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

    /// Whether the body holds balls with a positive radius.
    pub fn hold_some(&self) -> bool {
        self.all.first().is_some_and(|ball| ball.radius > 0.0)
    }

    /// Writes lower bounds \[m\] on the signed depth of points in the solid to `depths`, as far as
    /// that is long: their depths in one of the balls. Each entry of `points` holds eight points,
    /// axis by axis, in a frame with the pose `pose_body_points`.
    #[inline(always)]
    pub fn depths<'a>(
        &self,
        pose_body_points: &Pose,
        points: impl Iterator<Item = &'a [[f64; LANES]; 3]>,
        depths: &mut [[f64; LANES]],
    ) {
        for (points, depths) in points.zip(depths) {
            let [x, y, z] = pose_body_points.points(points);
            // The point is mostly deepest in the ball of greatest power, which needs no root to
            // find.
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
                // Half of the digits of the distance are lost near a centre.
                depths[lane] = radii[lane] * (1.0 - CENTRE_ROUNDING) - (if square > 0.0 { square } else { 0.0 }).sqrt();
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

/// Returns the balls of a body in coordinates of its solid.
fn balls(checker: &Checker, body: usize) -> Vec<Ball> {
    // A grid finds no balls in scenery, which may be unbounded, and depths of links in it are
    // cheap.
    if checker.scene().bodies[body].parts.iter().any(|part| part.geometry.is_scenery()) {
        return Vec::new();
    }
    let pose_frame_solid = checker.pose_frame_solid(body);
    let mut vertices = Vec::new();
    for part in &checker.scene().bodies[body].parts {
        let mesh = part.geometry.tessellate(8);
        let pose_solid_part = pose_frame_solid.inverse().then(&part.pose_frame_part);
        vertices.extend(mesh.vertices.iter().map(|v| pose_solid_part.point(v)));
    }
    let low = vertices.iter().fold(Vec3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let high = vertices.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    let depth = |centre: &Vec3| checker.solid_depth(body, &pose_frame_solid.point(centre));
    let inside = largest_balls(&low, &high, BALLS, depth);
    let mut chosen: Vec<Ball> = inside.into_iter().map(|(centre, radius)| Ball { centre, radius }).collect();
    spread_first(&mut chosen, QUICK_BALLS);
    chosen.extend(spread(&vertices, SURFACE_POINTS).into_iter().map(|centre| Ball { centre, radius: 0.0 }));
    chosen
}

/// Brings `count` balls to the front that are large and far from each other, after the largest. By
/// size alone they might lie side by side, as those of a ring are all equally large.
fn spread_first(balls: &mut [Ball], count: usize) {
    for at in 1..count.min(balls.len()) {
        let worth = |ball: &Ball| {
            let gaps = balls[..at].iter().map(|other| (ball.centre - other.centre).norm());
            ball.radius * ball.radius * gaps.fold(f64::INFINITY, f64::min)
        };
        let best = (at..balls.len()).max_by(|a, b| worth(&balls[*a]).total_cmp(&worth(&balls[*b])));
        balls[at..=best.unwrap_or(at)].rotate_right(1);
    }
}

/// Selects up to `count` points by farthest-point sampling.
fn spread(points: &[Vec3], count: usize) -> Vec<Vec3> {
    let Some(first) = points.first() else { return Vec::new() };
    let mut chosen = vec![*first];
    let mut gap: Vec<f64> = points.iter().map(|p| (p - first).norm()).collect();
    while chosen.len() < count {
        let (at, distance) = gap.iter().enumerate().fold((0, 0.0), |a, (i, g)| if *g > a.1 { (i, *g) } else { a });
        if distance <= 0.0 {
            break;
        }
        chosen.push(points[at]);
        gap.iter_mut().zip(points).for_each(|(g, p)| *g = g.min((p - points[at]).norm()));
    }
    chosen
}

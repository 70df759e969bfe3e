//! Balls inside bodies, of which bounds look how deep they lie in others, and which balls and
//! points of the surface those are.

use std::sync::Arc;

use rayon::prelude::*;

use crate::collision::{Checker, largest_balls, shared_shape};
use crate::math::{LANES, Pose, Vec3};

/// Balls inside every body of a scene, computed once.
pub struct InnerBalls {
    /// Of each body.
    pub bodies: Vec<Arc<Balls>>,
    /// The same balls in coordinates of the solids, for scenes in which they stand elsewhere; and
    /// where the solids are.
    solids: Vec<(Arc<[Ball]>, Pose)>,
}

/// Those of a body: the first few are large and spread out, the others follow by size.
pub struct Balls {
    /// One by one.
    pub all: Vec<Ball>,
    /// The same, for vector instructions.
    pub blocks: Vec<BallBlock>,
}

/// Eight balls; a place without one has the radius minus infinity.
pub struct BallBlock {
    /// Frame coordinates \[m\], axis by axis.
    pub centres: [[f64; LANES]; 3],
    /// \[m\].
    pub radii: [f64; LANES],
}

/// A ball inside a body.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Frame coordinates \[m\].
    pub centre: Vec3,
    /// \[m\]; 0 for a point of the surface.
    pub radius: f64,
}

/// Most balls a body.
pub const BALLS: usize = 24;
/// Balls a body that a quick bound looks at, the first.
pub const QUICK_BALLS: usize = 6;
/// Surface points a body, spread out.
pub const SURFACE_POINTS: usize = 24;
/// Share of a radius by which the distance from a centre may be wrong that is told by a power: more
/// than the root of the rounding errors of two squares.
const CENTRE_ROUNDING: f64 = 4e-8;

impl InnerBalls {
    /// Looks for balls in every body of the checker's scene, on a grid and on the surface;
    /// takes those of `before` where it has the same solid.
    pub fn new(checker: &Checker, before: Option<(&Checker, &Self)>) -> Self {
        let scene = checker.scene();
        let count = scene.bodies.len();
        let twins = before.map_or_else(|| vec![None; count], |(old, _)| checker.same_solids(old));
        let known = |body: usize| Some(Arc::clone(&before?.1.solids[twins[body]?].0));
        let first = checker.first_of_equal_solids();
        let of_first = |body: usize| known(body).or_else(|| (first[body] == body).then(|| balls(checker, body).into()));
        let is_shared =
            |body: usize| scene.bodies[body].parts.iter().any(|part| shared_shape(&part.geometry).is_some());
        // A change that brings no mesh needs no threads.
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

    /// Whether there are any but points of the surface.
    pub fn hold_some(&self) -> bool {
        self.all.first().is_some_and(|ball| ball.radius > 0.0)
    }

    /// Lower bounds \[m\] on the signed depth of points in the solid, eight an entry, given axis by
    /// axis in a frame with the pose `pose_body_points`; into `depths`, as far as that is long: how
    /// deep they lie in one of the balls.
    #[inline(always)]
    pub fn depths<'a>(
        &self,
        pose_body_points: &Pose,
        points: impl Iterator<Item = &'a [[f64; LANES]; 3]>,
        depths: &mut [[f64; LANES]],
    ) {
        for (points, depths) in points.zip(depths) {
            let [x, y, z] = pose_body_points.points(points);
            // Of the ball of greatest power, which is mostly the one that the point lies deepest
            // in, and takes no root to find.
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

/// Those of a body, in coordinates of its solid.
fn balls(checker: &Checker, body: usize) -> Vec<Ball> {
    // Of what may have no end a grid finds nothing, and how deep the links lie in it is told at
    // once.
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

/// Brings `count` balls to the front, after the largest, that are large and far from each other: of
/// a ring, whose balls are all as large, not six side by side.
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

/// Farthest-point sampling.
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

//! Points of each frame's geometry that can move farthest: hull vertices, balls and rims.
//!
//! The displacement between two poses is an affine function of the point. Its length is convex, so
//! an extreme point of the geometry attains the maximum.

use std::f64::consts::TAU;

use crate::math::elementary::sin_cos;
use crate::math::{LANES, Mat3, Pose, Vec3, vectorized};
use crate::robot::Geometry;
use crate::robot::mesh::convex_hull::convex_hull;
use crate::scene::{Part, Scene};

/// Extreme points of every moving frame that carries geometry.
#[derive(Debug, Clone, Default)]
pub struct Extremes {
    /// Extreme points by frame, in the order of the scene's frames.
    pub frames: Vec<FrameExtremes>,
}

/// Extreme points of one frame, in frame coordinates \[m\].
#[derive(Debug, Clone, Default)]
pub struct FrameExtremes {
    /// Index of the frame.
    pub frame: usize,
    /// Vertices of the hull of all polyhedral parts.
    pub points: Vec<Vec3>,
    /// Centre and radius of each ball \[m\].
    pub balls: Vec<(Vec3, f64)>,
    /// Centre and two orthogonal radii of each circle \[m\].
    pub circles: Vec<(Vec3, Vec3, Vec3)>,
    /// Finite set of points: all vertices of polyhedra, and samples of balls and rims.
    pub samples: Vec<Vec3>,
    /// `samples` in blocks of eight, axis by axis; the last sample fills the last block up.
    pub(super) blocks: Vec<[[f64; LANES]; 3]>,
    /// Centre of a ball around all of the frame's geometry \[m\].
    pub centre: Vec3,
    /// Radius of that ball \[m\].
    pub radius: f64,
}

impl Extremes {
    /// Collects the extreme points of all moving geometry.
    pub fn new(scene: &Scene) -> Self {
        let mut frames = Vec::new();
        for frame in 1..scene.frames.len() {
            let mut extremes = FrameExtremes { frame, ..Default::default() };
            for part in scene.bodies.iter().filter(|body| body.frame == frame).flat_map(|body| &body.parts) {
                extremes.add(part);
            }
            if let Some(hull) = convex_hull(&extremes.points) {
                extremes.points = hull.vertices;
            }
            extremes.samples = extremes.sample_points();
            extremes.bound();
            if !extremes.samples.is_empty() {
                frames.push(extremes);
            }
        }
        Self { frames }
    }

    /// Returns the entry of `frames` with the point that moves farthest between two sets of poses;
    /// `None` if no moving frame carries geometry.
    pub fn farthest_frame(&self, from: &[Pose], to: &[Pose]) -> Option<usize> {
        let moved = |f: &FrameExtremes| f.max_displacement(&from[f.frame], &to[f.frame]);
        (0..self.frames.len()).max_by(|a, b| moved(&self.frames[*a]).total_cmp(&moved(&self.frames[*b])))
    }

    /// Returns the largest displacement \[m\] of any point between two sets of frame poses.
    pub fn max_displacement(&self, from: &[Pose], to: &[Pose]) -> f64 {
        let mut worst = 0.0;
        // Frames far from the base usually move most; the bound then rules most others out.
        for frame in self.frames.iter().rev() {
            let (from, to) = (&from[frame.frame], &to[frame.frame]);
            if frame.displacement_bound(from, to) > worst {
                worst = f64::max(worst, frame.max_displacement(from, to));
            }
        }
        worst
    }
}

/// A point that moves far between two sets of poses.
#[derive(Debug, Clone, Copy)]
pub struct FarPoint {
    /// Index of the frame that carries the point.
    pub frame: usize,
    /// Position after the motion, in world coordinates \[m\].
    pub now: Vec3,
    /// Displacement in world coordinates \[m\].
    pub moved: Vec3,
    /// Length of the displacement \[m\].
    pub distance: f64,
}

/// Points that move far, and buffers for finding them.
#[derive(Debug, Clone, Default)]
pub struct FarPoints {
    /// The points by frame, farthest first within each.
    pub points: Vec<FarPoint>,
    /// Squared displacements of a frame's samples, in blocks of eight \[m^2\].
    squares: Vec<[f64; LANES]>,
    largest: Vec<f64>,
}

/// Points that move less than this share of the largest displacement are not far.
const FAR_SHARE: f64 = 0.8;
const MAX_POINTS_PER_FRAME: usize = 4;
/// Two far points of a frame are at least this share of its radius apart; nearer ones move alike.
const SEPARATION_SHARE: f64 = 0.15;

impl Extremes {
    /// Finds the samples that move farthest, no two of one frame near each other.
    pub fn farthest(&self, from: &[Pose], to: &[Pose], far: &mut FarPoints) {
        let FarPoints { points, squares, largest } = far;
        points.clear();
        let displacement = |f: &FrameExtremes| displacement(&from[f.frame], &to[f.frame]);
        largest.clear();
        largest.extend(self.frames.iter().map(|f| largest_squared(&displacement(f), &f.blocks)));
        let least = FAR_SHARE * FAR_SHARE * largest.iter().copied().fold(0.0, f64::max);
        for (frame, largest) in self.frames.iter().zip(largest) {
            if *largest < least || *largest == 0.0 {
                continue;
            }
            let map = displacement(frame);
            squares.resize(frame.blocks.len(), [0.0; LANES]);
            all_lengths_squared(&map, &frame.blocks, squares);
            let apart = (SEPARATION_SHARE * frame.radius).powi(2);
            // No sample is near a point at infinity, so this only finds the largest.
            let (mut at, mut square) = forget_near(&Vec3::repeat(f64::INFINITY), 0.0, &frame.blocks, squares);
            for _ in 0..MAX_POINTS_PER_FRAME {
                if square < least {
                    break;
                }
                let point = frame.samples[at.min(frame.samples.len() - 1)];
                let (now, moved) = (to[frame.frame].point(&point), map.point(&point));
                points.push(FarPoint { frame: frame.frame, now, moved, distance: square.sqrt() });
                (at, square) = forget_near(&point, apart, &frame.blocks, squares);
            }
        }
    }
}

impl FrameExtremes {
    fn add(&mut self, part: &Part) {
        let pose = &part.pose_frame_part;
        let z = |length: f64| pose.point(&Vec3::new(0.0, 0.0, length));
        match &part.geometry {
            Geometry::Sphere { radius } => self.balls.push((pose.translation, *radius)),
            Geometry::Capsule { radius, half_length } => {
                self.balls.push((z(-half_length), *radius));
                self.balls.push((z(*half_length), *radius));
            }
            Geometry::Cylinder { radius, half_length } => {
                let (x, y) = (pose.vector(&Vec3::x()) * *radius, pose.vector(&Vec3::y()) * *radius);
                self.circles.push((z(-half_length), x, y));
                self.circles.push((z(*half_length), x, y));
            }
            Geometry::Box { half_extents } => {
                for corner in 0..8 {
                    let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    self.points.push(pose.point(&Vec3::from(*half_extents).component_mul(&Vec3::new(
                        sign(0),
                        sign(1),
                        sign(2),
                    ))));
                }
            }
            Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => {
                self.points.extend(mesh.vertices.iter().map(|x| pose.point(x)));
            }
            // All other shapes are scenery, which does not move.
            _ => {}
        }
    }

    fn sample_points(&self) -> Vec<Vec3> {
        let mut points = self.points.clone();
        for (centre, radius) in &self.balls {
            points.push(*centre);
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                points.extend([centre + axis * *radius, centre - axis * *radius]);
            }
        }
        for (centre, x, y) in &self.circles {
            points.extend((0..12).map(|k| circle_point(centre, x, y, TAU * k as f64 / 12.0)));
        }
        points
    }

    /// Computes the ball around all geometry, and the blocks of samples.
    fn bound(&mut self) {
        let block = |points: &[Vec3]| {
            let at = |axis: usize| std::array::from_fn(|lane| points[lane.min(points.len() - 1)][axis]);
            [at(0), at(1), at(2)]
        };
        self.blocks = self.samples.chunks(LANES).map(block).collect();
        let low = self.samples.iter().fold(Vec3::repeat(f64::INFINITY), |a, b| a.inf(b));
        let high = self.samples.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
        self.centre = 0.5 * (low + high);
        let points = self.points.iter().map(|p| (p - self.centre).norm());
        let balls = self.balls.iter().map(|(c, r)| (c - self.centre).norm() + r);
        let circles = self.circles.iter().map(|(c, x, _)| (c - self.centre).norm() + x.norm());
        self.radius = points.chain(balls).chain(circles).fold(0.0, f64::max);
    }

    /// Bounds the displacement of all points by that of the ball's centre plus the effect of the
    /// rotation at the ball's surface.
    fn displacement_bound(&self, from: &Pose, to: &Pose) -> f64 {
        let turn = to.rotation - from.rotation;
        let shift = turn * self.centre + to.translation - from.translation;
        shift.norm() + self.radius * (0.5 * turn.norm_squared()).sqrt()
    }

    fn max_displacement(&self, from: &Pose, to: &Pose) -> f64 {
        let displacement = displacement(from, to);
        let turn = &displacement.rotation;
        let move_of = |p: &Vec3| displacement.point(p);
        let mut worst = largest_squared(&displacement, &self.blocks);
        for (centre, radius) in &self.balls {
            worst = worst.max(ball_displacement_squared(turn, &move_of(centre), *radius));
        }
        for (centre, x, y) in &self.circles {
            worst = worst.max(circle_displacement_squared(&move_of(centre), &(turn * x), &(turn * y)));
        }
        worst.sqrt()
    }
}

/// Returns the map from points in frame coordinates to their displacements; it is no rigid pose.
fn displacement(from: &Pose, to: &Pose) -> Pose {
    Pose { rotation: to.rotation - from.rotation, translation: to.translation - from.translation }
}

fn circle_point(centre: &Vec3, x: &Vec3, y: &Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = sin_cos(angle);
    centre + x * cos + y * sin
}

/// Returns the largest `|move_centre + turn y|^2` over `|y| = radius` for a difference `turn` of
/// two rotations.
///
/// Such a difference maps the ball to a disc of radius `sigma r` in the plane normal to the axis of
/// the relative rotation, with `turn turn' = sigma^2 (1 - n n')`. The maximum is therefore
/// `axial^2 + (planar + sigma r)^2` with the axial and planar parts of `move_centre`.
fn ball_displacement_squared(turn: &Mat3, move_centre: &Vec3, radius: f64) -> f64 {
    let sigma_squared = 0.5 * turn.norm_squared();
    if sigma_squared < 1e-30 {
        return move_centre.norm_squared();
    }
    let planar_squared = (turn.tr_mul(move_centre)).norm_squared() / sigma_squared;
    let axial_squared = (move_centre.norm_squared() - planar_squared).max(0.0);
    axial_squared + (planar_squared.sqrt() + radius * sigma_squared.sqrt()).powi(2)
}

/// Maps eight points and returns the squared lengths of the results.
#[inline(always)]
fn lengths_squared(map: &Pose, block: &[[f64; LANES]; 3]) -> [f64; LANES] {
    let [x, y, z] = map.points(block);
    let mut squares = [0.0; LANES];
    for lane in 0..LANES {
        squares[lane] = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
    }
    squares
}

fn all_lengths_squared(map: &Pose, blocks: &[[[f64; LANES]; 3]], squares: &mut [[f64; LANES]]) {
    vectorized(
        #[inline(always)]
        || {
            for (block, squares) in blocks.iter().zip(squares) {
                *squares = lengths_squared(map, block);
            }
        },
    );
}

/// Returns the largest squared length of the mapped points, 0 if there are none.
fn largest_squared(map: &Pose, blocks: &[[[f64; LANES]; 3]]) -> f64 {
    let largest = vectorized(
        #[inline(always)]
        || {
            let mut largest = [0.0; LANES];
            for block in blocks {
                keep_larger(&mut largest, &lengths_squared(map, block));
            }
            largest
        },
    );
    largest.into_iter().fold(0.0, f64::max)
}

#[inline(always)]
fn keep_larger(largest: &mut [f64; LANES], values: &[f64; LANES]) {
    for lane in 0..LANES {
        largest[lane] = if values[lane] > largest[lane] { values[lane] } else { largest[lane] };
    }
}

/// Zeroes the squares of points within `sqrt(apart)` of `point`. Returns the index of the largest
/// remaining square over all blocks, and its value.
fn forget_near(point: &Vec3, apart: f64, blocks: &[[[f64; LANES]; 3]], squares: &mut [[f64; LANES]]) -> (usize, f64) {
    let (largest, at) = vectorized(
        #[inline(always)]
        || {
            // The block of each lane's largest is an `f64`, so that both are selected alike.
            let (mut largest, mut at) = ([0.0; LANES], [0.0; LANES]);
            for (index, ([x, y, z], squares)) in blocks.iter().zip(squares).enumerate() {
                for lane in 0..LANES {
                    let [dx, dy, dz] = [x[lane] - point.x, y[lane] - point.y, z[lane] - point.z];
                    let is_near = dx * dx + dy * dy + dz * dz <= apart;
                    let square = if is_near { 0.0 } else { squares[lane] };
                    let is_larger = square > largest[lane];
                    squares[lane] = square;
                    largest[lane] = if is_larger { square } else { largest[lane] };
                    at[lane] = if is_larger { index as f64 } else { at[lane] };
                }
            }
            (largest, at)
        },
    );
    let lanes = 0..LANES;
    let lane = lanes.fold(0, |best, lane| if largest[lane] > largest[best] { lane } else { best });
    (at[lane] as usize * LANES + lane, largest[lane])
}

/// Returns the largest `|c + x cos t + y sin t|^2`, which has up to two peaks. Climbs from each of
/// 16 angles that is no lower than its neighbours. A step is Newton's on the derivative, or uphill
/// if that one is unusable, and is halved until it gains.
fn circle_displacement_squared(c: &Vec3, x: &Vec3, y: &Vec3) -> f64 {
    const ANGLE_STEP_RAD: f64 = TAU / 16.0;
    let value = |t: f64| circle_point(c, x, y, t).norm_squared();
    let values: [f64; 16] = std::array::from_fn(|k| value(ANGLE_STEP_RAD * k as f64));
    let is_peak = |k: &usize| values[*k] >= values[(*k + 1) % 16] && values[*k] >= values[(*k + 15) % 16];
    let climb = |k: usize| {
        let mut best = (ANGLE_STEP_RAD * k as f64, values[k]);
        for _ in 0..12 {
            let (sin, cos) = sin_cos(best.0);
            let (point, first) = (c + x * cos + y * sin, y * cos - x * sin);
            let slope = point.dot(&first);
            let curvature = first.norm_squared() - point.dot(&(x * cos + y * sin));
            let newton = -slope / curvature;
            let is_uphill = curvature < 0.0 && newton.abs() < ANGLE_STEP_RAD;
            let step = if is_uphill { newton } else { ANGLE_STEP_RAD.copysign(slope) };
            let mut steps = (0..24).map(|halvings| best.0 + step * 0.5_f64.powi(halvings));
            let Some(t) = steps.find(|t| value(*t) > best.1) else { break };
            best = (t, value(t));
        }
        best.1
    };
    (0..16).filter(is_peak).map(climb).fold(0.0, f64::max)
}

#[cfg(test)]
mod circle_tests {
    use super::*;

    /// Small displacements of the centre give two peaks of nearly the same height.
    #[test]
    fn no_point_of_a_circle_moves_farther() {
        for case in 0..2000 {
            let at = |k: usize| ((case * 7 + k) as f64 * 0.618_033_988_75).fract() - 0.5;
            let small = if case % 2 == 0 { 1e-3 } else { 1.0 };
            let c = Vec3::new(at(0), at(1), at(2)) * small;
            let (x, y) = (Vec3::new(at(3), at(4), at(5)), Vec3::new(at(6), at(7), at(8)));
            let largest = circle_displacement_squared(&c, &x, &y);
            let most = (0..4000).map(|k| circle_point(&c, &x, &y, TAU * f64::from(k) / 4000.0).norm_squared());
            let most = most.fold(0.0, f64::max);
            assert!(largest >= most * (1.0 - 1e-12) && largest <= most * (1.0 + 1e-5), "{case}: {largest} {most}");
        }
    }
}

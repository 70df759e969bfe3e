//! The points of each frame's geometry that can move farthest: vertices of convex hulls, balls and
//! rims.
//!
//! Between two poses the displacement is an affine function of the point, so its length is convex
//! and attained at an extreme point of the geometry.

use std::f64::consts::TAU;

use crate::math::elementary::sin_cos;
use crate::math::{LANES, Mat3, Pose, Vec3, vectorized};
use crate::robot::Geometry;
use crate::robot::mesh::convex_hull::convex_hull;
use crate::scene::{Part, Scene};

/// Extreme points of every moving frame that carries geometry.
#[derive(Debug, Clone, Default)]
pub struct Extremes {
    /// In the order of the scene's frames.
    pub frames: Vec<FrameExtremes>,
}

/// Extreme points of one frame, in frame coordinates \[m\].
#[derive(Debug, Clone, Default)]
pub struct FrameExtremes {
    /// Index of the frame.
    pub frame: usize,
    /// Vertices of the hull of all polyhedral parts.
    pub points: Vec<Vec3>,
    /// Centres and radii.
    pub balls: Vec<(Vec3, f64)>,
    /// Circles: centre and two orthogonal radii.
    pub circles: Vec<(Vec3, Vec3, Vec3)>,
    /// A finite set that stands for all of them: exact for polyhedra, samples of balls and rims.
    pub samples: Vec<Vec3>,
    /// The same by eights, axis by axis; the last one fills up.
    pub(super) blocks: Vec<[[f64; LANES]; 3]>,
    /// A ball around all of it: centre and radius.
    pub centre: Vec3,
    /// \[m\]
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

    /// Index of the frame with the point that moves farthest between two sets of poses; `None`
    /// where nothing moves.
    pub fn farthest_frame(&self, from: &[Pose], to: &[Pose]) -> Option<usize> {
        let moved = |f: &FrameExtremes| f.max_displacement(&from[f.frame], &to[f.frame]);
        (0..self.frames.len()).max_by(|a, b| moved(&self.frames[*a]).total_cmp(&moved(&self.frames[*b])))
    }

    /// Largest displacement \[m\] of any moving point between two sets of frame poses.
    pub fn max_displacement(&self, from: &[Pose], to: &[Pose]) -> f64 {
        let mut worst = 0.0;
        // Frames far from the base move most as a rule; the others then mostly need no look.
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
    /// Index of its frame.
    pub frame: usize,
    /// Where it is then, in world coordinates \[m\].
    pub now: Vec3,
    /// By what it moved, and how far \[m\].
    pub moved: Vec3,
    /// \[m\]
    pub distance: f64,
}

/// Points that move far, and what finding them takes.
#[derive(Debug, Clone, Default)]
pub struct FarPoints {
    /// Farthest first within a frame.
    pub points: Vec<FarPoint>,
    /// Of each sample of a frame, by eights \[m^2\].
    squares: Vec<[f64; LANES]>,
    largest: Vec<f64>,
}

/// Points that move less than this share of the largest displacement do not count as far.
const FAR_SHARE: f64 = 0.8;
/// Most far points of a frame.
const MOST_POINTS: usize = 4;
/// Points of one frame that are nearer to each other than this share of its size tell the same.
const SAME_PLACE: f64 = 0.15;

impl Extremes {
    /// The samples that move farthest, none near another of its frame.
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
            let apart = (SAME_PLACE * frame.radius).powi(2);
            // Nothing is near what is at infinity.
            let (mut at, mut square) = forget_near(&Vec3::repeat(f64::INFINITY), 0.0, &frame.blocks, squares);
            for _ in 0..MOST_POINTS {
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
            // Scenery does not move.
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

    /// Puts a ball around everything, and samples into blocks.
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

    /// No point moves farther than this: the centre's displacement and what the turn adds at the
    /// ball's rim.
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

/// Maps points in frame coordinates to their displacements.
fn displacement(from: &Pose, to: &Pose) -> Pose {
    Pose { rotation: to.rotation - from.rotation, translation: to.translation - from.translation }
}

fn circle_point(centre: &Vec3, x: &Vec3, y: &Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = sin_cos(angle);
    centre + x * cos + y * sin
}

/// Largest `|move_centre + turn y|^2` over `|y| = radius`, where `turn` is a difference of two
/// rotations.
///
/// Such a difference maps the ball to a disc of radius `sigma r` in the plane normal to the axis of
/// the relative rotation, with `turn turn' = sigma^2 (1 - n n')`; so the answer is the axial part
/// plus (the planar part + the disc's radius).
fn ball_displacement_squared(turn: &Mat3, move_centre: &Vec3, radius: f64) -> f64 {
    let sigma_squared = 0.5 * turn.norm_squared();
    if sigma_squared < 1e-30 {
        return move_centre.norm_squared();
    }
    let planar_squared = (turn.tr_mul(move_centre)).norm_squared() / sigma_squared;
    let axial_squared = (move_centre.norm_squared() - planar_squared).max(0.0);
    axial_squared + (planar_squared.sqrt() + radius * sigma_squared.sqrt()).powi(2)
}

/// Squared lengths of what `map` makes of eight points.
#[inline(always)]
fn lengths_squared(map: &Pose, block: &[[f64; LANES]; 3]) -> [f64; LANES] {
    let [x, y, z] = map.points(block);
    let mut squares = [0.0; LANES];
    for lane in 0..LANES {
        squares[lane] = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
    }
    squares
}

/// The same of all blocks.
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

/// The largest of them, 0 of none.
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

/// Sets the squares of points within the root of `apart` of `point` to 0; the largest of the rest,
/// and where it is, counted through.
fn forget_near(point: &Vec3, apart: f64, blocks: &[[[f64; LANES]; 3]], squares: &mut [[f64; LANES]]) -> (usize, f64) {
    let (largest, at) = vectorized(
        #[inline(always)]
        || {
            // The block of each lane's largest, as a number, to be chosen like one.
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

/// Largest `|c + x cos t + y sin t|^2`, which has up to two peaks. Each of 16 angles that is no
/// lower than its neighbours is climbed from by steps of Newton's method on the derivative, or
/// uphill if those lead nowhere; each step is halved until it gains something.
fn circle_displacement_squared(c: &Vec3, x: &Vec3, y: &Vec3) -> f64 {
    const BETWEEN: f64 = TAU / 16.0;
    let value = |t: f64| circle_point(c, x, y, t).norm_squared();
    let values: [f64; 16] = std::array::from_fn(|k| value(BETWEEN * k as f64));
    let is_peak = |k: &usize| values[*k] >= values[(*k + 1) % 16] && values[*k] >= values[(*k + 15) % 16];
    let climb = |k: usize| {
        let mut best = (BETWEEN * k as f64, values[k]);
        for _ in 0..12 {
            let (sin, cos) = sin_cos(best.0);
            let (point, first) = (c + x * cos + y * sin, y * cos - x * sin);
            let slope = point.dot(&first);
            let curvature = first.norm_squared() - point.dot(&(x * cos + y * sin));
            let newton = -slope / curvature;
            let is_uphill = curvature < 0.0 && newton.abs() < BETWEEN;
            let step = if is_uphill { newton } else { BETWEEN.copysign(slope) };
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

    /// Two peaks that are nearly as high, and every kind of circle.
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

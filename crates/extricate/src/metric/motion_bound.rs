//! How far a point can move while the configuration moves by a given distance: what turns lengths into proofs.

use super::Metric;
use crate::math::{Pose, Vec3};
use crate::scene::{MetricSpec, Motion, Scene};

/// Memory that motion bounds reuse.
#[derive(Debug, Clone, Default)]
pub struct MotionScratch {
    reach: Vec<f64>,
    path: Vec<usize>,
}

impl Metric {
    /// Upper bound \[m\] on the displacement of a point, fixed to frame `of` and seen from frame `relative_to` (0: the world),
    /// between a configuration with frame poses `poses` and any other within `distance` (metric units) of it.
    ///
    /// # Guarantee
    /// Proved for every such configuration; grows with `distance`.
    ///
    /// Joint metric: the joints between the two frames are walked outward from the point. A joint that turns by `delta`
    /// moves the point by at most `reach * delta`, where `reach` is the present distance of the point from the axis plus
    /// what the joints nearer to the point can have moved it by; Cauchy and Schwarz sum them up. Object norm: see
    /// [`super::solids::FrameSolid::motion_factor`]; for two moving frames the squares add, since their shares of the volume do.
    /// Largest displacement: one per moving frame where the point lies in its hull (`inside`), otherwise as the object norm.
    pub fn motion_bound(
        &self,
        poses: &[Pose],
        point: &BoundedPoint,
        distance: f64,
        scratch: &mut MotionScratch,
    ) -> f64 {
        match self.kind() {
            MetricSpec::Joint => joint_bound(self.scene(), self.coordinate_uses(), poses, point, distance, scratch),
            MetricSpec::ObjectNorm => distance * self.factor(poses, point, false),
            MetricSpec::MaxDisplacement => distance * self.factor(poses, point, true),
        }
    }

    /// `sqrt` of the sum of squared factors for the object norm; their sum for the largest displacement, where a frame whose
    /// hull holds the point counts 1.
    fn factor(&self, poses: &[Pose], point: &BoundedPoint, largest: bool) -> f64 {
        let of_frame = |frame: usize, inside: bool| {
            if frame == 0 {
                return 0.0;
            }
            if largest && inside {
                return 1.0;
            }
            let solid = self.solids().frames.iter().find(|s| s.frame == frame);
            let spread = poses[frame].inverse_point(&point.position);
            solid.map_or(f64::INFINITY, |s| s.motion_factor(&spread))
        };
        let a = of_frame(point.of, point.inside_of);
        let b = of_frame(point.relative_to, point.inside_relative_to);
        if largest { a + b } else { a.hypot(b) }
    }
}

/// A point and the two frames between which its motion is bounded.
#[derive(Debug, Clone, Copy)]
pub struct BoundedPoint {
    /// World coordinates \[m\] at the present configuration.
    pub position: Vec3,
    /// The frame that it is fixed to.
    pub of: usize,
    /// The frame from which it is seen; 0 for the world.
    pub relative_to: usize,
    /// Whether it lies in the convex hull of what `of` carries.
    pub inside_of: bool,
    /// Whether it lies in the convex hull of what `relative_to` carries.
    pub inside_relative_to: bool,
}

/// What the joint metric's bound needs to know of a tangent coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct CoordinateUse {
    weight: f64,
    /// Whether several frames move with it (mimic joints).
    shared: bool,
}

/// One entry a tangent coordinate.
pub(super) fn coordinate_uses(scene: &Scene) -> Vec<CoordinateUse> {
    let mut uses = vec![CoordinateUse { weight: 1.0, shared: false }; scene.space.nv()];
    scene.space.factors().iter().for_each(|f| uses[f.v].weight = f.weight);
    let mut seen = vec![false; uses.len()];
    for frame in &scene.frames {
        if let Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } = &frame.motion {
            uses[coordinate.v].shared |= std::mem::replace(&mut seen[coordinate.v], true);
        }
    }
    uses
}

fn joint_bound(
    scene: &Scene,
    uses: &[CoordinateUse],
    poses: &[Pose],
    point: &BoundedPoint,
    distance: f64,
    scratch: &mut MotionScratch,
) -> f64 {
    let MotionScratch { reach, path } = scratch;
    chain(scene, point.of, point.relative_to, path);
    reach.clear();
    reach.resize(uses.len(), 0.0);
    let mut slides = OrthogonalSlides::default();
    // Squared displacement per squared distance of the joints walked so far.
    let mut squared: f64 = 0.0;
    for &frame in path.iter() {
        let pose = &poses[frame];
        let arm = point.position - pose.translation;
        let (v, step) = match &scene.frames[frame].motion {
            Motion::World => continue,
            Motion::Prismatic { axis, coordinate } => {
                let (v, slide) = (coordinate.v, coordinate.multiplier.abs());
                if !uses[v].shared {
                    squared += slides.add(&pose.vector(axis), slide * slide / uses[v].weight);
                    continue;
                }
                (v, slide)
            }
            Motion::Revolute { axis, coordinate } => {
                let lever = pose.vector(axis).cross(&arm).norm() + distance * squared.sqrt();
                (coordinate.v, coordinate.multiplier.abs() * lever)
            }
            Motion::Ball { v, .. } => (*v, arm.norm() + distance * squared.sqrt()),
        };
        slides = OrthogonalSlides::default();
        // A mimic joint adds to the reach of the coordinate that it shares.
        let before = reach[v];
        reach[v] += step;
        squared += (reach[v] * reach[v] - before * before) / uses[v].weight;
    }
    distance * squared.max(0.0).sqrt()
}

/// Consecutive prismatic joints along orthogonal axes, which no turn comes between: their displacements are the legs of a right
/// angle, so together they count as much as the one that counts most.
#[derive(Default)]
struct OrthogonalSlides {
    axes: [Vec3; 3],
    count: usize,
    most: f64,
}

impl OrthogonalSlides {
    /// Adds a slide along `axis`; returns by how much the sum of squares grows.
    fn add(&mut self, axis: &Vec3, square: f64) -> f64 {
        if self.count == 3 || self.axes[..self.count].iter().any(|other| other.dot(axis).abs() > 1e-12) {
            *self = Self::default();
        }
        self.axes[self.count] = *axis;
        self.count += 1;
        let grown = (square - self.most).max(0.0);
        self.most += grown;
        grown
    }
}

/// Frames whose joints lie between `of` and `relative_to`, from `of` up to the common ancestor and down to the other.
fn chain(scene: &Scene, of: usize, relative_to: usize, path: &mut Vec<usize>) {
    path.clear();
    let (mut a, mut b) = (of, relative_to);
    // A parent precedes its children, so the larger index is never an ancestor of the smaller one.
    while a != b {
        if a > b {
            path.push(a);
            a = scene.frames[a].parent;
        } else {
            b = scene.frames[b].parent;
        }
    }
    let turn = path.len();
    let mut b = relative_to;
    while b != a {
        path.push(b);
        b = scene.frames[b].parent;
    }
    path[turn..].reverse();
}

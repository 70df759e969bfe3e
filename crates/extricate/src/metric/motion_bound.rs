//! How far a point can move while the configuration moves by a given distance: what turns lengths into proofs.

use super::Metric;
use crate::math::{Pose, Vec3};
use crate::scene::{MetricSpec, Motion, Scene};

/// Memory that motion bounds reuse.
#[derive(Debug, Clone, Default)]
pub struct MotionScratch {
    reach: Vec<f64>,
    weights: Vec<f64>,
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
            MetricSpec::Joint => joint_bound(self.scene(), poses, point, distance, scratch),
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

fn joint_bound(scene: &Scene, poses: &[Pose], point: &BoundedPoint, distance: f64, scratch: &mut MotionScratch) -> f64 {
    let MotionScratch { reach, weights, path } = scratch;
    chain(scene, point.of, point.relative_to, path);
    reach.clear();
    reach.resize(scene.space.nv(), 0.0);
    if weights.len() != reach.len() {
        weights.clear();
        weights.resize(reach.len(), 1.0);
        scene.space.factors().iter().for_each(|f| weights[f.v] = f.weight);
    }
    // Squared displacement per squared distance of the joints walked so far; a mimic joint shares the coordinate of another.
    let mut squared: f64 = 0.0;
    for &frame in path.iter() {
        let arm = point.position - poses[frame].translation;
        let (v, step) = match &scene.frames[frame].motion {
            Motion::World => continue,
            Motion::Prismatic { coordinate, .. } => (coordinate.v, coordinate.multiplier.abs()),
            Motion::Revolute { axis, coordinate } => {
                let lever = poses[frame].vector(axis).cross(&arm).norm() + distance * squared.sqrt();
                (coordinate.v, coordinate.multiplier.abs() * lever)
            }
            Motion::Ball { v, .. } => (*v, arm.norm() + distance * squared.sqrt()),
        };
        let before = reach[v];
        reach[v] += step;
        squared += (reach[v] * reach[v] - before * before) / weights[v];
    }
    distance * squared.max(0.0).sqrt()
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

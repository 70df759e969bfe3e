//! Motion of a point of one body relative to a point of another, to third order. Bounds along a
//! direction are based on it.
//!
//! With `x = a - b`, in coordinates of the nearest frame that carries both bodies, and `e` the
//! tangent vector of a geodesic times the roots of the weights, so that `|e|` is its length in the
//! joint metric, Taylor's formula says
//!
//! `n . (x(e) - x(0)) <= g . e + e' H e / 2 + K |e|^3 / 6`
//!
//! with `g` and `H` the gradient and Hessian of `n . x`. For joints `i <= j <= k`, counted from the
//! common frame outward, the derivatives of a point are `L_k`, `z_j x L_k` and `z_i x (z_j x L_k)`.
//! Here `z` is the angular velocity by a joint, and `L_k` the point's velocity by joint `k` alone.
//! Joints keep their rates along a geodesic, so the largest distances of points from axes bound all
//! derivatives on it.

mod lanes;

use std::array;

use super::Metric;
use crate::math::elementary::hypot;
use crate::math::{Pose, Vec3};
use crate::scene::{MetricKind, Motion, Scene};
pub use lanes::{Lanes, PairMotions, lanes};

/// The joints that move one body relative to another, and their effect on a point of each body.
#[derive(Debug, Clone, Default)]
pub struct PairMotion {
    frames: [usize; 2],
    common: usize,
    /// Joints of either body, outward from the common frame; empty unless the metric is `joint`.
    chains: [Chain; 2],
    coordinates: Vec<usize>,
    /// Whether some coordinate moves several joints.
    is_shared: bool,
    /// Velocity of `a - b` by coordinate.
    columns: Vec<Vec3>,
    /// Displacement \[m\] along any direction per metric unit; unused by the joint metric.
    rate: f64,
}

/// The joints from the common frame outward to a body.
#[derive(Debug, Clone, Default)]
struct Chain {
    joints: Vec<Joint>,
    /// Largest sum of turns \[rad\] up to and including each joint along a geodesic of length 1.
    turned: Vec<f64>,
    /// Scratch for sums of rates by coordinate.
    sums: Vec<f64>,
    reaches: Vec<f64>,
}

/// A joint; all of its rates are per unit of `e`.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Index of its first coordinate in [`PairMotion::coordinates`].
    at: usize,
    /// Number of coordinates: 3 for a ball joint, otherwise 1.
    dimensions: usize,
    /// World axes of rotation \[rad\] or translation \[m\], scaled to the rate.
    axes: [Vec3; 3],
    is_slide: bool,
    /// Point of the axis in world coordinates \[m\].
    origin: Vec3,
    /// Rate of rotation \[rad\] about any axis, or of translation \[m\].
    rate: f64,
    /// Velocity of the point by each coordinate.
    velocities: [Vec3; 3],
    /// Distance \[m\] of the point from the axis or centre; 1 for a slide.
    lever: f64,
}

impl Metric {
    /// Prepares `motion` for points of the bodies that `frames` carry, at the configuration with
    /// frame poses `poses`. Tangent coordinates for which `is_locked` holds do not move.
    #[doc(hidden)]
    pub fn pair_motion(
        &self,
        poses: &[Pose],
        frames: [usize; 2],
        is_locked: impl Fn(usize) -> bool,
        motion: &mut PairMotion,
    ) {
        (motion.frames, motion.common) = (frames, 0);
        motion.coordinates.clear();
        motion.is_shared = false;
        motion.chains.iter_mut().for_each(|chain| chain.joints.clear());
        if self.kind() == MetricKind::Joint {
            let common = common_frame(self.scene(), frames);
            motion.common = common;
            for (chain, frame) in motion.chains.iter_mut().zip(frames) {
                let mut at = frame;
                while at != common {
                    chain.push(self, poses, at, &is_locked, (&mut motion.coordinates, &mut motion.is_shared));
                    at = self.scene().frames[at].parent;
                }
                chain.joints.reverse();
            }
        }
        let coordinates = motion.coordinates.len();
        motion.chains.iter_mut().for_each(|chain| chain.sum_turns(coordinates));
    }

    /// Evaluates the motion of point `a` of the first body and `b` of the second (world coordinates
    /// \[m\]). Both have to lie in their bodies' convex hulls.
    #[doc(hidden)]
    pub fn place_points(&self, poses: &[Pose], [a, b]: [&Vec3; 2], motion: &mut PairMotion) {
        match self.kind() {
            MetricKind::Joint => motion.place([a, b]),
            // Each frame has its share of the mean square, so the squared factors add.
            MetricKind::ObjectNorm => {
                let of =
                    |frame: usize, point: &Vec3| if frame == 0 { 0.0 } else { self.norm_factor(poses, frame, point) };
                motion.rate = hypot(of(motion.frames[0], a), of(motion.frames[1], b));
            }
            // The distance is the largest displacement, so each moving frame adds 1.
            MetricKind::MaxDisplacement => {
                motion.rate = motion.frames.iter().filter(|frame| **frame != 0).count() as f64;
            }
        }
    }

    fn norm_factor(&self, poses: &[Pose], frame: usize, point: &Vec3) -> f64 {
        let solid = self.solids().frames.iter().find(|solid| solid.frame == frame);
        solid.map_or(f64::INFINITY, |solid| solid.motion_factor(&poses[frame].inverse_point(point)))
    }
}

impl PairMotion {
    /// Tangent coordinates that move one body relative to the other, in the order of gradients and
    /// Hessians.
    pub fn coordinates(&self) -> &[usize] {
        &self.coordinates
    }

    /// Index of the frame from which displacements are seen.
    pub fn common(&self) -> usize {
        self.common
    }

    /// Displacement \[m\] along any direction per metric unit, for the object norm and the largest
    /// displacement; the joint metric has [`PairMotion::derivatives`].
    pub fn rate(&self) -> f64 {
        self.rate
    }

    fn place(&mut self, points: [&Vec3; 2]) {
        self.columns.clear();
        self.columns.resize(self.coordinates.len(), Vec3::zeros());
        for ((chain, point), sign) in self.chains.iter_mut().zip(points).zip([1.0, -1.0]) {
            for joint in &mut chain.joints {
                joint.place(point);
                for (k, velocity) in joint.velocities[..joint.dimensions].iter().enumerate() {
                    self.columns[joint.at + k] += velocity * sign;
                }
            }
        }
    }

    /// Velocity of `a - b` by each of [`PairMotion::coordinates`]. Its products with `n` are the
    /// gradient along `n`.
    pub fn columns(&self) -> &[Vec3] {
        &self.columns
    }

    /// Writes the Hessian of `n . (a - b)`, row major, for the direction `n` of each lane. `n` is
    /// in world coordinates, axis by axis.
    #[inline(always)]
    pub fn hessian<const N: usize>(&self, n: &[[f64; N]; 3], hessian: &mut Vec<[f64; N]>) {
        let width = self.coordinates.len();
        hessian.clear();
        hessian.resize(width * width, [0.0; N]);
        let mut add = |row: usize, column: usize, across: &[[f64; N]; 3], velocity: &Vec3| {
            let entry: [f64; N] =
                array::from_fn(|k| across[0][k] * velocity.x + across[1][k] * velocity.y + across[2][k] * velocity.z);
            for at in [row * width + column, column * width + row] {
                hessian[at] = array::from_fn(|k| hessian[at][k] + entry[k]);
            }
        };
        for (chain, sign) in self.chains.iter().zip([1.0, -1.0]) {
            for (i, inner) in chain.joints.iter().enumerate().filter(|(_, joint)| !joint.is_slide) {
                for (k, axis) in inner.axes[..inner.dimensions].iter().enumerate() {
                    let axis = axis * sign;
                    let across: [[f64; N]; 3] = [
                        array::from_fn(|k| n[1][k] * axis.z - n[2][k] * axis.y),
                        array::from_fn(|k| n[2][k] * axis.x - n[0][k] * axis.z),
                        array::from_fn(|k| n[0][k] * axis.y - n[1][k] * axis.x),
                    ];
                    // A ball joint's own coordinates occur in both orders, so each counts half.
                    for (l, velocity) in inner.velocities[..inner.dimensions].iter().enumerate() {
                        add(inner.at + k, inner.at + l, &across, &(0.5 * velocity));
                    }
                    for outer in &chain.joints[i + 1..] {
                        for (l, velocity) in outer.velocities[..outer.dimensions].iter().enumerate() {
                            add(inner.at + k, outer.at + l, &across, velocity);
                        }
                    }
                }
            }
        }
    }

    /// Returns bounds \[m\] on derivatives of `a - b` along any geodesic of length `distance` at
    /// unit speed: on the second one at its start, and on the mean third one. The weight of the
    /// mean is that of Taylor's remainder, `(1 - t)^2` for `t` from 0 to 1.
    ///
    /// Bounds on derivatives are convex in `t`, as reaches are. So they are at most `1 - t` times
    /// those at the start plus `t` times those at the end.
    pub fn derivatives(&mut self, distance: f64) -> [f64; 2] {
        let here = self.chains.each_ref().map(|chain| chain.derivatives(|joint| chain.joints[joint].lever));
        let there = self.chains.each_mut().map(|chain| {
            chain.measure_reaches(distance);
            chain.derivatives(|joint| chain.reaches[joint])
        });
        // Chains without a common coordinate split the distance, so the larger bound covers both.
        let both = |[x, y]: [f64; 2]| if self.is_shared { x + y } else { x.max(y) };
        let [second, third] = [0, 1].map(|order| both(here.map(|of_chain| of_chain[order])));
        [second, 0.75 * third + 0.25 * both(there.map(|of_chain| of_chain[1]))]
    }
}

impl Chain {
    fn push(
        &mut self,
        metric: &Metric,
        poses: &[Pose],
        frame: usize,
        is_locked: &impl Fn(usize) -> bool,
        (coordinates, is_shared): (&mut Vec<usize>, &mut bool),
    ) {
        let pose = &poses[frame];
        let (v, multiplier, dimensions, axes, is_slide) = match &metric.scene().frames[frame].motion {
            Motion::World => return,
            Motion::Revolute { axis, coordinate } => {
                (coordinate.v, coordinate.multiplier, 1, [pose.vector(axis); 3], false)
            }
            Motion::Prismatic { axis, coordinate } => {
                (coordinate.v, coordinate.multiplier, 1, [pose.vector(axis); 3], true)
            }
            Motion::Ball { v, .. } => (*v, 1.0, 3, [0, 1, 2].map(|k| pose.rotation.column(k).into_owned()), false),
        };
        if is_locked(v) {
            return;
        }
        let known = coordinates.iter().position(|known| *known == v);
        *is_shared |= known.is_some();
        let at = known.unwrap_or(coordinates.len());
        if known.is_none() {
            coordinates.extend(v..v + dimensions);
        }
        let scale = multiplier / metric.coordinate_uses()[v].weight.sqrt();
        self.joints.push(Joint {
            at,
            dimensions,
            axes: axes.map(|axis| axis * scale),
            is_slide,
            origin: pose.translation,
            rate: scale.abs(),
            velocities: [Vec3::zeros(); 3],
            lever: 1.0,
        });
    }

    /// Bounds the sum of turns up to each joint by the norm of their rates (Cauchy-Schwarz).
    fn sum_turns(&mut self, coordinates: usize) {
        self.sums.clear();
        self.sums.resize(coordinates, 0.0);
        self.turned.clear();
        let mut squared = 0.0;
        for joint in &self.joints {
            if !joint.is_slide {
                squared += add_shared(&mut self.sums[joint.at], joint.rate);
            }
            self.turned.push(f64::sqrt(squared));
        }
    }

    /// Returns bounds on the second and third derivative if the point is no farther from the axis
    /// of each joint than its reach.
    fn derivatives(&self, reach: impl Fn(usize) -> f64) -> [f64; 2] {
        // Terms that end in joint `k` add at most its reach times the growth of powers of `turned`.
        // Reaches are raised to the largest farther out, so summation by parts adds no negatives.
        let ([mut second, mut third], mut farthest) = ([0.0; 2], 0.0);
        for (k, joint) in self.joints.iter().enumerate().rev() {
            let (turned, reach) = (self.turned[k], reach(k));
            if joint.is_slide {
                second += joint.rate * 2.0 * turned;
                third += joint.rate * 3.0 * turned * turned;
            } else if reach > farthest {
                second += (reach - farthest) * turned * turned;
                third += (reach - farthest) * turned.powi(3);
                farthest = reach;
            }
        }
        [second, third]
    }

    /// Bounds the point's distance from each joint's axis within `distance`: its present one plus
    /// the displacement by joints farther out.
    fn measure_reaches(&mut self, distance: f64) {
        let Self { joints, sums, reaches, .. } = self;
        sums.fill(0.0);
        reaches.clear();
        reaches.resize(joints.len(), 0.0);
        let mut squared = 0.0;
        for (joint, reach) in joints.iter().zip(reaches).rev() {
            *reach = if joint.is_slide { 1.0 } else { joint.lever + distance * f64::sqrt(squared) };
            squared += add_shared(&mut sums[joint.at], joint.rate * *reach);
        }
    }
}

/// Adds a rate to the sum of a coordinate, and returns the growth of the sum's square.
fn add_shared(sum: &mut f64, rate: f64) -> f64 {
    let before = *sum;
    *sum += rate;
    *sum * *sum - before * before
}

impl Joint {
    fn place(&mut self, point: &Vec3) {
        if self.is_slide {
            self.velocities[0] = self.axes[0];
            return;
        }
        let arm = point - self.origin;
        for k in 0..self.dimensions {
            self.velocities[k] = self.axes[k].cross(&arm);
        }
        let across = if self.dimensions == 1 { self.velocities[0].norm() } else { arm.norm() * self.rate };
        self.lever = if self.rate > 0.0 { across / self.rate } else { 0.0 };
    }
}

/// Returns the nearest frame that carries both frames.
fn common_frame(scene: &Scene, [mut a, mut b]: [usize; 2]) -> usize {
    // A parent precedes its children, so the larger index is never an ancestor of the smaller one.
    while a != b {
        let farther = if a > b { &mut a } else { &mut b };
        *farther = scene.frames[*farther].parent;
    }
    a
}

#[cfg(test)]
mod tests;

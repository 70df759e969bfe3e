//! Growth of the moving volume's squared displacement with a step. The sums are those of rigid-body
//! inertia.

use super::solids::{FrameSolid, Solids};
use crate::kinematics::{Twist, Twists, Wrench};
use crate::math::{Mat3, Pose, Vec3};
use crate::scene::Scene;

/// Sums over everything that a frame and its descendants carry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried {
    /// Share of the moving volume.
    mass: f64,
    /// First and second moments about the world's origin, per moving volume \[m, m^2\].
    first: Vec3,
    second: Mat3,
    /// Gradient of half the squared displacement, as a wrench about the world's origin.
    pull: Wrench,
}

impl Default for Carried {
    fn default() -> Self {
        Self { mass: 0.0, first: Vec3::zeros(), second: Mat3::zeros(), pull: Wrench::default() }
    }
}

impl Carried {
    /// Sums over one frame alone, in world axes; `from` is its part of the anchor's embedding.
    fn new(solid: &FrameSolid, pose: &Pose, from: &[f64]) -> Self {
        let scale = solid.share.sqrt();
        let (center, arms) = (pose.point(&solid.centroid), pose.rotation * solid.root);
        let mut pull = Wrench::at(&center, (center * scale - Vec3::from_column_slice(&from[..3])) * scale);
        for (k, before) in from[3..12].chunks_exact(3).enumerate() {
            // An arm is a difference of two points, so forces on it have a moment only. The force
            // of its present value drops out, as arm x arm is zero.
            pull.moment -= arms.column(k).cross(&Vec3::from_column_slice(before)) * scale;
        }
        let second = (arms * arms.transpose() + center * center.transpose()) * solid.share;
        Self { mass: solid.share, first: center * solid.share, second, pull }
    }

    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
        self.pull += &other.pull;
    }

    /// Returns the momentum of the velocity `twist`: its power at another velocity is the tensor's
    /// entry for the two.
    fn momentum(&self, twist: &Twist) -> Wrench {
        let force = twist.slide * self.mass + twist.turn.cross(&self.first);
        let moment = twist.turn * self.second.trace() - self.second * twist.turn + self.first.cross(&twist.slide);
        Wrench { force, moment }
    }
}

/// Outputs of the sums, and what they are computed from.
pub(super) struct Sums<'a> {
    /// `nv x nv` entries, row major.
    pub tensor: &'a mut [f64],
    pub slope: &'a mut [f64],
    pub twists: &'a Twists,
    /// Scratch with one entry per frame.
    pub carried: &'a mut Vec<Carried>,
}

/// Adds the tensor and the slope of half the squared object norm to `out`, between the
/// configuration with frame poses `poses` and one whose embedding is `from`. The tensor is
/// Gauss-Newton's, exact if the two coincide.
///
/// # Source
/// R. Featherstone, *Rigid Body Dynamics Algorithms* (2008), section 6.2: the composite rigid body
/// algorithm, which sums what each joint carries before it multiplies. The tensor is the mass
/// matrix of the moving volume.
pub(super) fn object_norm_model(scene: &Scene, solids: &Solids, poses: &[Pose], from: &[f64], out: Sums) {
    let nv = scene.space.nv();
    let Sums { tensor, slope, twists, carried } = out;
    carried.clear();
    carried.resize(scene.frames.len(), Carried::default());
    for (solid, from) in solids.frames.iter().zip(from.chunks_exact(12)) {
        carried[solid.frame] = Carried::new(solid, &poses[solid.frame], from);
    }
    for frame in (1..scene.frames.len()).rev() {
        let own = carried[frame];
        for twist in twists.of(frame) {
            slope[twist.v] += twist.power(&own.pull);
            let momentum = own.momentum(twist);
            for other in twists.of(frame) {
                tensor[twist.v * nv + other.v] += other.power(&momentum);
            }
            let mut above = scene.frames[frame].parent;
            while above != 0 {
                for other in twists.of(above) {
                    let power = other.power(&momentum);
                    tensor[twist.v * nv + other.v] += power;
                    tensor[other.v * nv + twist.v] += power;
                }
                above = scene.frames[above].parent;
            }
        }
        carried[scene.frames[frame].parent].add(&own);
    }
}

/// Computes [`super::Metric::levers`] at frame poses `poses`.
pub(super) fn levers(scene: &Scene, solids: &Solids, poses: &[Pose]) -> Vec<f64> {
    let (nv, mut twists) = (scene.space.nv(), Twists::default());
    twists.set(scene, poses);
    let (mut squares, mut shares) = (vec![0.0; nv], vec![0.0; nv]);
    for solid in &solids.frames {
        let pose = &poses[solid.frame];
        // Six points have the same first and second moments as the volume.
        let (center, arms) = (pose.point(&solid.centroid), pose.rotation * solid.root * 3.0_f64.sqrt());
        let mut moved = vec![Vec::new(); nv];
        let mut frame = solid.frame;
        while frame != 0 {
            twists.of(frame).iter().for_each(|twist| moved[twist.v].push(*twist));
            frame = scene.frames[frame].parent;
        }
        for (v, own) in moved.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
            shares[v] += solid.share;
            for (column, side) in (0..3).flat_map(|column| [(column, 1.0), (column, -1.0)]) {
                let point = center + arms.column(column) * side;
                let speed: Vec3 = own.iter().map(|twist| twist.slide + twist.turn.cross(&point)).sum();
                squares[v] += solid.share / 6.0 * speed.norm_squared();
            }
        }
    }
    let lever = |(square, share): (f64, f64)| if share > 0.0 { (square / share).sqrt() } else { 0.0 };
    squares.into_iter().zip(shares).map(lever).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::kinematics::{add_point_gradient, forward};
    use crate::metric::quadratic::Quadratic;
    use crate::metric::{Anchor, Metric};
    use crate::scene::{MetricKind, builtin};
    use std::sync::Arc;

    /// Slow twin: squares the embedding's Jacobian row by row. The hand has mimic joints, which
    /// move two frames by one coordinate.
    #[test]
    fn equals_the_square_of_the_embeddings_jacobian() {
        for name in builtin::NAMES {
            let scene = Arc::new(builtin::scene(name).unwrap());
            let metric = Metric::of_kind(scene.clone(), MetricKind::ObjectNorm);
            let (space, nv) = (&scene.space, scene.space.nv());
            let (halton, mut q, mut x) = (Halton::new(nv, 1), vec![0.0; space.nq()], vec![0.0; space.nq()]);
            let (mut poses, mut anchor, mut model) = (Vec::new(), Anchor::default(), Quadratic::default());
            for k in 0..10 {
                halton.config(space, 2 * k, &mut q);
                halton.config(space, 2 * k + 1, &mut x);
                metric.anchor(&q, &mut anchor);
                forward(&scene, &x, &mut poses);
                metric.quadratic_model(&anchor, &x, &poses, &mut model);
                let (mut tensor, mut slope) = (vec![0.0; nv * nv], vec![0.0; nv]);
                let mut row = vec![0.0; nv];
                for (solid, at) in metric.solids().frames.iter().zip(anchor.embedding.chunks_exact(12)) {
                    let (pose, scale) = (&poses[solid.frame], solid.share.sqrt());
                    for (k, at) in at.chunks_exact(3).enumerate() {
                        let is_point = k == 0;
                        let now = match k {
                            0 => pose.point(&solid.centroid),
                            k => pose.vector(&solid.root.column(k - 1).into_owned()),
                        };
                        for i in 0..3 {
                            row.fill(0.0);
                            let axis = Vec3::ith(i, 1.0);
                            let end = if is_point { now } else { pose.translation + now };
                            add_point_gradient(&scene, &poses, solid.frame, &end, &axis, scale, &mut row);
                            if !is_point {
                                let start = &pose.translation;
                                add_point_gradient(&scene, &poses, solid.frame, start, &axis, -scale, &mut row);
                            }
                            let residual = now[i] * scale - at[i];
                            for a in 0..nv {
                                slope[a] += row[a] * residual;
                                (0..nv).for_each(|b| tensor[a * nv + b] += row[a] * row[b]);
                            }
                        }
                    }
                }
                let largest = tensor.iter().copied().fold(0.0, f64::max);
                let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let found = model.tensor.entries();
                assert!(off(&tensor, found) < 2e-6 * largest, "{name}: {}", off(&tensor, found));
                assert!(off(&slope, &model.gradient) < 1e-12, "{name}: {}", off(&slope, &model.gradient));
            }
        }
    }
}

//! A local quadratic model of half the squared distance, for constrained minimisation.

use super::{Anchor, Metric};
use crate::cspace::Manifold;
use crate::kinematics::add_point_gradient;
use crate::math::{Pose, Vec3};
use crate::scene::{MetricSpec, Scene};

/// `d(anchor, x + t)^2 / 2 ~ u' H u / 2 + g' u + const  subject to  R u >= r`, where `u` is `t` (tangent coordinates at `x`), for
/// the largest displacement followed by one more unknown: that displacement itself.
#[derive(Debug, Clone, Default)]
pub struct Quadratic {
    /// Length of `u`.
    pub unknowns: usize,
    /// `unknowns x unknowns`, row major, symmetric positive definite.
    pub hessian: Vec<f64>,
    /// Whether nothing of it is off its diagonal, which holds for the joint metric.
    pub is_diagonal: bool,
    /// `unknowns`.
    pub gradient: Vec<f64>,
    /// `R`, row major; empty but for the largest displacement.
    pub rows: Vec<f64>,
    /// `r`.
    pub bounds: Vec<f64>,
    /// The metric's own tensor (of the object norm, for the largest displacement): `nv x nv`, row major.
    pub tensor: Vec<f64>,
    slope: Vec<f64>,
    jacobian: Vec<f64>,
    farthest: Vec<(f64, usize, usize)>,
}

/// Relative damping that keeps the tensor positive definite where a coordinate moves nothing.
const DAMPING: f64 = 1e-6;

/// Weight of the tensor beside the largest displacement, whose own model is linear: a proximal term, which also stands for the
/// curvature that the linear model lacks.
const PROXIMAL: f64 = 0.05;
/// Points that move less than this share of the largest displacement are left out of its model.
const FAR_SHARE: f64 = 0.6;
/// Most points in the model of the largest displacement.
const MOST_POINTS: usize = 40;
/// Points of one frame that are nearer to each other than this share of its size tell the same.
const SAME_PLACE: f64 = 0.15;

impl Metric {
    /// Models half the squared distance from `anchor` around `x`, whose frame poses are `poses`.
    ///
    /// Exact to second order for the joint metric without rotations; a Gauss-Newton model for the object norm; for the largest
    /// displacement `s`, half of `s^2` with one linearised row `s >= |displacement|` for each of the points that move farthest.
    pub fn quadratic_model(&self, anchor: &Anchor, x: &[f64], poses: &[Pose], out: &mut Quadratic) {
        let nv = self.scene().space.nv();
        out.tensor.clear();
        out.tensor.resize(nv * nv, 0.0);
        out.slope.clear();
        out.slope.resize(nv, 0.0);
        out.rows.clear();
        out.bounds.clear();
        out.is_diagonal = self.kind() == MetricSpec::Joint;
        match self.kind() {
            MetricSpec::Joint => self.joint_model(anchor, x, out),
            MetricSpec::ObjectNorm | MetricSpec::MaxDisplacement => self.object_norm_model(anchor, poses, out),
        }
        let largest = out.tensor.iter().step_by(nv + 1).copied().fold(0.0, f64::max).max(1e-12);
        out.tensor.iter_mut().step_by(nv + 1).for_each(|entry| *entry += DAMPING * largest);
        if out.is_diagonal {
            out.unknowns = nv;
            out.hessian.clone_from(&out.tensor);
            out.gradient.clone_from(&out.slope);
            return;
        }
        let extra = usize::from(self.kind() == MetricSpec::MaxDisplacement);
        let unknowns = nv + extra;
        out.unknowns = unknowns;
        out.hessian.clear();
        out.hessian.resize(unknowns * unknowns, 0.0);
        out.gradient.clear();
        out.gradient.resize(unknowns, 0.0);
        let (weight, slope) = if extra == 1 { (PROXIMAL, 0.0) } else { (1.0, 1.0) };
        for i in 0..nv {
            out.gradient[i] = slope * out.slope[i];
            for j in 0..nv {
                out.hessian[i * unknowns + j] = weight * out.tensor[i * nv + j];
            }
        }
        if extra == 1 {
            out.hessian[unknowns * unknowns - 1] = 1.0;
            self.farthest_points(anchor, poses, out);
        }
    }

    /// Gradient over the tangent coordinates at `x` of half the squared distance from `anchor`, for the joint metric: as
    /// [`Metric::quadratic_model`] has it.
    pub fn joint_gradient(&self, anchor: &Anchor, x: &[f64], gradient: &mut [f64]) {
        let space = &self.scene().space;
        space.difference(&anchor.q, x, gradient);
        for factor in space.factors() {
            let width = if factor.manifold == Manifold::Rotation { 3 } else { 1 };
            gradient[factor.v..factor.v + width].iter_mut().for_each(|slope| *slope *= factor.weight);
        }
    }

    fn joint_model(&self, anchor: &Anchor, x: &[f64], out: &mut Quadratic) {
        let space = &self.scene().space;
        let nv = space.nv();
        self.joint_gradient(anchor, x, &mut out.slope);
        for factor in space.factors() {
            let width = if factor.manifold == Manifold::Rotation { 3 } else { 1 };
            for k in factor.v..factor.v + width {
                out.tensor[k * nv + k] = factor.weight;
            }
        }
    }

    fn object_norm_model(&self, anchor: &Anchor, poses: &[Pose], out: &mut Quadratic) {
        for (solid, at) in self.solids().frames.iter().zip(anchor.embedding.chunks_exact(12)) {
            let pose = &poses[solid.frame];
            let scale = solid.share.sqrt();
            let centroid = pose.point(&solid.centroid);
            let residual = centroid * scale - Vec3::from_column_slice(&at[..3]);
            out.add_squares(self.scene(), poses, solid.frame, &centroid, &residual, scale);
            // A direction is a point at the far end of an arm, less the same for the arm's near end: d(R l) = d(o + R l) - d(o).
            for k in 0..3 {
                let arm = pose.rotation * solid.root.column(k);
                let residual = arm * scale - Vec3::from_column_slice(&at[3 + 3 * k..6 + 3 * k]);
                out.add_direction_squares(self.scene(), poses, solid.frame, &arm, &residual, scale);
            }
        }
    }

    /// One row `s - direction . d(point) >= |displacement|` for each of the points that move farthest, spread out.
    fn farthest_points(&self, anchor: &Anchor, poses: &[Pose], out: &mut Quadratic) {
        let frames = &self.extremes().frames;
        let displacement = |f: usize, point: &Vec3| {
            let frame = frames[f].frame;
            poses[frame].point(point) - anchor.poses[frame].point(point)
        };
        let mut farthest = std::mem::take(&mut out.farthest);
        farthest.clear();
        for (f, frame) in frames.iter().enumerate() {
            farthest.extend(frame.samples.iter().enumerate().map(|(i, p)| (displacement(f, p).norm(), f, i)));
        }
        let largest = farthest.iter().map(|(d, _, _)| *d).fold(0.0, f64::max);
        farthest.retain(|(d, _, _)| *d >= FAR_SHARE * largest && *d > 0.0);
        farthest.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut kept = 0;
        for i in 0..farthest.len() {
            let (distance, f, at) = farthest[i];
            let point = frames[f].samples[at];
            let apart = SAME_PLACE * frames[f].radius;
            let told =
                |&(_, g, other): &(f64, usize, usize)| g == f && (frames[f].samples[other] - point).norm() < apart;
            if kept == MOST_POINTS || farthest[..kept].iter().any(told) {
                continue;
            }
            farthest[kept] = farthest[i];
            kept += 1;
            let start = out.rows.len();
            out.rows.resize(start + out.unknowns, 0.0);
            let direction = displacement(f, &point) / distance;
            let row = &mut out.rows[start..];
            let world = poses[frames[f].frame].point(&point);
            add_point_gradient(self.scene(), poses, frames[f].frame, &world, &direction, -1.0, row);
            row[out.unknowns - 1] = 1.0;
            out.bounds.push(distance);
        }
        out.farthest = farthest;
    }
}

impl Quadratic {
    /// Distance from the anchor that the model expects after the step `u`, given the present one.
    pub fn expected_distance(&self, distance: f64, u: &[f64]) -> f64 {
        if !self.bounds.is_empty() {
            return u[self.unknowns - 1];
        }
        let change: f64 = self.gradient.iter().zip(u).map(|(g, u)| g * u).sum();
        (distance * distance + 2.0 * change + self.step_length(u).powi(2)).max(0.0).sqrt()
    }

    /// Length of a step in metric units, by the tensor.
    pub fn step_length(&self, step: &[f64]) -> f64 {
        let nv = self.slope.len();
        if self.is_diagonal {
            return self.tensor.iter().step_by(nv + 1).zip(step).map(|(h, s)| h * s * s).sum::<f64>().sqrt();
        }
        let row = |i: usize| (0..nv).map(|j| self.tensor[i * nv + j] * step[j]).sum::<f64>();
        (0..nv).map(|i| step[i] * row(i)).sum::<f64>().max(0.0).sqrt()
    }

    /// Adds `|scale * point(t) - ...|^2 / 2` with the current value `residual` (already scaled).
    fn add_squares(&mut self, scene: &Scene, poses: &[Pose], frame: usize, point: &Vec3, residual: &Vec3, scale: f64) {
        self.clear_rows();
        let nv = self.slope.len();
        for k in 0..3 {
            let mut axis = Vec3::zeros();
            axis[k] = 1.0;
            add_point_gradient(scene, poses, frame, point, &axis, scale, &mut self.jacobian[k * nv..(k + 1) * nv]);
        }
        self.accumulate(residual);
    }

    /// The same for a direction fixed to `frame` (an arm in world axes).
    fn add_direction_squares(
        &mut self,
        scene: &Scene,
        poses: &[Pose],
        frame: usize,
        arm: &Vec3,
        residual: &Vec3,
        scale: f64,
    ) {
        self.clear_rows();
        let nv = self.slope.len();
        let origin = poses[frame].translation;
        for k in 0..3 {
            let mut axis = Vec3::zeros();
            axis[k] = 1.0;
            let row = &mut self.jacobian[k * nv..(k + 1) * nv];
            add_point_gradient(scene, poses, frame, &(origin + arm), &axis, scale, row);
            add_point_gradient(scene, poses, frame, &origin, &axis, -scale, row);
        }
        self.accumulate(residual);
    }

    fn clear_rows(&mut self) {
        self.jacobian.clear();
        self.jacobian.resize(3 * self.slope.len(), 0.0);
    }

    fn accumulate(&mut self, residual: &Vec3) {
        let nv = self.slope.len();
        for (row, r) in self.jacobian.chunks_exact(nv).zip(residual.iter()) {
            for i in 0..nv {
                if row[i] == 0.0 {
                    continue;
                }
                self.slope[i] += row[i] * r;
                for j in 0..nv {
                    self.tensor[i * nv + j] += row[i] * row[j];
                }
            }
        }
    }
}

//! A local quadratic model of half the squared distance, for constrained minimisation.

use super::{Anchor, Metric};
use crate::cspace::Manifold;
use crate::kinematics::add_point_gradient;
use crate::math::{Pose, Vec3};
use crate::scene::{MetricSpec, Scene};

/// `d(anchor, x + t)^2 / 2 ~ t' H t / 2 + g' t + const` in tangent coordinates at `x`.
#[derive(Debug, Clone, Default)]
pub struct Quadratic {
    /// `nv x nv`, row major, symmetric positive definite.
    pub hessian: Vec<f64>,
    /// `nv`.
    pub gradient: Vec<f64>,
    jacobian: Vec<f64>,
}

/// Exponent of the norm that stands for the maximum when the largest displacement is minimised.
///
/// The p-norm of n displacements exceeds their maximum by at most n^(1/p): 1.24 for 1,000 points at 32; measured excess
/// after refinement is far smaller, because acceptance looks at the true metric.
const MAX_NORM_EXPONENT: f64 = 32.0;

/// Relative damping that keeps the Hessian positive definite where a coordinate moves nothing.
const DAMPING: f64 = 1e-6;

impl Metric {
    /// Models half the squared distance from `anchor` around `x`, whose frame poses are `poses`.
    ///
    /// Exact to second order for the joint metric without rotations; a Gauss-Newton model otherwise; for the largest
    /// displacement, of a weighted sum of squares whose weights grow with the displacement.
    pub fn quadratic_model(&self, anchor: &Anchor, x: &[f64], poses: &[Pose], out: &mut Quadratic) {
        let nv = self.scene().space.nv();
        out.hessian.clear();
        out.hessian.resize(nv * nv, 0.0);
        out.gradient.clear();
        out.gradient.resize(nv, 0.0);
        match self.kind() {
            MetricSpec::Joint => self.joint_model(anchor, x, out),
            MetricSpec::ObjectNorm => self.object_norm_model(anchor, poses, out),
            MetricSpec::MaxDisplacement => self.max_displacement_model(anchor, poses, out),
        }
        let largest = (0..nv).map(|k| out.hessian[k * nv + k]).fold(0.0, f64::max).max(1e-12);
        for k in 0..nv {
            out.hessian[k * nv + k] += DAMPING * largest;
        }
    }

    fn joint_model(&self, anchor: &Anchor, x: &[f64], out: &mut Quadratic) {
        let space = &self.scene().space;
        let nv = space.nv();
        space.difference(&anchor.q, x, &mut out.gradient);
        for factor in space.factors() {
            let width = if factor.manifold == Manifold::Rotation { 3 } else { 1 };
            for k in factor.v..factor.v + width {
                out.gradient[k] *= factor.weight;
                out.hessian[k * nv + k] = factor.weight;
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

    fn max_displacement_model(&self, anchor: &Anchor, poses: &[Pose], out: &mut Quadratic) {
        let largest = self.extremes().max_displacement(&anchor.poses, poses).max(1e-12);
        let mut total = 0.0;
        for frame in &self.extremes().frames {
            for point in &frame.samples {
                let now = poses[frame.frame].point(point);
                let residual = now - anchor.poses[frame.frame].point(point);
                let weight = (residual.norm() / largest).min(1.0).powf(0.5 * (MAX_NORM_EXPONENT - 2.0));
                if weight > 1e-4 {
                    total += weight * weight;
                    out.add_squares(self.scene(), poses, frame.frame, &now, &(residual * weight), weight);
                }
            }
        }
        // A weighted mean of squares, so that the model's value is of the order of the squared distance.
        let scale = 1.0 / f64::max(total, 1e-12);
        out.hessian.iter_mut().chain(out.gradient.iter_mut()).for_each(|x| *x *= scale);
    }
}

impl Quadratic {
    /// Adds `|scale * point(t) - ...|^2 / 2` with the current value `residual` (already scaled).
    fn add_squares(&mut self, scene: &Scene, poses: &[Pose], frame: usize, point: &Vec3, residual: &Vec3, scale: f64) {
        self.clear_rows();
        let nv = self.gradient.len();
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
        let nv = self.gradient.len();
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
        self.jacobian.resize(3 * self.gradient.len(), 0.0);
    }

    fn accumulate(&mut self, residual: &Vec3) {
        let nv = self.gradient.len();
        for (row, r) in self.jacobian.chunks_exact(nv).zip(residual.iter()) {
            for i in 0..nv {
                if row[i] == 0.0 {
                    continue;
                }
                self.gradient[i] += row[i] * r;
                for j in 0..nv {
                    self.hessian[i * nv + j] += row[i] * row[j];
                }
            }
        }
    }
}

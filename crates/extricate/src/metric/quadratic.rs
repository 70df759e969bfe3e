//! A local quadratic model of half the squared distance, for constrained minimisation.

use super::extremes::FarPoints;
use super::inertia::{Carried, Sums, object_norm_model};
use super::{Anchor, Metric};
use crate::cspace::{ConfigSpace, Manifold};
use crate::kinematics::{Twists, Wrench};
use crate::math::Pose;
use crate::math::quadratic_form::QuadraticForm;
use crate::scene::MetricKind;

/// The model `d(anchor, x + t)^2 / 2 ~ u' H u / 2 + g' u + const`, subject to `R u >= r`. Here `u`
/// is `t`, in tangent coordinates at `x`. For the largest displacement, that displacement follows
/// as one more unknown.
#[derive(Debug, Clone, Default)]
pub struct Quadratic {
    /// Length of the vector `u`.
    pub unknowns: usize,
    /// `H`, over the unknowns; diagonal for the joint metric.
    pub hessian: QuadraticForm,
    /// `g`, of length `unknowns`.
    pub gradient: Vec<f64>,
    /// `R`, row major; empty unless the metric is the largest displacement.
    pub rows: Vec<f64>,
    /// `r`, one entry per row.
    pub bounds: Vec<f64>,
    /// Damped tensor of the metric over tangent coordinates; for the largest displacement, that of
    /// its embedding.
    pub tensor: QuadraticForm,
    slope: Vec<f64>,
    twists: Twists,
    carried: Vec<Carried>,
    far: FarPoints,
}

/// Share of the largest diagonal entry that is added to the tensor's diagonal. It keeps the tensor
/// positive definite if a coordinate moves nothing.
const DAMPING_SHARE: f64 = 1e-6;

/// Weight of the tensor in the model of the largest displacement. This proximal term replaces the
/// curvature that the linearised rows lack.
const PROXIMAL_WEIGHT: f64 = 0.05;

impl Metric {
    /// Models half the squared distance from `anchor` around `x`, whose frame poses are `poses`.
    ///
    /// For the joint metric without rotations the model is exact to second order, for the object
    /// norm it is Gauss-Newton's. For the largest displacement `s` it is half of `s^2`, with one
    /// linearised row `s >= |displacement|` for each of the points that move farthest.
    #[doc(hidden)]
    pub fn quadratic_model(&self, anchor: &Anchor, x: &[f64], poses: &[Pose], out: &mut Quadratic) {
        let nv = self.scene().space.nv();
        out.tensor.reset(nv, self.kind() == MetricKind::Joint);
        out.slope.clear();
        out.slope.resize(nv, 0.0);
        out.rows.clear();
        out.bounds.clear();
        match self.kind() {
            MetricKind::Joint => self.joint_model(anchor, x, out),
            MetricKind::ObjectNorm | MetricKind::MaxDisplacement => {
                out.twists.set(self.scene(), poses);
                let Quadratic { tensor, slope, twists, carried, .. } = out;
                let tensor = tensor.entries_mut();
                let sums = Sums { tensor, slope, twists, carried };
                object_norm_model(self.scene(), self.solids(), poses, &anchor.embedding, sums);
            }
        }
        out.tensor.damp(DAMPING_SHARE, 1e-12);
        if out.tensor.is_diagonal() {
            out.unknowns = nv;
            out.hessian.copy_from(&out.tensor);
            out.gradient.clone_from(&out.slope);
            return;
        }
        let extra = usize::from(self.kind() == MetricKind::MaxDisplacement);
        let unknowns = nv + extra;
        out.unknowns = unknowns;
        out.hessian.reset(unknowns, false);
        out.gradient.clear();
        out.gradient.resize(unknowns, 0.0);
        let (weight, slope) = if extra == 1 { (PROXIMAL_WEIGHT, 0.0) } else { (1.0, 1.0) };
        let hessian = out.hessian.entries_mut();
        for i in 0..nv {
            out.gradient[i] = slope * out.slope[i];
            for j in 0..nv {
                hessian[i * unknowns + j] = weight * out.tensor.entries()[i * nv + j];
            }
        }
        if extra == 1 {
            hessian[unknowns * unknowns - 1] = 1.0;
            self.farthest_points(anchor, poses, out);
        }
    }

    /// Writes the gradient of half the squared joint metric from `anchor`, over the tangent
    /// coordinates at `x`: the same as that of [`Metric::quadratic_model`].
    #[doc(hidden)]
    pub fn joint_gradient(&self, anchor: &Anchor, x: &[f64], gradient: &mut [f64]) {
        let space = &self.scene().space;
        space.difference(&anchor.q, x, gradient);
        for factor in space.factors() {
            gradient[factor.tangents()].iter_mut().for_each(|slope| *slope *= factor.weight);
        }
    }

    fn joint_model(&self, anchor: &Anchor, x: &[f64], out: &mut Quadratic) {
        let space = &self.scene().space;
        self.joint_gradient(anchor, x, &mut out.slope);
        for factor in space.factors() {
            out.tensor.entries_mut()[factor.tangents()].fill(factor.weight);
        }
    }

    /// Adds one row `s - direction . d(point) >= |displacement|` for each of the points that move
    /// farthest.
    fn farthest_points(&self, anchor: &Anchor, poses: &[Pose], out: &mut Quadratic) {
        let Quadratic { unknowns, rows, bounds, twists, far, .. } = out;
        self.extremes().farthest(&anchor.poses, poses, far);
        for point in &far.points {
            let start = rows.len();
            rows.resize(start + *unknowns, 0.0);
            let row = &mut rows[start..];
            let wrench = Wrench::at(&point.now, -point.moved / point.distance);
            twists.add_power(self.scene(), point.frame, &wrench, row);
            row[*unknowns - 1] = 1.0;
            bounds.push(point.distance);
        }
    }
}

impl Quadratic {
    /// Writes the least and greatest value of each tangent coordinate for steps from `x` that stay
    /// within the limits and within a trust region of `radius` (metric units).
    #[doc(hidden)]
    pub fn step_box(&self, space: &ConfigSpace, x: &[f64], radius: f64, [low, high]: [&mut Vec<f64>; 2]) {
        low.clear();
        high.clear();
        for k in 0..space.nv() {
            let reach = radius / self.tensor.diagonal(k).sqrt();
            low.push(-reach);
            high.push(reach);
        }
        for factor in space.factors() {
            if let Manifold::Interval { lower, upper } = factor.manifold {
                low[factor.v] = low[factor.v].max(lower - x[factor.q]).min(0.0);
                high[factor.v] = high[factor.v].min(upper - x[factor.q]).max(0.0);
            }
        }
    }

    /// Returns the model's distance from the anchor after the step `u`, given the present distance.
    pub fn expected_distance(&self, distance: f64, u: &[f64]) -> f64 {
        if !self.bounds.is_empty() {
            return u[self.unknowns - 1];
        }
        let change: f64 = self.gradient.iter().zip(u).map(|(g, u)| g * u).sum();
        (distance * distance + 2.0 * change + self.tensor.product(u, u)).max(0.0).sqrt()
    }
}

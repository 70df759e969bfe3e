//! The metric's tensor at the query, which measures distances and random directions near it.

use crate::cspace::ConfigSpace;
use crate::math::linear_algebra::dot;
use crate::math::quadratic_form::{Factor, QuadraticForm};
use crate::metric::Anchor;
use crate::metric::quadratic::Quadratic;
use crate::query::context::Context;

/// Share of the largest diagonal entry that is added to each diagonal entry.
///
/// Self-motions move bodies little and so get long steps. Damping keeps these short enough that not
/// every random direction is a self-motion.
const DAMPING_SHARE: f64 = 1e-3;

/// A quadratic form on tangent vectors that agrees with the metric near the query.
#[derive(Default)]
pub struct LocalMetric {
    quadratic: Quadratic,
    tensor: QuadraticForm,
    factor: Factor,
    difference: Vec<f64>,
}

impl LocalMetric {
    /// Sets the tensor to that of the metric at the anchor.
    pub fn set(&mut self, context: &Context, anchor: &Anchor) {
        context.metric.quadratic_model(anchor, &anchor.q, &anchor.poses, &mut self.quadratic);
        self.tensor.copy_from(&self.quadratic.tensor);
        self.tensor.damp(DAMPING_SHARE, 0.0);
        self.tensor.factor(&mut self.factor);
        self.difference.resize(self.tensor.size(), 0.0);
    }

    /// Returns the distance between two configurations by the tensor at the query.
    pub fn distance(&mut self, space: &ConfigSpace, a: &[f64], b: &[f64]) -> f64 {
        space.difference(a, b, &mut self.difference);
        self.length(&self.difference)
    }

    pub fn tensor(&self) -> &QuadraticForm {
        &self.tensor
    }

    pub fn length(&self, step: &[f64]) -> f64 {
        self.tensor.length(step)
    }

    pub fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.tensor.product(a, b)
    }

    /// Returns the dual norm of `row`: how much a linear function with these coefficients can grow
    /// along a tangent vector of length 1. Overwrites `row`.
    pub fn slope(&self, row: &mut [f64]) -> f64 {
        self.factor.solve_lower(row);
        dot(row, row).sqrt()
    }

    /// Appends coordinates of `config` to `out` in which the tensor is the identity and the query
    /// `q` the origin. Their Euclidean norm is [`LocalMetric::distance`] from `q`; distances
    /// between two of them agree with it if the space between is flat.
    pub fn flatten(&mut self, space: &ConfigSpace, q: &[f64], config: &[f64], out: &mut Vec<f64>) {
        space.difference(q, config, &mut self.difference);
        self.factor.extend_upper(&self.difference, out);
    }

    /// Turns independent standard normal numbers into a direction that is uniform in the tensor's
    /// norm.
    pub fn spread(&self, step: &mut [f64]) {
        self.factor.solve_upper(step);
    }

    #[cfg(test)]
    pub fn euclidean(nv: usize) -> Self {
        let (tensor, mut factor) = (QuadraticForm::identity(nv), Factor::default());
        tensor.factor(&mut factor);
        Self { factor, tensor, difference: vec![0.0; nv], ..Self::default() }
    }
}

//! The metric's tensor at the query: what is near and what is a random direction, as the metric
//! sees it.

use crate::cspace::ConfigSpace;
use crate::math::linear_algebra::{cholesky, dot, forward_solve, transposed_solve};
use crate::metric::Anchor;
use crate::metric::quadratic::Quadratic;
use crate::query::context::Context;

/// Share of the largest diagonal entry that is added to all of them.
///
/// Self-motions, which move bodies little, get long steps, but not so long that every random
/// direction is one.
const DAMPING: f64 = 1e-3;

/// A quadratic form on tangent vectors that agrees with the metric near the query.
#[derive(Default)]
pub struct LocalMetric {
    quadratic: Quadratic,
    tensor: Vec<f64>,
    factor: Vec<f64>,
    difference: Vec<f64>,
}

impl LocalMetric {
    /// Takes the tensor at the anchor.
    pub fn set(&mut self, context: &Context, anchor: &Anchor) {
        let nv = context.checker.scene().space.nv();
        context.metric.quadratic_model(anchor, &anchor.q, &anchor.poses, &mut self.quadratic);
        self.tensor.clear();
        self.tensor.extend_from_slice(&self.quadratic.tensor);
        let largest = (0..nv).map(|k| self.tensor[k * nv + k]).fold(0.0, f64::max);
        (0..nv).for_each(|k| self.tensor[k * nv + k] += DAMPING * largest);
        self.factor.clear();
        self.factor.extend_from_slice(&self.tensor);
        cholesky(&mut self.factor, nv);
        self.difference.resize(nv, 0.0);
    }

    /// Distance between two configurations as the tensor at the query has it.
    pub fn distance(&mut self, space: &ConfigSpace, a: &[f64], b: &[f64]) -> f64 {
        space.difference(a, b, &mut self.difference);
        self.length(&self.difference)
    }

    /// The tensor, row major.
    pub fn tensor(&self) -> &[f64] {
        &self.tensor
    }

    /// Length of a tangent vector.
    pub fn length(&self, step: &[f64]) -> f64 {
        let rows = self.tensor.chunks_exact(step.len()).zip(step);
        rows.map(|(row, s)| s * dot(row, step)).sum::<f64>().max(0.0).sqrt()
    }

    /// Length of the difference of two tangent vectors.
    pub fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        let difference = |k: usize| a[k] - b[k];
        let rows = self.tensor.chunks_exact(a.len()).enumerate();
        let product = |row: &[f64]| row.iter().enumerate().map(|(k, t)| t * difference(k)).sum::<f64>();
        rows.map(|(k, row)| difference(k) * product(row)).sum::<f64>().max(0.0).sqrt()
    }

    /// Cosine of the angle between two tangent vectors.
    pub fn cosine(&self, a: &[f64], b: &[f64]) -> f64 {
        let rows = self.tensor.chunks_exact(a.len()).zip(a);
        let product: f64 = rows.map(|(row, a)| a * dot(row, b)).sum();
        product / (self.length(a) * self.length(b)).max(f64::MIN_POSITIVE)
    }

    /// How much a linear function with the coefficients `row` can grow along a tangent vector of
    /// length 1: the dual norm. `row` is overwritten.
    pub fn slope(&self, row: &mut [f64]) -> f64 {
        forward_solve(&self.factor, row.len(), row);
        dot(row, row).sqrt()
    }

    /// Appends coordinates of `config` to `out` in which the tensor is the identity, with the query
    /// `q` in the origin: its length is that of [`LocalMetric::distance`] from `q`, and two of them
    /// are as far from each other where the space between is flat.
    pub fn flatten(&mut self, space: &ConfigSpace, q: &[f64], config: &[f64], out: &mut Vec<f64>) {
        space.difference(q, config, &mut self.difference);
        let nv = self.difference.len();
        let column = |k: usize| (k..nv).map(|i| self.factor[i * nv + k] * self.difference[i]).sum::<f64>();
        out.extend((0..nv).map(column));
    }

    /// Turns independent standard normal numbers into a direction that is uniform in the tensor's
    /// norm.
    pub fn spread(&self, step: &mut [f64]) {
        transposed_solve(&self.factor, step.len(), step);
    }

    /// The identity, for tests.
    #[cfg(test)]
    pub fn euclidean(nv: usize) -> Self {
        let tensor: Vec<f64> = (0..nv * nv).map(|i| if i % (nv + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self { factor: tensor.clone(), tensor, difference: vec![0.0; nv], ..Self::default() }
    }
}

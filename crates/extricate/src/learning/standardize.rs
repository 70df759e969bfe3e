//! Centring and scaling of features before a kernel sees them, and dropping those that say nothing.

use serde::{Deserialize, Serialize};

/// How features are brought to a common scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scaling {
    /// Each dimension to unit variance: for features whose units differ.
    PerDimension,
    /// All dimensions by one factor, to unit mean variance: for embeddings, whose distances mean something.
    Global,
}

/// The map `x -> (x - centre) * scale` on the dimensions that are kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Standardization {
    /// Kept dimensions, ascending, with their centre and scale.
    kept: Vec<(u32, f64, f64)>,
    dimensions: usize,
}

impl Standardization {
    /// From the mean and variance of `features` (`n x dimensions`, row major); constant dimensions are dropped.
    pub fn fit(features: &[f64], dimensions: usize, scaling: Scaling) -> Self {
        let count = (features.len() / dimensions).max(1) as f64;
        let mut mean = vec![0.0; dimensions];
        for row in features.chunks_exact(dimensions) {
            mean.iter_mut().zip(row).for_each(|(m, x)| *m += x / count);
        }
        let mut variance = vec![0.0; dimensions];
        for row in features.chunks_exact(dimensions) {
            variance.iter_mut().zip(row.iter().zip(&mean)).for_each(|(v, (x, m))| *v += (x - m).powi(2) / count);
        }
        // Below this, a dimension is constant but for rounding of its values and of their mean.
        let varies = |k: &usize| variance[*k].sqrt() > 1e-12 * (1.0 + mean[*k].abs());
        let varying: Vec<usize> = (0..dimensions).filter(varies).collect();
        let mean_variance = varying.iter().map(|k| variance[*k]).sum::<f64>() / varying.len().max(1) as f64;
        let scale = |k: usize| match scaling {
            Scaling::PerDimension => 1.0 / variance[k].sqrt(),
            Scaling::Global => 1.0 / mean_variance.sqrt(),
        };
        let mut kept: Vec<_> = varying.iter().map(|k| (*k as u32, mean[*k], scale(*k))).collect();
        if kept.is_empty() {
            kept.push((0, 0.0, 0.0)); // a point needs a coordinate, even one that says nothing
        }
        Self { kept, dimensions }
    }

    /// Dimensions that are kept; never 0.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    /// Dimensions of the features that go in.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Standardised features of one point; `out` has length [`Standardization::kept`].
    pub fn apply(&self, features: &[f64], out: &mut [f32]) {
        assert_eq!(features.len(), self.dimensions, "features of another length than those fitted");
        for (out, (k, centre, scale)) in out.iter_mut().zip(&self.kept) {
            *out = ((features[*k as usize] - centre) * scale) as f32;
        }
    }

    /// Standardised features of many points, row major.
    pub fn apply_all(&self, features: &[f64]) -> Vec<f64> {
        let rows = features.chunks_exact(self.dimensions);
        rows.flat_map(|row| self.kept.iter().map(|(k, centre, scale)| (row[*k as usize] - centre) * scale)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_dimensions_are_dropped() {
        let features = [1.0, 0.1, 10.0, 3.0, 0.1, 50.0];
        let per_dimension = Standardization::fit(&features, 3, Scaling::PerDimension);
        assert_eq!(per_dimension.apply_all(&features), [-1.0, -1.0, 1.0, 1.0]);
        let global = Standardization::fit(&features, 3, Scaling::Global);
        let all = global.apply_all(&features);
        assert!((all[3] / all[2] - 20.0).abs() < 1e-12);
        assert!((all.iter().map(|x| x * x).sum::<f64>() - 4.0).abs() < 1e-12);
        let constant = Standardization::fit(&[2.0, 2.0], 1, Scaling::Global);
        assert_eq!((constant.kept(), constant.apply_all(&[2.0])), (1, vec![0.0]));
    }
}

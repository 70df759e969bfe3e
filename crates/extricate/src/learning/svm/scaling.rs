//! Centres and scales features for a kernel, and drops directions without variance.

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// Directions whose variances add up to at most this share of the total are dropped: distances in
/// `f32` are no more exact.
const NEGLIGIBLE_VARIANCE_SHARE: f64 = 1e-8;

/// Points processed together: few enough to stay in a fast cache.
const POINTS_PER_CHUNK: usize = 256;

/// How features are brought to a common scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scaling {
    /// Scales each dimension to unit variance, for features whose units differ.
    PerDimension,
    /// Scales all dimensions by one factor to unit mean variance, for embeddings, which have a
    /// metric.
    Global,
}

/// The map `x -> B (x - centre) * scale` on the dimensions that vary. The rows of `B` are
/// orthonormal and span the directions in which the features vary.
///
/// Poses of connected links are redundant: the 80 numbers of seven links span 38 directions.
/// Dropping the others leaves distances as they are, and a kernel takes half the work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Standardization {
    /// Dimensions that vary, ascending, each with its centre and scale.
    varying: Vec<(u32, f64, f64)>,
    dimensions: usize,
    /// `B`, row major; empty if every direction is kept.
    basis: Vec<f64>,
}

impl Standardization {
    /// Fits the map to `features` (`n x dimensions`, row major), and drops dimensions that do not
    /// vary.
    ///
    /// # Guarantee
    /// Apart from the scale, mean squared distances between the points change by at most
    /// `2 * NEGLIGIBLE_VARIANCE_SHARE` of their mean square.
    ///
    /// # Cost
    /// `O(n dimensions^2 + dimensions^3)`.
    pub fn fit(features: &[f64], dimensions: usize, scaling: Scaling) -> Self {
        let count = (features.len() / dimensions).max(1) as f64;
        let mut mean = vec![0.0; dimensions];
        for row in features.chunks_exact(dimensions) {
            mean.iter_mut().zip(row).for_each(|(m, x)| *m += x);
        }
        mean.iter_mut().for_each(|m| *m /= count);
        let mut variance = vec![0.0; dimensions];
        for row in features.chunks_exact(dimensions) {
            variance.iter_mut().zip(row.iter().zip(&mean)).for_each(|(v, (x, m))| *v += (x - m).powi(2));
        }
        variance.iter_mut().for_each(|v| *v /= count);
        // A dimension below this varies only by rounding of its values and of their mean.
        let varies = |k: &usize| variance[*k].sqrt() > 1e-12 * (1.0 + mean[*k].abs());
        let varying: Vec<usize> = (0..dimensions).filter(varies).collect();
        let mean_variance = varying.iter().map(|k| variance[*k]).sum::<f64>() / varying.len().max(1) as f64;
        let scale = |k: usize| match scaling {
            Scaling::PerDimension => 1.0 / variance[k].sqrt(),
            Scaling::Global => 1.0 / mean_variance.sqrt(),
        };
        let mut varying: Vec<_> = varying.iter().map(|k| (*k as u32, mean[*k], scale(*k))).collect();
        if varying.is_empty() {
            varying.push((0, 0.0, 0.0)); // a point needs a coordinate, even one that says nothing
        }
        let mut all = Self { varying, dimensions, basis: Vec::new() };
        all.basis = all.span(features);
        all
    }

    /// Whether a map read from bytes takes `dimensions` features and has finite numbers.
    pub fn is_sound(&self, dimensions: usize) -> bool {
        let Self { varying, basis, .. } = self;
        let finite = |(k, centre, scale): &(u32, f64, f64)| {
            (*k as usize) < dimensions && centre.is_finite() && scale.is_finite()
        };
        self.dimensions == dimensions
            && !varying.is_empty()
            && varying.len() <= dimensions
            && varying.iter().all(finite)
            && basis.len().is_multiple_of(varying.len())
            && basis.len() <= varying.len() * varying.len()
            && basis.iter().all(|x| x.is_finite())
    }

    /// Number of dimensions that come out; never 0.
    pub fn kept(&self) -> usize {
        if self.basis.is_empty() { self.varying.len() } else { self.basis.len() / self.varying.len() }
    }

    /// Number of features that go in.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes the standardised features of one point to `out`, of length [`Standardization::kept`].
    pub fn apply(&self, features: &[f64], out: &mut [f32]) {
        assert_eq!(features.len(), self.dimensions, "features of another length than those fitted");
        let scaled = |(k, centre, scale): &(u32, f64, f64)| (features[*k as usize] - centre) * scale;
        if self.basis.is_empty() {
            out.iter_mut().zip(&self.varying).for_each(|(out, varying)| *out = scaled(varying) as f32);
            return;
        }
        for (out, direction) in out.iter_mut().zip(self.basis.chunks_exact(self.varying.len())) {
            *out = direction.iter().zip(&self.varying).map(|(b, varying)| b * scaled(varying)).sum::<f64>() as f32;
        }
    }

    /// Returns the standardised features of many points, row major.
    pub fn apply_all(&self, features: &[f64]) -> Vec<f64> {
        if self.basis.is_empty() {
            return self.scaled(features);
        }
        let width = self.varying.len();
        let basis = DMatrix::from_row_slice(self.kept(), width, &self.basis);
        let mut all = Vec::with_capacity(features.len() / self.dimensions * self.kept());
        for features in features.chunks(POINTS_PER_CHUNK * self.dimensions) {
            // Columns are points.
            let points = DMatrix::from_vec(width, features.len() / self.dimensions, self.scaled(features));
            all.extend_from_slice((&basis * points).as_slice());
        }
        all
    }

    /// The dimensions that vary, centred and scaled, row major.
    fn scaled(&self, features: &[f64]) -> Vec<f64> {
        let mut scaled = Vec::with_capacity(features.len() / self.dimensions * self.varying.len());
        for row in features.chunks_exact(self.dimensions) {
            scaled.extend(self.varying.iter().map(|(k, centre, scale)| (row[*k as usize] - centre) * scale));
        }
        scaled
    }

    /// Returns an orthonormal basis (row major) of the directions in which the scaled `features`
    /// vary, largest variance first. It is empty if they vary in every direction.
    ///
    /// # Source
    /// K. Pearson, "On lines and planes of closest fit to systems of points in space", 1901,
    /// doi:10.1080/14786440109462720.
    fn span(&self, features: &[f64]) -> Vec<f64> {
        let width = self.varying.len();
        let mut scatter = DMatrix::zeros(width, width);
        for features in features.chunks(POINTS_PER_CHUNK * self.dimensions) {
            // Columns are points.
            let points = DMatrix::from_vec(width, features.len() / self.dimensions, self.scaled(features));
            scatter.gemm(1.0, &points, &points.transpose(), 1.0);
        }
        let eigen = SymmetricEigen::new(scatter);
        let mut order: Vec<usize> = (0..width).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]).then(a.cmp(b)));
        let most = NEGLIGIBLE_VARIANCE_SHARE * eigen.eigenvalues.iter().sum::<f64>();
        let mut dropped = 0.0;
        while order.len() > 1 && dropped + eigen.eigenvalues[order[order.len() - 1]].max(0.0) <= most {
            dropped += eigen.eigenvalues[order[order.len() - 1]].max(0.0);
            order.pop();
        }
        if order.len() == width {
            return Vec::new();
        }
        order.iter().flat_map(|k| eigen.eigenvectors.column(*k).iter().copied().collect::<Vec<f64>>()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn constant_dimensions_are_dropped() {
        let features = [1.0, 0.1, 10.0, 3.0, 0.1, 50.0, 3.0, 0.1, 10.0];
        let per_dimension = Standardization::fit(&features, 3, Scaling::PerDimension);
        let all = per_dimension.apply_all(&features);
        assert_eq!((per_dimension.kept(), all.len()), (2, 6));
        for k in 0..2 {
            assert!(((0..3).map(|i| all[2 * i + k].powi(2)).sum::<f64>() - 3.0).abs() < 1e-12);
        }
        let global = Standardization::fit(&features, 3, Scaling::Global);
        let all = global.apply_all(&features);
        assert!(((all[3] - all[1]) / (all[2] - all[0]) - 20.0).abs() < 1e-12);
        assert!((all.iter().map(|x| x * x).sum::<f64>() - 6.0).abs() < 1e-12);
        let constant = Standardization::fit(&[2.0, 2.0], 1, Scaling::Global);
        assert_eq!((constant.kept(), constant.apply_all(&[2.0])), (1, vec![0.0]));
        assert_eq!(Standardization::fit(&[], 4, Scaling::Global).kept(), 1);
    }

    #[test]
    fn directions_without_spread_are_dropped_and_distances_stay() {
        let (n, wide, narrow) = (300, 40, 7);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut random = |count: usize| (0..count).map(|_| rng.random::<f64>() - 0.5).collect::<Vec<f64>>();
        let (directions, weights) = (random(wide * narrow), random(n * narrow));
        let coordinate = |i: usize, k: usize| -> f64 {
            3.0 + (0..narrow).map(|j| weights[i * narrow + j] * directions[j * wide + k]).sum::<f64>()
        };
        let features: Vec<f64> = (0..n * wide).map(|at| coordinate(at / wide, at % wide)).collect();
        let standardization = Standardization::fit(&features, wide, Scaling::Global);
        assert_eq!(standardization.kept(), narrow);
        let (all, mut one) = (standardization.apply_all(&features), vec![0.0; narrow]);
        let distance = |rows: &[f64], width: usize, i: usize, j: usize| -> f64 {
            (0..width).map(|k| (rows[i * width + k] - rows[j * width + k]).powi(2)).sum::<f64>().sqrt()
        };
        let scale = distance(&all, narrow, 0, 1) / distance(&features, wide, 0, 1);
        for i in 0..n {
            let (near, far) = (distance(&all, narrow, 0, i), scale * distance(&features, wide, 0, i));
            assert!((near - far).abs() < 1e-6, "{near} {far}");
            standardization.apply(&features[i * wide..][..wide], &mut one);
            assert!((0..narrow).all(|k| (f64::from(one[k]) - all[i * narrow + k]).abs() < 1e-5));
        }
    }
}

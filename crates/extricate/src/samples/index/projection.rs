//! Reduces dimensions for the index, by projection onto the directions of largest variance.

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Factor of the basis that keeps projected distances below true ones in spite of rounding.
const BASIS_SCALE: f64 = 1.0 - 1e-9;

/// Largest error of a product of two rows of a basis. With as many rows as an index has, they then
/// lengthen by less than [`BASIS_SCALE`] shortens.
const ORTHONORMALITY_TOLERANCE: f64 = 1e-11;

/// A linear map from R^m to R^k that lengthens nothing.
///
/// # Guarantee
/// `|apply(a) - apply(b)| <= |a - b|` for all finite `a` and `b` whose norm is below about a
/// million times their distance; nearer pairs may gain a rounding error of some 1e-15 of the norm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Projection {
    dimensions: usize,
    /// `k` rows of `dimensions` orthonormal coordinates, times [`BASIS_SCALE`]; the direction of
    /// greatest variance first.
    basis: Vec<f64>,
}

impl Projection {
    /// Fits at most `k` principal components of `points` (`n x dimensions`, row major).
    ///
    /// # Cost
    /// `O(n dimensions^2 + dimensions^3)`.
    ///
    /// # Source
    /// K. Pearson, "On lines and planes of closest fit to systems of points in space", 1901,
    /// doi:10.1080/14786440109462720.
    pub fn fit(points: &[f64], dimensions: usize, k: usize) -> Self {
        assert!(dimensions > 0 && points.len().is_multiple_of(dimensions), "rows are not {dimensions} wide");
        let n = points.len() / dimensions;
        let rows = DMatrix::from_row_slice(n, dimensions, points);
        let mean = rows.row_sum() / n.max(1) as f64;
        let centred = DMatrix::from_fn(n, dimensions, |i, j| rows[(i, j)] - mean[j]);
        let eigen = SymmetricEigen::new(centred.tr_mul(&centred));
        let mut order: Vec<usize> = (0..dimensions).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]).then(a.cmp(b)));
        order.truncate(k);
        let basis = order
            .iter()
            .flat_map(|c| eigen.eigenvectors.column(*c).iter().map(|x| x * BASIS_SCALE).collect::<Vec<_>>());
        Self { dimensions, basis: basis.collect() }
    }

    /// Restores a projection from its basis, of `dimensions` numbers a row. Returns `None` unless
    /// the rows are orthonormal up to rounding, times the factor of a fit: then the map lengthens
    /// nothing, wherever it comes from.
    pub fn from_basis(basis: &[f64], dimensions: usize) -> Option<Self> {
        let rows: Vec<&[f64]> = basis.chunks(dimensions.max(1)).collect();
        let expected = |same: bool| if same { BASIS_SCALE * BASIS_SCALE } else { 0.0 };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let is_near =
            |(i, j): (usize, usize)| (dot(rows[i], rows[j]) - expected(i == j)).abs() < ORTHONORMALITY_TOLERANCE;
        let is_whole = !rows.is_empty() && rows.len() <= dimensions && basis.len().is_multiple_of(dimensions);
        let sound = is_whole && (0..rows.len()).all(|i| (0..=i).all(|j| is_near((i, j))));
        sound.then(|| Self { dimensions, basis: basis.to_vec() })
    }

    /// Rows of the basis, row major.
    pub fn basis(&self) -> &[f64] {
        &self.basis
    }

    /// Number of dimensions that go in.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Number of dimensions that come out.
    pub fn projected_dimensions(&self) -> usize {
        self.basis.len() / self.dimensions
    }

    /// Writes the projection of one point to `out`, of length [`Projection::projected_dimensions`].
    pub fn apply(&self, point: &[f64], out: &mut [f64]) {
        assert_eq!(point.len(), self.dimensions, "a point of another dimension than those fitted");
        for (out, direction) in out.iter_mut().zip(self.basis.chunks_exact(self.dimensions)) {
            *out = direction.iter().zip(point).map(|(a, b)| a * b).sum();
        }
    }

    /// Returns the projections of many points, row major.
    pub fn apply_all(&self, points: &[f64]) -> Vec<f64> {
        let k = self.projected_dimensions();
        let mut out = vec![0.0; points.len() / self.dimensions * k];
        let rows = points.par_chunks_exact(self.dimensions).zip(out.par_chunks_exact_mut(k.max(1)));
        rows.for_each(|(point, out)| self.apply(point, out));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn lengthens_nothing_and_keeps_the_plane_that_points_lie_in() {
        let (m, n) = (30, 200);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut random = |count: usize| (0..count).map(|_| rng.random::<f64>() - 0.5).collect::<Vec<f64>>();
        let (plane, weights, off) = (random(3 * m), random(3 * n), random(m * n));
        let point = |i: usize, noise: f64| -> Vec<f64> {
            (0..m)
                .map(|k| (0..3).map(|j| weights[3 * i + j] * plane[j * m + k]).sum::<f64>() + noise * off[i * m + k])
                .collect()
        };
        let length = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
        for (noise, k) in [(0.0, 3), (0.5, 8), (0.5, m)] {
            let points: Vec<f64> = (0..n).flat_map(|i| point(i, noise)).collect();
            let projection = Projection::fit(&points, m, k);
            assert_eq!(projection.projected_dimensions(), k);
            let projected = projection.apply_all(&points);
            for i in 1..n {
                let far = length(&points[..m], &points[i * m..][..m]);
                let near = length(&projected[..k], &projected[i * k..][..k]);
                assert!(near <= far, "{near} {far}");
                let complete = noise == 0.0 || k == m;
                assert!(!complete || near > far * (1.0 - 1e-6), "{near} {far}");
            }
        }
    }

    #[test]
    fn only_a_basis_that_lengthens_nothing_is_taken() {
        let points: Vec<f64> = (0..60).map(|i| (f64::from(i) * 1.7).sin()).collect();
        let fitted = Projection::fit(&points, 6, 3);
        assert_eq!(Projection::from_basis(fitted.basis(), 6), Some(fitted.clone()));
        for at in 0..18 {
            let mut spoiled = fitted.basis().to_vec();
            spoiled[at] += 1e-6;
            assert_eq!(Projection::from_basis(&spoiled, 6), None, "{at}");
            spoiled[at] = f64::NAN;
            assert_eq!(Projection::from_basis(&spoiled, 6), None, "{at}");
        }
        assert_eq!(Projection::from_basis(&fitted.basis()[..17], 6), None);
        assert_eq!(Projection::from_basis(&[], 6), None);
        assert_eq!(Projection::from_basis(&[], 0), None);
    }

    #[test]
    fn no_points_give_a_projection_too() {
        let projection = Projection::fit(&[], 4, 2);
        let mut out = [0.0; 2];
        projection.apply(&[1.0, 0.0, 0.0, 0.0], &mut out);
        assert!(out[0].hypot(out[1]) <= 1.0);
    }
}

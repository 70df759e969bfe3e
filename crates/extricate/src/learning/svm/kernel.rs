//! Points stored for vector instructions, and the Gaussian kernel over them; without labels.

use serde::{Deserialize, Serialize};

pub use crate::math::{LANES, vectorized};

/// Blocks evaluated together, because additions to one sum wait for each other.
const BLOCKS_PER_GROUP: usize = 4;

/// Queries whose distances to a block are computed together.
pub const TOGETHER: usize = 4;

/// `n` points of `dimensions` coordinates as `f32`, in blocks of [`LANES`] points. Within a block,
/// coordinate `k` of all points is contiguous, so a scan needs no gathers. The last block is
/// padded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointSet {
    len: usize,
    dimensions: usize,
    blocks: Vec<[f32; LANES]>,
}

impl PointSet {
    /// Stores `rows.len() / dimensions` points (row major), rounded to `f32`.
    pub fn from_rows(rows: &[f64], dimensions: usize) -> Self {
        Self::from_rows_padded(rows, dimensions, 0.0)
    }

    /// Does the same as [`PointSet::from_rows`], with `padding` in place of zero.
    pub fn from_rows_padded(rows: &[f64], dimensions: usize, padding: f32) -> Self {
        assert!(dimensions > 0 && rows.len().is_multiple_of(dimensions), "rows are not {dimensions} wide");
        let len = rows.len() / dimensions;
        let mut blocks = vec![[padding; LANES]; len.div_ceil(LANES) * dimensions];
        for (i, row) in rows.chunks_exact(dimensions).enumerate() {
            for (k, x) in row.iter().enumerate() {
                blocks[i / LANES * dimensions + k][i % LANES] = *x as f32;
            }
        }
        Self { len, dimensions, blocks }
    }

    /// Whether a set read from bytes has consistent lengths and finite numbers.
    fn is_sound(&self) -> bool {
        let rows = self.len.div_ceil(LANES).checked_mul(self.dimensions);
        self.dimensions > 0
            && rows == Some(self.blocks.len())
            && self.blocks.as_flattened().iter().all(|x| x.is_finite())
    }

    /// Number of points, padding excluded.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the set has no point.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of coordinates of a point.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Number of blocks: `len / LANES`, rounded up.
    pub fn block_count(&self) -> usize {
        self.len.div_ceil(LANES)
    }

    /// Coordinate `k` of point `i`.
    pub fn coordinate(&self, i: usize, k: usize) -> f32 {
        self.blocks[i / LANES * self.dimensions + k][i % LANES]
    }

    /// Returns the given points in the given order.
    pub fn gather(&self, points: &[u32]) -> Self {
        let mut blocks = vec![[0.0; LANES]; points.len().div_ceil(LANES) * self.dimensions];
        for (i, point) in points.iter().enumerate() {
            for k in 0..self.dimensions {
                blocks[i / LANES * self.dimensions + k][i % LANES] = self.coordinate(*point as usize, k);
            }
        }
        Self { len: points.len(), dimensions: self.dimensions, blocks }
    }

    /// Copies point `i` to `out`, of length `dimensions`.
    pub fn copy_point(&self, i: usize, out: &mut [f32]) {
        for (k, x) in out.iter_mut().enumerate() {
            *x = self.coordinate(i, k);
        }
    }

    /// The blocks `first..last`, each `dimensions` rows of [`LANES`] coordinates.
    #[inline(always)]
    pub fn blocks(&self, first: usize, last: usize) -> std::slice::ChunksExact<'_, [f32; LANES]> {
        self.blocks[first * self.dimensions..last * self.dimensions].chunks_exact(self.dimensions)
    }

    /// Rows of all blocks, block after block: one row of [`LANES`] points for each coordinate.
    #[inline(always)]
    pub fn rows(&self) -> &[[f32; LANES]] {
        &self.blocks
    }

    /// All blocks, [`BLOCKS_PER_GROUP`] at a time.
    #[inline(always)]
    fn groups(&self) -> std::slice::Chunks<'_, [f32; LANES]> {
        self.blocks.chunks(BLOCKS_PER_GROUP * self.dimensions)
    }
}

/// Squared distances from `query` to the points of one block.
///
/// It sums squared differences, because `|x|^2 - 2xy + |y|^2` cancels for near points. The relative
/// error is at most `(dimensions + 2) * 2^-24`, and the distance from x to y equals that from y to
/// x to the last bit.
#[inline(always)]
pub fn block_distances_squared(block: &[[f32; LANES]], query: &[f32]) -> [f32; LANES] {
    let mut sums = [0.0; LANES];
    for (coordinates, x) in block.iter().zip(query) {
        for lane in 0..LANES {
            let difference = coordinates[lane] - x;
            sums[lane] += difference * difference;
        }
    }
    sums
}

/// Computes [`block_distances_squared`] of [`TOGETHER`] queries, equal to the last bit. Several
/// sums overlap, while additions to one sum wait for each other.
#[inline(always)]
pub fn block_distances_squared_of(block: &[[f32; LANES]], queries: [&[f32]; TOGETHER]) -> [[f32; LANES]; TOGETHER] {
    let mut sums = [[0.0; LANES]; TOGETHER];
    let [a, b, c, d] = queries;
    for ((((coordinates, a), b), c), d) in block.iter().zip(a).zip(b).zip(c).zip(d) {
        for lane in 0..LANES {
            let x = coordinates[lane];
            let differences = [x - a, x - b, x - c, x - d];
            sums[0][lane] += differences[0] * differences[0];
            sums[1][lane] += differences[1] * differences[1];
            sums[2][lane] += differences[2] * differences[2];
            sums[3][lane] += differences[3] * differences[3];
        }
    }
    sums
}

/// Computes `exp(-gamma * |query - x|^2)` for every point `x` of `points`, one block of results for
/// each block of points. Results in the padding are meaningless.
pub fn kernel_row(points: &PointSet, query: &[f32], gamma: f64, out: &mut [[f32; LANES]]) {
    let exponent = exponent_scale(gamma);
    vectorized(
        #[inline(always)]
        || {
            for (group, out) in points.groups().zip(out.chunks_mut(BLOCKS_PER_GROUP)) {
                group_kernels(group, query, exponent, out);
            }
        },
    );
}

/// Points with a weight each, for sums of kernel values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WeightedPoints {
    points: PointSet,
    /// Zero in the padding.
    weights: Vec<[f64; LANES]>,
}

impl WeightedPoints {
    /// Joins points with their weights, one a point.
    pub fn new(points: PointSet, weights: &[f64]) -> Self {
        assert_eq!(points.len(), weights.len(), "one weight a point");
        let mut padded = vec![[0.0; LANES]; points.block_count()];
        weights.iter().enumerate().for_each(|(i, w)| padded[i / LANES][i % LANES] = *w);
        Self { points, weights: padded }
    }

    /// Whether points and weights read from bytes are finite and of equal number.
    pub fn is_sound(&self) -> bool {
        self.points.is_sound()
            && self.weights.len() == self.points.block_count()
            && self.weights.as_flattened().iter().all(|x| x.is_finite())
    }

    /// The points, without their weights.
    pub fn points(&self) -> &PointSet {
        &self.points
    }

    /// `sum_i weight_i exp(-gamma |query - x_i|^2)`, added up in `f64` as weights of both signs
    /// cancel.
    pub fn kernel_sum(&self, query: &[f32], gamma: f64) -> f64 {
        let exponent = exponent_scale(gamma);
        let sums = vectorized(
            #[inline(always)]
            move || {
                let mut sums = [0.0; LANES];
                for (group, weights) in self.points.groups().zip(self.weights.chunks(BLOCKS_PER_GROUP)) {
                    let mut values = [[0.0; LANES]; BLOCKS_PER_GROUP];
                    group_kernels(group, query, exponent, &mut values[..weights.len()]);
                    for (values, weights) in values.iter().zip(weights) {
                        for lane in 0..LANES {
                            sums[lane] += weights[lane] * f64::from(values[lane]);
                        }
                    }
                }
                sums
            },
        );
        sums.iter().sum()
    }
}

/// Returns the `exponent` of [`block_kernel`] for `exp(-gamma ...)`: `-gamma / ln 2`.
pub fn exponent_scale(gamma: f64) -> f32 {
    (-gamma * std::f64::consts::LOG2_E) as f32
}

/// Kernel values between `query` and one block; `exponent` is [`exponent_scale`] of gamma.
#[inline(always)]
pub fn block_kernel(block: &[[f32; LANES]], query: &[f32], exponent: f32) -> [f32; LANES] {
    exponentials(block_distances_squared(block, query), exponent)
}

/// Computes [`block_kernel`] of up to [`BLOCKS_PER_GROUP`] blocks, equal to the last bit.
#[inline(always)]
fn group_kernels(group: &[[f32; LANES]], query: &[f32], exponent: f32, out: &mut [[f32; LANES]]) {
    let [a, b, c, d] = out else {
        for (block, out) in group.chunks_exact(query.len()).zip(out) {
            *out = block_kernel(block, query, exponent);
        }
        return;
    };
    let (first, second) = group.split_at(2 * query.len());
    let ((first, second), (third, fourth)) = (first.split_at(query.len()), second.split_at(query.len()));
    let mut sums = [[0.0; LANES]; BLOCKS_PER_GROUP];
    for ((((p, q), r), s), x) in first.iter().zip(second).zip(third).zip(fourth).zip(query) {
        for lane in 0..LANES {
            let differences = [p[lane] - x, q[lane] - x, r[lane] - x, s[lane] - x];
            sums[0][lane] += differences[0] * differences[0];
            sums[1][lane] += differences[1] * differences[1];
            sums[2][lane] += differences[2] * differences[2];
            sums[3][lane] += differences[3] * differences[3];
        }
    }
    *a = exponentials(sums[0], exponent);
    *b = exponentials(sums[1], exponent);
    *c = exponentials(sums[2], exponent);
    *d = exponentials(sums[3], exponent);
}

/// Kernel values from squared distances.
#[inline(always)]
fn exponentials(mut values: [f32; LANES], exponent: f32) -> [f32; LANES] {
    // A loop, because `map` is not inlined reliably, and then compiled for the oldest processor.
    for value in &mut values {
        *value = exp2_negative(exponent * *value);
    }
    values
}

/// Returns `2^x` for `x <= 0`, without a branch or a call: exactly 1 at 0, and `2^-126` for all
/// `x < -126`.
///
/// # Guarantee
/// Relative error below 2e-7, measured over 400,000 arguments in `[-126, 0]`.
///
/// # Source
/// Coefficients of `exp2f` of S. L. Moshier's Cephes library (a minimax polynomial on `[-1/2,
/// 1/2]`).
#[inline(always)]
pub fn exp2_negative(x: f32) -> f32 {
    // Adding 1.5 * 2^23 leaves the nearest integer in the low bits of the sum; no conversion
    // instruction is needed.
    const ROUND: f32 = 12_582_912.0;
    let x = if x < -126.0 { -126.0 } else { x };
    let shifted = x + ROUND;
    let f = x - (shifted - ROUND);
    let mut p = 1.535_336_2e-4;
    p = p * f + 1.339_887_4e-3;
    p = p * f + 9.618_437e-3;
    p = p * f + 5.550_332_5e-2;
    p = p * f + 2.402_264_8e-1;
    p = p * f + 6.931_472e-1;
    p = p * f + 1.0;
    p * f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp2_keeps_its_error() {
        assert_eq!(exp2_negative(0.0), 1.0);
        assert!(exp2_negative(-1e30) < 1e-37 && exp2_negative(f32::NEG_INFINITY) < 1e-37);
        let mut worst: f64 = 0.0;
        for i in 0..400_000 {
            let x = -126.0 * (i as f32) / 400_000.0;
            let exact = f64::from(x).exp2();
            worst = worst.max((f64::from(exp2_negative(x)) / exact - 1.0).abs());
        }
        assert!(worst < 2e-7, "{worst}");
    }

    #[test]
    fn kernel_row_matches_f64() {
        let (n, d, gamma) = (37, 5, 0.7);
        let rows: Vec<f64> = (0..n * d).map(|i| f64::from((i as f32 * 0.71).sin() * 2.0)).collect();
        let points = PointSet::from_rows(&rows, d);
        let mut row = vec![[0.0; LANES]; points.block_count()];
        let mut query = vec![0.0; d];
        for i in 0..n {
            points.copy_point(i, &mut query);
            kernel_row(&points, &query, gamma, &mut row);
            assert_eq!(row[i / LANES][i % LANES], 1.0);
            for j in 0..n {
                let squared: f64 = (0..d).map(|k| (rows[i * d + k] - rows[j * d + k]).powi(2)).sum();
                let error = (f64::from(row[j / LANES][j % LANES]) / (-gamma * squared).exp() - 1.0).abs();
                assert!(error < 1e-5, "{i} {j} {error}");
            }
        }
    }
}

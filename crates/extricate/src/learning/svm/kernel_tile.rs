//! Sums of kernel values between two sets of points, in tiles of both to reuse loaded values.
//!
//! Without tiles, the sum for one point reads all others, more than the fastest cache holds, for
//! three operations each. Kernel values equal those of [`super::kernel`] to the last bit.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::kernel::{LANES, PointSet, block_kernel, exp2_negative, exponent_scale};
use crate::math::simd::F32s;

/// Blocks and centres of a tile: as many as fit into sixteen registers.
const TILE_BLOCKS: usize = 2;
const TILE_CENTRES: usize = 4;

/// Blocks that one task takes through all centres: few enough to stay in the fastest cache.
const RESIDENT_BLOCKS: usize = 16;

/// Returns `sum_j weight_j exp(-gamma |centre_j - x|^2)` for every point `x` of `points`, added up
/// in `f64` in the order of the centres.
pub fn kernel_sums(points: &PointSet, centres: &PointSet, weights: &[f64], gamma: f64) -> Vec<f64> {
    assert_eq!(centres.len(), weights.len(), "one weight a centre");
    let dimensions = points.dimensions();
    let centres: Vec<f32> =
        (0..centres.len()).flat_map(|i| (0..dimensions).map(move |k| centres.coordinate(i, k))).collect();
    let mut sums = vec![[0.0; LANES]; points.block_count()];
    let chunks = sums.par_chunks_mut(RESIDENT_BLOCKS).zip(points.rows().par_chunks(RESIDENT_BLOCKS * dimensions));
    chunks.for_each(|(sums, blocks)| {
        Arch::new().dispatch(Sums {
            blocks,
            dimensions,
            centres: &centres,
            weights,
            exponent: exponent_scale(gamma),
            sums,
        });
    });
    sums.into_iter().flatten().take(points.len()).collect()
}

struct Sums<'a> {
    blocks: &'a [[f32; LANES]],
    dimensions: usize,
    /// Row major, `dimensions` coordinates each.
    centres: &'a [f32],
    weights: &'a [f64],
    exponent: f32,
    sums: &'a mut [[f64; LANES]],
}

impl WithSimd for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { blocks, dimensions, centres, weights, exponent, sums } = self;
        for (centres, weights) in centres.chunks(TILE_CENTRES * dimensions).zip(weights.chunks(TILE_CENTRES)) {
            for (blocks, sums) in blocks.chunks(TILE_BLOCKS * dimensions).zip(sums.chunks_mut(TILE_BLOCKS)) {
                let mut values = [[[0.0; LANES]; TILE_CENTRES]; TILE_BLOCKS];
                tile(simd, blocks, centres, dimensions, exponent, &mut values);
                for (sums, values) in sums.iter_mut().zip(&values) {
                    for (values, weight) in values.iter().zip(weights) {
                        for lane in 0..LANES {
                            sums[lane] += weight * f64::from(values[lane]);
                        }
                    }
                }
            }
        }
    }
}

/// Kernel values of up to [`TILE_BLOCKS`] blocks with up to [`TILE_CENTRES`] centres.
#[inline(always)]
fn tile<S: Simd>(
    simd: S,
    blocks: &[[f32; LANES]],
    centres: &[f32],
    dimensions: usize,
    exponent: f32,
    values: &mut [[[f32; LANES]; TILE_CENTRES]; TILE_BLOCKS],
) {
    if blocks.len() < TILE_BLOCKS * dimensions || centres.len() < TILE_CENTRES * dimensions {
        for (block, values) in blocks.chunks_exact(dimensions).zip(values) {
            for (centre, values) in centres.chunks_exact(dimensions).zip(values) {
                *values = block_kernel(block, centre, exponent);
            }
        }
        return;
    }
    let (first, second) = blocks.split_at(dimensions);
    let (a, rest) = centres.split_at(dimensions);
    let (b, rest) = rest.split_at(dimensions);
    let (c, d) = rest.split_at(dimensions);
    for at in 0..F32s::<S>::COUNT {
        let zero = F32s::splat(simd, 0.0);
        let (mut near, mut far) = ([zero; TILE_CENTRES], [zero; TILE_CENTRES]);
        for (((((p, q), a), b), c), d) in first.iter().zip(second).zip(a).zip(b).zip(c).zip(d) {
            let (p, q) = (F32s::load(simd, p, at), F32s::load(simd, q, at));
            let x = [*a, *b, *c, *d].map(|x| F32s::splat(simd, x));
            for j in 0..TILE_CENTRES {
                let (u, v) = (p - x[j], q - x[j]);
                near[j] = near[j] + u * u;
                far[j] = far[j] + v * v;
            }
        }
        let [first, second] = &mut *values;
        for j in 0..TILE_CENTRES {
            near[j].store(&mut first[j], at);
            far[j].store(&mut second[j], at);
        }
    }
    for value in values.as_flattened_mut().as_flattened_mut() {
        *value = exp2_negative(exponent * *value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::svm::kernel::kernel_row;

    /// Some sizes leave tiles and blocks partly filled.
    #[test]
    fn sums_are_those_of_kernel_rows_to_the_last_bit() {
        for (points, centres, dimensions) in [(300, 101, 5), (16, 4, 1), (7, 3, 38), (9, 0, 2), (0, 5, 2)] {
            let set = |n: usize, phase: f64| -> PointSet {
                let rows: Vec<f64> = (0..n * dimensions).map(|i| (i as f64 * 0.71 + phase).sin() * 2.0).collect();
                PointSet::from_rows(&rows, dimensions)
            };
            let (points, centres) = (set(points, 0.0), set(centres, 0.3));
            let weights: Vec<f64> = (0..centres.len()).map(|j| (j as f64 * 1.3).cos()).collect();
            let mut expected = vec![0.0; points.len()];
            let (mut row, mut centre) = (vec![[0.0; LANES]; points.block_count()], vec![0.0; dimensions]);
            for (j, weight) in weights.iter().enumerate() {
                centres.copy_point(j, &mut centre);
                kernel_row(&points, &centre, 0.7, &mut row);
                let values = row.as_flattened();
                expected.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * f64::from(*value));
            }
            assert_eq!(kernel_sums(&points, &centres, &weights, 0.7), expected);
        }
    }
}

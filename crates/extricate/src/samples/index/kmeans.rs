//! Seeded k-means, which places the centres of the lists. Its quality affects speed, never answers.

use arrayvec::ArrayVec;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use crate::learning::svm::kernel::{LANES, PointSet, TOGETHER, block_distances_squared_of, vectorized};

/// Rounds of assignment and averaging; more than a few gain the index nothing measurable.
const LLOYD_ROUNDS: usize = 5;

const TRAINING_POINTS_PER_CENTRE: usize = 24;

/// Places `count` centres among `points` (`n x dimensions`, row major) and returns them, row major,
/// rounded to `f32`, with the nearest centre of every point. Centres that attract no point stay
/// where they are.
///
/// # Guarantee
/// The result depends on the arguments alone, not on the number of threads.
///
/// # Source
/// S. P. Lloyd, "Least squares quantization in PCM", 1982, doi:10.1109/TIT.1982.1056489, on a
/// random sample.
pub fn k_means(points: &[f64], dimensions: usize, count: usize, seed: u64) -> (Vec<f64>, Vec<u32>) {
    let n = points.len() / dimensions;
    assert!((1..=n).contains(&count), "{count} centres for {n} points");
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let sample_len = n.min(count * TRAINING_POINTS_PER_CENTRE);
    // Draws the first `sample_len` entries of a random permutation; the first `count` of them are
    // the initial centres.
    let mut order: Vec<u32> = (0..n as u32).collect();
    for i in 0..sample_len {
        order.swap(i, rng.random_range(i..n));
    }
    let row = |i: u32| &points[i as usize * dimensions..(i as usize + 1) * dimensions];
    let rounded = |row: &[f64]| row.iter().map(|x| f64::from(*x as f32)).collect::<Vec<f64>>();
    let mut centres: Vec<f64> = order[..count].iter().flat_map(|i| rounded(row(*i))).collect();
    let sample: Vec<f64> = order[..sample_len].iter().flat_map(|i| row(*i).iter().copied()).collect();
    for _ in 0..LLOYD_ROUNDS {
        let assigned = nearest_centres(&sample, dimensions, &centres);
        let mut sums = vec![0.0; centres.len()];
        let mut members = vec![0usize; count];
        for (row, centre) in sample.chunks_exact(dimensions).zip(&assigned) {
            let centre = *centre as usize;
            members[centre] += 1;
            sums[centre * dimensions..][..dimensions].iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
        for (centre, count) in members.iter().enumerate().filter(|(_, count)| **count > 0) {
            for k in centre * dimensions..(centre + 1) * dimensions {
                centres[k] = f64::from((sums[k] / *count as f64) as f32);
            }
        }
    }
    let assigned = nearest_centres(points, dimensions, &centres);
    (centres, assigned)
}

/// Returns the nearest centre of every point, up to rounding in `f32`; ties go to the first.
fn nearest_centres(points: &[f64], dimensions: usize, centres: &[f64]) -> Vec<u32> {
    let centres = PointSet::from_rows_padded(centres, dimensions, f32::INFINITY);
    let nearest = |rows: &mut Vec<f32>, points: &[f64]| {
        rows.clear();
        rows.extend(points.iter().map(|x| *x as f32));
        // The last chunk may be short; the origin fills it up.
        rows.resize(TOGETHER * dimensions, 0.0);
        let rows = &rows[..];
        let (distances, blocks) = vectorized(
            #[inline(always)]
            || {
                let queries = std::array::from_fn(|i| &rows[i * dimensions..][..dimensions]);
                let (mut least, mut of) = ([[f32::INFINITY; LANES]; TOGETHER], [[0f32; LANES]; TOGETHER]);
                for (b, block) in centres.blocks(0, centres.block_count()).enumerate() {
                    let distances = block_distances_squared_of(block, queries);
                    let b = b as f32; // exact: fewer than 2^24 blocks
                    for ((distances, least), of) in distances.iter().zip(&mut least).zip(&mut of) {
                        for lane in 0..LANES {
                            let nearer = distances[lane] < least[lane];
                            least[lane] = if nearer { distances[lane] } else { least[lane] };
                            of[lane] = if nearer { b } else { of[lane] };
                        }
                    }
                }
                (least, of)
            },
        );
        let best = |(distances, blocks): (&[f32; LANES], &[f32; LANES])| {
            let ids = (0..LANES).map(|lane| (distances[lane], blocks[lane] as usize * LANES + lane));
            let best = ids.filter(|(_, id)| *id < centres.len()).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            best.map_or(0, |(_, id)| id as u32)
        };
        distances.iter().zip(&blocks).take(points.len() / dimensions).map(best).collect::<ArrayVec<u32, TOGETHER>>()
    };
    points.par_chunks(TOGETHER * dimensions).map_init(Vec::new, nearest).flatten_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_separate_clusters() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let corners = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]];
        let points: Vec<f64> =
            (0..900).flat_map(|i| corners[i % 3].map(|x| x + rng.random::<f64>())).collect::<Vec<f64>>();
        let (centres, assigned) = k_means(&points, 2, 30, 7);
        for (point, centre) in points.chunks_exact(2).zip(&assigned) {
            let centre = &centres[*centre as usize * 2..][..2];
            assert!((point[0] - centre[0]).hypot(point[1] - centre[1]) < 1.5);
        }
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let run = || k_means(&points, 2, 30, 7);
        assert_eq!(pool(1).install(run), pool(3).install(run));
    }
}

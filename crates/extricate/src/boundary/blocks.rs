//! Which points of a list stand together in a block, and a ball around each block. No search.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::lists::distance;
use crate::learning::kernel::{LANES, PointSet};

/// Balls around blocks of [`LANES`] points, [`LANES`] balls a *group*; the blocks of a list begin a group.
///
/// Lists of the usual length hold points from all sides, blocks those near each other: of the blocks of lists that have to be looked
/// through, a sixth to a quarter may hold the nearest point in 6 or 7 dimensions, half in 16.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockBalls {
    /// Exactly representable in `f32`; at infinity where a group has no further block.
    pub centres: PointSet,
    /// Greatest distance of a point of the block from its centre, rounded up.
    pub radii: Vec<[f32; LANES]>,
    /// First group of each list, and the end of the last.
    pub starts: Vec<u32>,
}

impl BlockBalls {
    /// Around the blocks of `lists`, each a list of points (indices for `row`) in blocks of [`LANES`], the last of which may be shorter.
    pub fn around<'a>(lists: &[Vec<u32>], dimensions: usize, row: impl Fn(u32) -> &'a [f64] + Sync) -> Self {
        let balls = |list: &Vec<u32>| -> Vec<(Vec<f64>, f32)> {
            list.chunks(LANES).map(|block| ball(block, dimensions, &row)).collect()
        };
        let of_lists: Vec<_> = lists.par_iter().map(balls).collect();
        let (mut centres, mut radii, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for group in of_lists.iter().flat_map(|balls| {
            starts.push(starts[starts.len() - 1] + balls.len().div_ceil(LANES) as u32);
            balls.chunks(LANES)
        }) {
            let mut of_group = [0.0; LANES];
            for (lane, radius) in of_group.iter_mut().enumerate() {
                match group.get(lane) {
                    Some((centre, of_block)) => {
                        centres.extend_from_slice(centre);
                        *radius = *of_block;
                    }
                    None => centres.resize(centres.len() + dimensions, f64::INFINITY),
                }
            }
            radii.push(of_group);
        }
        Self { centres: PointSet::from_rows(&centres, dimensions), radii, starts }
    }
}

/// Around the mean of a block.
fn ball<'a>(block: &[u32], dimensions: usize, row: &impl Fn(u32) -> &'a [f64]) -> (Vec<f64>, f32) {
    let mut centre = vec![0.0; dimensions];
    for id in block {
        centre.iter_mut().zip(row(*id)).for_each(|(sum, x)| *sum += x);
    }
    centre.iter_mut().for_each(|sum| *sum = f64::from((*sum / block.len() as f64) as f32));
    let radius = block.iter().map(|id| distance(row(*id), &centre)).fold(0.0, f64::max);
    (centre, (radius * (1.0 + 1e-6)) as f32)
}

/// Orders a list so that the points of each block are near each other: halved between blocks, along the coordinate in which it spreads
/// most, until one block is left.
pub fn order_by_blocks<'a>(list: &mut [u32], dimensions: usize, row: &impl Fn(u32) -> &'a [f64]) {
    if list.len() <= LANES {
        return list.sort_unstable();
    }
    let (mut low, mut high) = (vec![f64::INFINITY; dimensions], vec![f64::NEG_INFINITY; dimensions]);
    for id in list.iter() {
        for (k, x) in row(*id).iter().enumerate() {
            (low[k], high[k]) = (low[k].min(*x), high[k].max(*x));
        }
    }
    let widest = (0..dimensions).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or(0);
    let half = list.len().div_ceil(LANES) / 2 * LANES;
    list.select_nth_unstable_by(half, |a, b| row(*a)[widest].total_cmp(&row(*b)[widest]).then(a.cmp(b)));
    let (first, second) = list.split_at_mut(half);
    order_by_blocks(first, dimensions, row);
    order_by_blocks(second, dimensions, row);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn balls_hold_their_blocks_and_are_small() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let points: Vec<f64> = (0..3 * 1000).map(|_| rng.random::<f64>()).collect();
        let row = |id: u32| &points[id as usize * 3..][..3];
        let mut lists: Vec<Vec<u32>> = vec![(0..501).collect(), vec![], (501..1000).rev().collect()];
        lists.iter_mut().for_each(|list| order_by_blocks(list, 3, &row));
        let balls = BlockBalls::around(&lists, 3, row);
        // 63 blocks each.
        assert_eq!(balls.starts, [0, 8, 8, 16]);
        let (mut seen, mut centre) = (vec![0; 1000], [0.0; 3]);
        for (list, start) in lists.iter().zip(&balls.starts) {
            for (b, block) in list.chunks(LANES).enumerate() {
                let group = *start as usize + b / LANES;
                balls.centres.copy_point(group * LANES + b % LANES, &mut centre);
                let radius = f64::from(balls.radii[group][b % LANES]);
                for id in block {
                    assert!(distance(row(*id), &centre.map(f64::from)) <= radius);
                    seen[*id as usize] += 1;
                }
                // Half of a cube's diagonal of the volume of eight points is 0.22.
                assert!(radius < 0.45, "{radius}");
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
        balls.centres.copy_point(7 * LANES + 7, &mut centre);
        assert_eq!(centre, [f32::INFINITY; 3], "no further block");
    }
}

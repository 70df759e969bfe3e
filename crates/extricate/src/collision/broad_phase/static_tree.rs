//! A tree of the boxes around bodies that do not move. It finds those that a ball may touch.

use crate::collision::shapes::bounds::{Aabb, ROUNDING};
use crate::math::Vec3;

/// Boxes of a block, which are tested at once.
pub const WIDTH: usize = 8;

/// Boxes side by side. Unused places hold empty boxes, which touch nothing.
#[derive(Debug, Clone)]
struct BoxBlock {
    lower: [[f64; WIDTH]; 3],
    upper: [[f64; WIDTH]; 3],
}

/// A tree of blocks: the boxes of a level enclose the blocks of the level below.
#[derive(Debug, Clone, Default)]
pub struct StillTree {
    /// Levels from the leaves to the root; none without boxes.
    levels: Vec<Vec<BoxBlock>>,
    /// Index of the box at each place of the leaves.
    items: Vec<u32>,
}

impl StillTree {
    /// Builds the tree over boxes in one frame. Hits are reported as indices into `boxes`.
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        arrange(boxes, &mut items);
        let mut levels: Vec<Vec<BoxBlock>> = Vec::new();
        let mut corners: Vec<(Vec3, Vec3)> = items.iter().map(|&i| corners_of(&boxes[i as usize])).collect();
        while !corners.is_empty() {
            let level: Vec<BoxBlock> = corners.chunks(WIDTH).map(BoxBlock::new).collect();
            corners = corners.chunks(WIDTH).map(hull).collect();
            levels.push(level);
            if corners.len() == 1 {
                break;
            }
        }
        Self { levels, items }
    }

    /// Appends the boxes that a ball of radius `reach` \[m\] about `center` may touch, in arbitrary
    /// order.
    #[inline(always)]
    pub fn touched(&self, center: &Vec3, reach: f64, stack: &mut Vec<(u32, u32)>, found: &mut Vec<u32>) {
        let reach = (reach + ROUNDING).max(0.0);
        stack.clear();
        if !self.levels.is_empty() {
            stack.push((self.levels.len() as u32 - 1, 0));
        }
        while let Some((level, block)) = stack.pop() {
            let mut hits = self.levels[level as usize][block as usize].near(center, reach * reach);
            while hits != 0 {
                let place = block * WIDTH as u32 + hits.trailing_zeros();
                hits &= hits - 1;
                if level == 0 {
                    found.push(self.items[place as usize]);
                } else {
                    stack.push((level - 1, place));
                }
            }
        }
    }
}

impl BoxBlock {
    fn new(corners: &[(Vec3, Vec3)]) -> Self {
        let mut block = Self { lower: [[f64::INFINITY; WIDTH]; 3], upper: [[f64::NEG_INFINITY; WIDTH]; 3] };
        for (k, (lower, upper)) in corners.iter().enumerate() {
            for axis in 0..3 {
                (block.lower[axis][k], block.upper[axis][k]) = (lower[axis], upper[axis]);
            }
        }
        block
    }

    /// Returns one bit per box, set if its squared distance from `center` is at most `squared`
    /// [m^2].
    #[inline(always)]
    fn near(&self, center: &Vec3, squared: f64) -> u32 {
        let mut sums = [0.0; WIDTH];
        for axis in 0..3 {
            let (lower, upper, x) = (&self.lower[axis], &self.upper[axis], center[axis]);
            for k in 0..WIDTH {
                let (below, above) = (lower[k] - x, x - upper[k]);
                let gap = if below > above { below } else { above };
                let gap = if gap > 0.0 { gap } else { 0.0 };
                sums[k] += gap * gap;
            }
        }
        at_most(&sums, &[squared; WIDTH])
    }
}

/// Returns one bit per lane, set if `values` is at most `limits`.
#[inline(always)]
pub fn at_most(values: &[f64; WIDTH], limits: &[f64; WIDTH]) -> u32 {
    let mut bits = 0;
    for k in 0..WIDTH {
        bits |= u32::from(values[k] <= limits[k]) << k;
    }
    bits
}

fn corners_of(aabb: &Aabb) -> (Vec3, Vec3) {
    (aabb.center - aabb.half, aabb.center + aabb.half)
}

fn hull(corners: &[(Vec3, Vec3)]) -> (Vec3, Vec3) {
    corners.iter().fold(crate::collision::shapes::bounds::EMPTY, |(lower, upper), (a, b)| (lower.inf(a), upper.sup(b)))
}

/// Orders boxes so that every run of [`WIDTH`], and every run of such runs, lies close together. It
/// halves them along the axis in which the centres spread most, and cuts at the end of a run.
pub fn arrange(boxes: &[Aabb], items: &mut [u32]) {
    if items.len() <= WIDTH {
        return;
    }
    let mut run = WIDTH;
    while run * WIDTH < items.len() {
        run *= WIDTH;
    }
    let center = |i: &u32| boxes[*i as usize].center;
    let (lower, upper) = items
        .iter()
        .map(center)
        .fold(crate::collision::shapes::bounds::EMPTY, |(lower, upper), c| (lower.inf(&c), upper.sup(&c)));
    let axis = (upper - lower).imax();
    let cut = items.len().div_ceil(2).next_multiple_of(run).min((items.len() - 1) / run * run);
    items.select_nth_unstable_by(cut, |a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b)));
    let (left, right) = items.split_at_mut(cut);
    arrange(boxes, left);
    arrange(boxes, right);
}

/// Slow twin of the tree: squared distance [m^2] of a point from a box.
#[cfg(test)]
pub fn distance_squared(aabb: &Aabb, point: &Vec3) -> f64 {
    ((point - aabb.center).abs() - aabb.half).sup(&Vec3::zeros()).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn what_a_ball_touches_is_what_a_scan_finds() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        for count in [0, 1, 7, 8, 9, 63, 64, 65, 200, 513, 1000] {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let boxes: Vec<Aabb> = (0..count).map(|_| Aabb { center: vector(4.0), half: vector(0.4).abs() }).collect();
            let tree = StillTree::new(&boxes);
            let (mut stack, mut found, mut hits) = (Vec::new(), Vec::new(), 0);
            for k in 0..200 {
                let (center, reach) = (vector(5.0), 0.002 * f64::from(k));
                found.clear();
                tree.touched(&center, reach, &mut stack, &mut found);
                found.sort_unstable();
                let near = |i: &u32| distance_squared(&boxes[*i as usize], &center) <= reach * reach;
                let scanned: Vec<u32> = (0..count as u32).filter(near).collect();
                assert_eq!(found, scanned);
                hits += found.len();
            }
            assert!(count < 7 || hits > 0);
        }
    }

    #[test]
    fn a_query_looks_at_few_blocks_of_many() {
        let boxes: Vec<Aabb> = (0..4096)
            .map(|k| {
                let center = Vec3::new((k % 16) as f64, (k / 16 % 16) as f64, (k / 256) as f64);
                Aabb { center, half: Vec3::repeat(0.2) }
            })
            .collect();
        let tree = StillTree::new(&boxes);
        assert_eq!(tree.levels.iter().map(Vec::len).collect::<Vec<_>>(), [512, 64, 8, 1]);
        // Each run of eight is a cube with two boxes a side.
        for block in &tree.levels[0] {
            for axis in 0..3 {
                let low = block.lower[axis].iter().fold(f64::INFINITY, |a, b| a.min(*b));
                let high = block.upper[axis].iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
                assert!(high - low < 1.5);
            }
        }
    }
}

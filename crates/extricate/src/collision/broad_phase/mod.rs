//! The broad phase: which checked pairs may be near at a configuration. It tests balls around
//! bodies that move, and balls and boxes around those that do not. A pair left out is proved apart.

pub mod static_tree;

use pulp::{Simd, WithSimd};

use crate::collision::prepared::Bodies;
use crate::math::Vec3;
use crate::scene::Scene;
use static_tree::{StillTree, WIDTH, at_most};

/// Marks an entry without a checked pair.
const NO_PAIR: u32 = u32::MAX;

/// The checked pairs of a scene, arranged so that one moving body is tested against eight bodies at
/// once.
pub struct Broad {
    movers: Vec<Mover>,
    /// Blocks of later movers with which each mover has checked pairs.
    rows: Vec<RowBlock>,
    still: StillTree,
    /// Centre and radius of the ball around each body in the tree.
    still_balls: Vec<(Vec3, f64)>,
    /// Index of the pair of every mover with every body in the tree.
    still_pairs: Vec<u32>,
    /// Pairs of two bodies that do not move; they are always found.
    fixed: Vec<u32>,
}

struct Mover {
    body: usize,
    radius: f64,
    rows: std::ops::Range<usize>,
    meets_still: bool,
}

/// Eight movers that one mover is tested against.
struct RowBlock {
    /// Index of the block of movers.
    block: usize,
    /// Sums of both radii \[m\]; minus infinity without a pair.
    radii: [f64; WIDTH],
    pairs: [u32; WIDTH],
}

#[derive(Debug, Default)]
pub struct BroadScratch {
    /// Indices of the pairs found.
    pub pairs: Vec<u32>,
    centers: Vec<[[f64; WIDTH]; 3]>,
    stack: Vec<(u32, u32)>,
    touched: Vec<u32>,
}

impl Broad {
    pub fn new(scene: &Scene, bodies: &Bodies) -> Self {
        let moves = |body: usize| scene.bodies[body].frame != 0;
        let mut fixed = Vec::new();
        let mut used = vec![false; bodies.bodies.len()];
        for (index, pair) in scene.pairs.iter().enumerate() {
            let [first, second] = [pair.first, pair.second];
            if bodies.bodies[first].parts.is_empty() || bodies.bodies[second].parts.is_empty() {
                continue;
            }
            (used[first], used[second]) = (true, true);
            if !moves(first) && !moves(second) {
                fixed.push(index as u32);
            }
        }
        let slots =
            |wanted: bool| -> Vec<usize> { (0..used.len()).filter(|&b| used[b] && moves(b) == wanted).collect() };
        let (mover_bodies, still_bodies) = (slots(true), slots(false));
        let mut slot = vec![usize::MAX; used.len()];
        mover_bodies
            .iter()
            .chain(&still_bodies)
            .zip((0..mover_bodies.len()).chain(0..))
            .for_each(|(b, k)| slot[*b] = k);

        let radius = |body: usize| bodies.bodies[body].ball.1;
        let mut between = vec![NO_PAIR; mover_bodies.len() * mover_bodies.len()];
        let mut still_pairs = vec![NO_PAIR; mover_bodies.len() * still_bodies.len()];
        for (index, pair) in scene.pairs.iter().enumerate() {
            let (first, second) = (pair.first, pair.second);
            if slot[first] == usize::MAX || slot[second] == usize::MAX {
                continue;
            }
            match (moves(first), moves(second)) {
                (true, true) => {
                    let (low, high) = (slot[first].min(slot[second]), slot[first].max(slot[second]));
                    between[low * mover_bodies.len() + high] = index as u32;
                }
                (true, false) => still_pairs[slot[first] * still_bodies.len() + slot[second]] = index as u32,
                (false, true) => still_pairs[slot[second] * still_bodies.len() + slot[first]] = index as u32,
                (false, false) => {}
            }
        }
        let mut rows = Vec::new();
        let mut movers = Vec::new();
        for (i, &body) in mover_bodies.iter().enumerate() {
            let start = rows.len();
            for (block, pairs) in between[i * mover_bodies.len()..][..mover_bodies.len()].chunks(WIDTH).enumerate() {
                if pairs.iter().all(|pair| *pair == NO_PAIR) {
                    continue;
                }
                let mut row = RowBlock { block, radii: [f64::NEG_INFINITY; WIDTH], pairs: [NO_PAIR; WIDTH] };
                for (k, &pair) in pairs.iter().enumerate().filter(|(_, pair)| **pair != NO_PAIR) {
                    row.pairs[k] = pair;
                    row.radii[k] = radius(body) + radius(mover_bodies[block * WIDTH + k]);
                }
                rows.push(row);
            }
            let mut against_still = still_pairs[i * still_bodies.len()..][..still_bodies.len()].iter();
            let meets_still = against_still.any(|pair| *pair != NO_PAIR);
            movers.push(Mover { body, radius: radius(body), rows: start..rows.len(), meets_still });
        }
        let boxes: Vec<_> = still_bodies.iter().filter_map(|&body| bodies.bodies[body].world_box).collect();
        let still_balls = still_bodies.iter().map(|&body| bodies.bodies[body].ball).collect();
        Self { movers, rows, still: StillTree::new(&boxes), still_balls, still_pairs, fixed }
    }

    /// Returns the moving bodies in the order in which [`Broad::find`] takes their centres.
    pub fn movers(&self) -> impl Iterator<Item = usize> {
        self.movers.iter().map(|mover| mover.body)
    }

    /// Finds all pairs whose signed distance may be below `margin` \[m\], each once, into
    /// `scratch.pairs`.
    ///
    /// `centers` are the centres of the balls around the moving bodies, in the world \[m\].
    pub fn find(&self, centers: impl Iterator<Item = Vec3>, margin: f64, scratch: &mut BroadScratch) {
        scratch.pairs.clear();
        scratch.pairs.extend(&self.fixed);
        scratch.centers.clear();
        scratch.centers.resize(self.movers.len().div_ceil(WIDTH), [[0.0; WIDTH]; 3]);
        for (k, center) in centers.enumerate() {
            for axis in 0..3 {
                scratch.centers[k / WIDTH][axis][k % WIDTH] = center[axis];
            }
        }
        pulp::Arch::new().dispatch(Scan { broad: self, margin, scratch });
    }

    #[inline(always)]
    fn scan(&self, margin: f64, scratch: &mut BroadScratch) {
        let BroadScratch { pairs, centers, stack, touched } = scratch;
        let stills = self.still_balls.len();
        for (i, mover) in self.movers.iter().enumerate() {
            let center = Vec3::from_fn(|axis, _| centers[i / WIDTH][axis][i % WIDTH]);
            for row in &self.rows[mover.rows.clone()] {
                let others = &centers[row.block];
                let (mut squared, mut limits) = ([0.0; WIDTH], [0.0; WIDTH]);
                for k in 0..WIDTH {
                    let (x, y, z) = (others[0][k] - center.x, others[1][k] - center.y, others[2][k] - center.z);
                    squared[k] = x * x + y * y + z * z;
                    let reach = row.radii[k] + margin;
                    limits[k] = if reach < 0.0 { -1.0 } else { reach * reach };
                }
                let mut hits = at_most(&squared, &limits);
                while hits != 0 {
                    pairs.push(row.pairs[hits.trailing_zeros() as usize]);
                    hits &= hits - 1;
                }
            }
            if !mover.meets_still {
                continue;
            }
            touched.clear();
            self.still.touched(&center, mover.radius + margin, stack, touched);
            for &still in &*touched {
                let (other, radius) = &self.still_balls[still as usize];
                let reach = mover.radius + radius + margin;
                let pair = self.still_pairs[i * stills + still as usize];
                if pair != NO_PAIR && (center - other).norm_squared() <= reach * reach {
                    pairs.push(pair);
                }
            }
        }
    }
}

/// A search with the widest vectors of the processor. It is a type because closures are not inlined
/// reliably.
struct Scan<'a> {
    broad: &'a Broad,
    margin: f64,
    scratch: &'a mut BroadScratch,
}

impl WithSimd for Scan<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.broad.scan(self.margin, self.scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::static_tree::distance_squared;
    use super::*;
    use crate::collision::Checker;
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;

    #[test]
    fn every_pair_that_balls_and_boxes_do_not_part_is_found_once() {
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let (scene, bodies) = (checker.scene(), &checker.bodies);
            let halton = Halton::new(scene.space.nv(), 4);
            let (mut placement, mut scratch) = (bodies.placement(), BroadScratch::default());
            let mut q = vec![0.0; scene.space.nq()];
            let (mut found, mut left_out) = (0, 0);
            for k in 0..200 {
                halton.config(&scene.space, k, &mut q);
                bodies.place(scene, &q, &mut placement);
                let margin = [0.0, scene.clearance, 0.1][k as usize % 3];
                let centers = checker.broad.movers().map(|body| placement.centers[body]);
                checker.broad.find(centers, margin, &mut scratch);
                scratch.pairs.sort_unstable();
                let near = |pair: &u32| {
                    let pair = scene.pairs[*pair as usize];
                    let [(a, r), (b, s)] =
                        [pair.first, pair.second].map(|body| (placement.centers[body], bodies.bodies[body].ball.1));
                    let still = |body: usize| scene.bodies[body].frame == 0;
                    let touches = |body: usize, center: &Vec3, radius: f64| {
                        !still(body)
                            || distance_squared(&bodies.bodies[body].world_box.unwrap(), center)
                                <= (radius + margin).powi(2)
                    };
                    still(pair.first) && still(pair.second)
                        || (a - b).norm() <= r + s + margin && touches(pair.first, &b, s) && touches(pair.second, &a, r)
                };
                let scanned: Vec<u32> = (0..scene.pairs.len() as u32).filter(near).collect();
                assert_eq!(scratch.pairs, scanned, "{name}");
                found += scanned.len();
                left_out += scene.pairs.len() - scanned.len();
            }
            assert!(found > 20 && left_out > 20, "{name}: {found} {left_out}");
        }
    }
}

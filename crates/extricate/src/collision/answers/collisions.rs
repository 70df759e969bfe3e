//! Collisions of pairs at a configuration, and the least signed distance of all pairs. [`Checker`]
//! documents these functions at its methods of the same names.

use crate::collision::checker::{CheckScratch, Checker};
use crate::collision::narrow_phase;
use crate::collision::narrow_phase::best_first::Entry;
use crate::collision::prepared::Placement;
use crate::scene::PairId;

/// Tags of queue entries: whether bounding balls or boxes gave the bound.
const BY_BALL: u32 = 0;
const BY_BOX: u32 = 1;

pub fn colliding_pairs(checker: &Checker, q: &[f64], scratch: &mut CheckScratch, pairs: &mut Vec<PairId>) {
    checker.place(q, scratch);
    checker.find_near(checker.most_clearance, scratch);
    scratch.broad.pairs.sort_unstable();
    let near = std::mem::take(&mut scratch.broad.pairs);
    let collide = near.iter().map(|&pair| pair as usize).filter(|&pair| checker.pair_collides(pair, scratch));
    pairs.extend(collide.map(PairId::new));
    scratch.broad.pairs = near;
}

pub fn collide(
    checker: &Checker,
    q: &[f64],
    pairs: impl Iterator<Item = PairId>,
    scratch: &mut CheckScratch,
) -> Vec<bool> {
    checker.place(q, scratch);
    pairs.map(|pair| checker.pair_collides(pair.index(), scratch)).collect()
}

pub fn colliding_pair(checker: &Checker, q: &[f64], scratch: &mut CheckScratch) -> Option<PairId> {
    checker.place(q, scratch);
    checker.find_near(checker.most_clearance, scratch);
    let CheckScratch { placement, broad, queue, .. } = scratch;
    queue.clear();
    queue.extend(broad.pairs.iter().map(|&index| gap_of_balls(checker, index, placement)));
    broad.pairs.clear();
    // Collisions that inner balls prove are found fastest. Surfaces that are near without meeting
    // take longest, so exact checks come last.
    while let Some(Entry { second, .. }) = scratch.queue.pop() {
        if checker.pair_seen_to_collide(second as usize, scratch) {
            return Some(PairId::new(second as usize));
        }
        scratch.broad.pairs.push(second);
    }
    let near = std::mem::take(&mut scratch.broad.pairs);
    let found = near.iter().map(|&pair| pair as usize).find(|&pair| checker.pair_collides(pair, scratch));
    scratch.broad.pairs = near;
    found.map(PairId::new)
}

fn gap_of_balls(checker: &Checker, index: u32, placement: &Placement) -> Entry {
    let (pair, centers) = (&checker.pairs[index as usize], &placement.centers);
    let bound = (centers[pair.first] - centers[pair.second]).norm() - pair.radii;
    Entry { bound, first: BY_BALL, second: index }
}

pub fn clearance(checker: &Checker, q: &[f64], scratch: &mut CheckScratch) -> f64 {
    checker.place(q, scratch);
    let CheckScratch { placement, queue, .. } = scratch;
    queue.clear();
    queue.extend((0..checker.pairs.len() as u32).map(|index| gap_of_balls(checker, index, placement)));
    let mut best = f64::INFINITY;
    while let Some(entry) = scratch.queue.pop().filter(|entry| entry.bound < best) {
        let pair = entry.second as usize;
        let mut bound = f64::INFINITY;
        for (first, second, _) in checker.part_pairs(pair) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            if entry.first == BY_BALL {
                bound = bound.min(narrow_phase::lower_bound(a, b));
            } else {
                best = narrow_phase::signed_distance(a, b, best, &mut scratch.buffers).unwrap_or(best);
            }
        }
        if entry.first == BY_BALL {
            scratch.queue.push(Entry { bound: bound.max(entry.bound), first: BY_BOX, ..entry });
        }
    }
    best
}

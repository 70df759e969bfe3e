//! A cache of computed kernel rows, bounded in memory: it evicts the least recently used row first.

use super::kernel::{LANES, PointSet, kernel_row};

/// Marks a missing point or slot.
const NONE: u32 = u32::MAX;

/// Rows `K(x_i, .)` of the kernel matrix of `points`.
pub struct RowCache {
    points: PointSet,
    gamma: f64,
    bytes: usize,
    slots: Vec<Slot>,
    /// The rows, slot after slot, so that memory that was touched once is used again.
    rows: Vec<[f32; LANES]>,
    /// Slot of each point's row, or [`NONE`].
    slot_of: Vec<u32>,
    /// Most and least recently used slot.
    newest: u32,
    oldest: u32,
    query: Vec<f32>,
    /// Number of rows computed so far.
    pub computed: u64,
}

struct Slot {
    point: u32,
    newer: u32,
    older: u32,
}

impl RowCache {
    /// Creates a cache of as many rows as fit into `bytes`, and at least two.
    pub fn new(points: PointSet, gamma: f64, bytes: usize) -> Self {
        Self {
            gamma,
            bytes,
            slots: Vec::new(),
            rows: Vec::new(),
            slot_of: vec![NONE; points.len()],
            newest: NONE,
            oldest: NONE,
            query: vec![0.0; points.dimensions()],
            computed: 0,
            points,
        }
    }

    /// Restricts the cache to the points at the positions `keep` (ascending). Rows of other points,
    /// and their entries in kept rows, are dropped.
    pub fn keep(&mut self, keep: &[u32]) {
        let before = self.width();
        self.points = self.points.gather(keep);
        let width = self.width();
        let mut position_of = vec![NONE; self.slot_of.len()];
        keep.iter().enumerate().for_each(|(position, old)| position_of[*old as usize] = position as u32);
        let mut moved = vec![NONE; self.slots.len()];
        let mut kept = 0;
        for (from, slot) in self.slots.iter_mut().enumerate() {
            slot.point = position_of[slot.point as usize];
            if slot.point == NONE {
                continue;
            }
            // Entries only move toward the front, so none is overwritten before it has been read.
            let entries = self.rows[kept * width..(from + 1) * before].as_flattened_mut();
            let row = (from * before - kept * width) * LANES;
            for (i, j) in keep.iter().enumerate() {
                entries[i] = entries[row + *j as usize];
            }
            moved[from] = kept as u32;
            kept += 1;
        }
        self.rows.truncate(kept * width);
        self.slot_of = vec![NONE; keep.len()];
        let mut slot = self.oldest;
        (self.newest, self.oldest) = (NONE, NONE);
        let old = std::mem::take(&mut self.slots);
        self.slots = old
            .iter()
            .filter(|slot| slot.point != NONE)
            .map(|slot| Slot { point: slot.point, newer: NONE, older: NONE })
            .collect();
        while slot != NONE {
            let to = moved[slot as usize];
            if to != NONE {
                self.slot_of[self.slots[to as usize].point as usize] = to;
                self.link_newest(to);
            }
            slot = old[slot as usize].newer;
        }
    }

    /// Memory that the rows take \[bytes\].
    pub fn bytes_held(&self) -> usize {
        self.slots.len() * row_bytes(&self.points)
    }

    fn width(&self) -> usize {
        self.points.block_count()
    }

    fn row_of(&self, slot: usize) -> &[[f32; LANES]] {
        &self.rows[slot * self.width()..][..self.width()]
    }

    /// Returns the row of point `i`, computed if it is not cached.
    pub fn row(&mut self, i: usize) -> &[[f32; LANES]] {
        let slot = self.fetch(i);
        self.row_of(slot)
    }

    /// Returns the rows of points `i` and `j`, computed if they are not cached.
    pub fn two_rows(&mut self, i: usize, j: usize) -> (&[[f32; LANES]], &[[f32; LANES]]) {
        self.fetch(i);
        let second = self.fetch(j);
        // Two rows always fit, so fetching `j` has not evicted `i`, which was the newest.
        let first = self.slot_of[i] as usize;
        (self.row_of(first), self.row_of(second))
    }

    fn fetch(&mut self, i: usize) -> usize {
        if self.slot_of[i] != NONE {
            let slot = self.slot_of[i];
            if self.newest != slot {
                self.unlink(slot);
                self.link_newest(slot);
            }
            return slot as usize;
        }
        let width = self.width();
        let slot = if self.slots.len() < capacity(&self.points, self.bytes) {
            self.slots.push(Slot { point: NONE, newer: NONE, older: NONE });
            self.rows.resize(self.slots.len() * width, [0.0; LANES]);
            self.slots.len() as u32 - 1
        } else {
            let slot = self.oldest;
            self.unlink(slot);
            self.slot_of[self.slots[slot as usize].point as usize] = NONE;
            slot
        };
        self.points.copy_point(i, &mut self.query);
        self.slots[slot as usize].point = i as u32;
        let row = &mut self.rows[slot as usize * width..][..width];
        kernel_row(&self.points, &self.query, self.gamma, row);
        self.computed += 1;
        self.slot_of[i] = slot;
        self.link_newest(slot);
        slot as usize
    }

    fn unlink(&mut self, slot: u32) {
        let (newer, older) = (self.slots[slot as usize].newer, self.slots[slot as usize].older);
        match newer {
            NONE => self.newest = older,
            _ => self.slots[newer as usize].older = older,
        }
        match older {
            NONE => self.oldest = newer,
            _ => self.slots[older as usize].newer = newer,
        }
    }

    fn link_newest(&mut self, slot: u32) {
        let older = self.newest;
        self.slots[slot as usize].newer = NONE;
        self.slots[slot as usize].older = older;
        match older {
            NONE => self.oldest = slot,
            _ => self.slots[older as usize].newer = slot,
        }
        self.newest = slot;
    }
}

/// Number of rows that fit into `bytes`, and at least two.
fn capacity(points: &PointSet, bytes: usize) -> usize {
    (bytes / row_bytes(points)).clamp(2, points.len().max(2))
}

fn row_bytes(points: &PointSet) -> usize {
    points.block_count().max(1) * size_of::<[f32; LANES]>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evicts_the_least_recently_used_and_stays_right() {
        let rows: Vec<f64> = (0..60).map(|i| (f64::from(i) * 0.37).sin()).collect();
        let points = PointSet::from_rows(&rows, 3);
        let bytes = 3 * points.block_count() * size_of::<[f32; LANES]>();
        let mut cache = RowCache::new(points.clone(), 0.5, bytes);
        let mut unbounded = RowCache::new(points.clone(), 0.5, usize::MAX);
        for step in 0..200usize {
            let (i, j) = (step * 7 % 20, step * 3 % 20);
            let (expected_i, expected_j) = (unbounded.row(i).to_vec(), unbounded.row(j).to_vec());
            let (a, b) = cache.two_rows(i, j);
            assert!(a == expected_i && b == expected_j);
        }
        assert_eq!(unbounded.computed, 20);
        for i in [1, 2, 3] {
            cache.row(i);
        }
        let before = cache.computed;
        cache.row(1);
        cache.row(4); // evicts 2
        cache.row(3);
        cache.row(1);
        assert_eq!(cache.computed, before + 1);
        cache.row(2);
        assert_eq!(cache.computed, before + 2);
    }

    #[test]
    fn rows_of_fewer_points_are_those_of_a_new_cache() {
        let rows: Vec<f64> = (0..150).map(|i| (f64::from(i) * 0.37).sin()).collect();
        let points = PointSet::from_rows(&rows, 3);
        let keep: Vec<u32> = (0..50).filter(|i| i % 3 != 1 && *i != 40).collect();
        let mut cache = RowCache::new(points.clone(), 0.5, 20 * row_bytes(&points));
        // Fills the cache; 40, a point that `keep` drops, lies between rows that stay.
        [0, 5, 9, 40, 12, 48, 3].into_iter().chain(20..33).chain([5, 48]).for_each(|i| _ = cache.row(i).len());
        let held: Vec<usize> = (0..50).filter(|i| cache.slot_of[*i] != NONE).collect();
        cache.keep(&keep);
        let mut fresh = RowCache::new(points.gather(&keep), 0.5, usize::MAX);
        let computed = cache.computed;
        for (position, point) in keep.iter().enumerate().filter(|(_, point)| held.contains(&(**point as usize))) {
            let (row, expected) = (cache.row(position).as_flattened(), fresh.row(position).as_flattened());
            assert_eq!(row[..keep.len()], expected[..keep.len()], "of point {point}");
        }
        assert_eq!(cache.computed, computed, "no row that was held is computed again");
        assert_eq!(cache.bytes_held(), cache.rows.len() * size_of::<[f32; LANES]>());
        let first_asked = keep.iter().position(|point| held.contains(&(*point as usize))).unwrap();
        assert_eq!(cache.slots[cache.oldest as usize].point as usize, first_asked, "the order of use is kept");
    }
}

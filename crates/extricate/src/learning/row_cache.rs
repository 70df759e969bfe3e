//! Kernel rows that were computed and may be needed again, within a bound on memory: the least recently used goes first.

use super::kernel::{LANES, PointSet, kernel_row};

/// No row, no slot.
const NONE: u32 = u32::MAX;

/// Rows `K(x_i, .)` of the kernel matrix of `points`.
pub struct RowCache {
    points: PointSet,
    gamma: f64,
    bytes: usize,
    capacity: usize,
    slots: Vec<Slot>,
    /// Slot of each point's row.
    slot_of: Vec<u32>,
    /// Most and least recently used slot.
    newest: u32,
    oldest: u32,
    query: Vec<f32>,
    /// Rows computed so far.
    pub computed: u64,
}

struct Slot {
    point: u32,
    newer: u32,
    older: u32,
    row: Vec<[f32; LANES]>,
}

impl RowCache {
    /// Holds as many rows as fit into `bytes`, and never fewer than two.
    pub fn new(points: PointSet, gamma: f64, bytes: usize) -> Self {
        Self {
            gamma,
            bytes,
            capacity: capacity(&points, bytes),
            slots: Vec::new(),
            slot_of: vec![NONE; points.len()],
            newest: NONE,
            oldest: NONE,
            query: vec![0.0; points.dimensions()],
            computed: 0,
            points,
        }
    }

    /// Goes over to the points at the positions `keep` (ascending) alone; the rows of others, and the other entries of
    /// kept rows, are dropped.
    pub fn keep(&mut self, keep: &[u32]) {
        self.points = self.points.gather(keep);
        self.capacity = capacity(&self.points, self.bytes);
        let mut position_of = vec![NONE; self.slot_of.len()];
        keep.iter().enumerate().for_each(|(position, old)| position_of[*old as usize] = position as u32);
        let mut slot = self.oldest;
        let mut order = Vec::with_capacity(self.slots.len());
        while slot != NONE {
            order.push(slot as usize);
            slot = self.slots[slot as usize].newer;
        }
        let mut old: Vec<Option<Slot>> = std::mem::take(&mut self.slots).into_iter().map(Some).collect();
        (self.newest, self.oldest) = (NONE, NONE);
        self.slot_of = vec![NONE; keep.len()];
        for slot in order {
            let Some(Slot { point, row, .. }) = old[slot].take() else { continue };
            let position = position_of[point as usize];
            if position == NONE {
                continue;
            }
            let mut kept = vec![[0.0; LANES]; self.points.block_count()];
            for (i, j) in keep.iter().enumerate() {
                kept[i / LANES][i % LANES] = row[*j as usize / LANES][*j as usize % LANES];
            }
            self.slots.push(Slot { point: position, newer: NONE, older: NONE, row: kept });
            self.slot_of[position as usize] = self.slots.len() as u32 - 1;
            self.link_newest(self.slots.len() as u32 - 1);
        }
    }

    /// Memory that the rows take \[bytes\].
    pub fn bytes_held(&self) -> usize {
        self.slots.len() * row_bytes(&self.points)
    }

    /// The row of point `i`.
    pub fn row(&mut self, i: usize) -> &[[f32; LANES]] {
        let slot = self.fetch(i);
        &self.slots[slot].row
    }

    /// The rows of points `i` and `j`.
    pub fn two_rows(&mut self, i: usize, j: usize) -> (&[[f32; LANES]], &[[f32; LANES]]) {
        self.fetch(i);
        let second = self.fetch(j);
        // Two rows always fit, so fetching `j` has not evicted `i`, which was the newest.
        let first = self.slot_of[i] as usize;
        (&self.slots[first].row, &self.slots[second].row)
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
        let slot = if self.slots.len() < self.capacity {
            let row = vec![[0.0; LANES]; self.points.block_count()];
            self.slots.push(Slot { point: NONE, newer: NONE, older: NONE, row });
            self.slots.len() as u32 - 1
        } else {
            let slot = self.oldest;
            self.unlink(slot);
            self.slot_of[self.slots[slot as usize].point as usize] = NONE;
            slot
        };
        self.points.copy_point(i, &mut self.query);
        let entry = &mut self.slots[slot as usize];
        entry.point = i as u32;
        kernel_row(&self.points, &self.query, self.gamma, &mut entry.row);
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

/// Rows that fit into `bytes`.
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
}

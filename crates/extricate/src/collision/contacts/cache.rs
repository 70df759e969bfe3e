//! Results of the last search for a contact, for each pair of convex shapes.
//!
//! Little changes between two steps of a descent. Callers whose results must not depend on earlier
//! queries forget them first. Labels do not use them.

use super::convex_convex::ContactMemory;

/// Memories of contacts by pair of shapes, and by pair of convex pieces.
#[derive(Debug, Default)]
pub struct ContactCache {
    pairs: Vec<(u32, ContactMemory)>,
    epoch: u32,
    /// Keys and memories of pairs of pieces, in the order in which they were first requested.
    pieces: Vec<([u32; 2], ContactMemory)>,
    /// Index into `pieces` by pair of shapes and pair of their pieces. It is valid only if the
    /// entry there has that key.
    places: Vec<Vec<u32>>,
}

impl ContactCache {
    /// Returns the memory of the pair of shapes number `parts`, empty if nothing is known.
    pub fn of(&mut self, parts: usize) -> &mut ContactMemory {
        if parts >= self.pairs.len() {
            self.pairs.resize(parts + 1, (self.epoch, ContactMemory::default()));
        }
        let (epoch, last) = &mut self.pairs[parts];
        if *epoch != self.epoch {
            (*epoch, *last) = (self.epoch, ContactMemory::default());
        }
        last
    }

    /// Returns the memory of the pair of pieces number `at` of `count`, of the pair of shapes
    /// number `parts`. It is made on request, because most of so many pairs are never requested.
    pub fn of_pieces(&mut self, parts: usize, count: usize, at: usize) -> &mut ContactMemory {
        if parts >= self.places.len() {
            self.places.resize(parts + 1, Vec::new());
        }
        let places = &mut self.places[parts];
        // `forget` keeps these indices, and in another scene the pair of that number may have more
        // pieces.
        if places.len() < count {
            places.resize(count, 0);
        }
        let key = [parts as u32, at as u32];
        let place = &mut places[at];
        if self.pieces.get(*place as usize).is_none_or(|(other, _)| *other != key) {
            *place = self.pieces.len() as u32;
            self.pieces.push((key, ContactMemory::default()));
        }
        &mut self.pieces[*place as usize].1
    }

    pub fn forget(&mut self) {
        self.pieces.clear();
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.pairs.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgets() {
        let mut memories = ContactCache::default();
        for epoch in [0, u32::MAX] {
            memories.epoch = epoch;
            memories.of(3).last = crate::collision::convex_distance::LastFeatures::of_point();
            assert_eq!((memories.of(3).last.count(), memories.of(0).last.count()), (1, 0));
            memories.forget();
            assert_eq!(memories.of(3).last.count(), 0);
        }
    }

    #[test]
    fn pieces_are_told_apart_and_forgotten() {
        let mut memories = ContactCache::default();
        let count =
            |memories: &mut ContactCache, [parts, at]: [usize; 2]| memories.of_pieces(parts, 6, at).last.count();
        let all: Vec<[usize; 2]> = [4, 0, 7].into_iter().flat_map(|parts| [5, 0, 2].map(|at| [parts, at])).collect();
        for turn in 0..3 {
            // Every other memory is filled, in another order each time: the first one requested
            // comes first.
            for (k, &[parts, at]) in all.iter().cycle().skip(turn).take(all.len()).enumerate() {
                assert_eq!(count(&mut memories, [parts, at]), 0, "{turn}: {parts} {at}");
                if k % 2 == 0 {
                    memories.of_pieces(parts, 6, at).last = crate::collision::convex_distance::LastFeatures::of_point();
                }
            }
            for (k, pair) in all.iter().cycle().skip(turn).take(all.len()).enumerate() {
                assert_eq!(count(&mut memories, *pair), usize::from(k % 2 == 0), "{turn}: {pair:?}");
            }
            memories.forget();
        }
    }

    #[test]
    fn a_pair_of_another_scene_may_have_more_pieces() {
        let mut memories = ContactCache::default();
        memories.of_pieces(1, 2, 1).last = crate::collision::convex_distance::LastFeatures::of_point();
        memories.forget();
        assert_eq!(memories.of_pieces(1, 6, 5).last.count(), 0);
        assert_eq!(memories.of_pieces(1, 6, 1).last.count(), 0);
    }
}

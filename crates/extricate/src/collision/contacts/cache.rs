//! What the last search for a contact found, for each pair of convex shapes.
//!
//! Between two steps of a descent little changes. Whoever needs results that do not depend on what
//! was asked before forgets it first. Labels do not use it.

use super::convex_convex::ContactMemory;

/// One for each pair of shapes.
#[derive(Debug, Default)]
pub struct ContactCache {
    pairs: Vec<(u32, ContactMemory)>,
    epoch: u32,
    /// Of pairs of pieces: which they are, in the order in which they were requested.
    pieces: Vec<([u32; 2], ContactMemory)>,
    /// Where they are: for each pair of shapes, for each pair of their pieces; right where the
    /// entry there says that it is that pair.
    places: Vec<Vec<u32>>,
}

impl ContactCache {
    /// That of the pair with number `parts`; none where nothing is known.
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

    /// That of pieces number `at` of `count` of the pair of shapes with number `parts`. Most of so
    /// many pairs are never asked for.
    pub fn of_pieces(&mut self, parts: usize, count: usize, at: usize) -> &mut ContactMemory {
        if parts >= self.places.len() {
            self.places.resize(parts + 1, Vec::new());
        }
        let places = &mut self.places[parts];
        // Forgetting leaves them as they are, and in another scene the pair of that number may have
        // more pieces.
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

    /// Forgets all of them.
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
            // Every other one, in another order each time: what is asked for first stands first.
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

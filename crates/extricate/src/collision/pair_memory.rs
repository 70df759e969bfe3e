//! What the last search for a contact found, for each pair of convex shapes.
//!
//! Between two steps of a descent little changes. Whoever needs results that do not depend on what was asked before forgets it
//! first. Labels do not use it.

use super::convex_contact::PairMemory;

/// One for each pair of shapes.
#[derive(Debug, Default)]
pub struct PairMemories {
    pairs: Vec<(u32, PairMemory)>,
    epoch: u32,
}

impl PairMemories {
    /// That of the pair with number `parts`; none where nothing is known.
    pub fn of(&mut self, parts: usize) -> &mut PairMemory {
        if parts >= self.pairs.len() {
            self.pairs.resize(parts + 1, (self.epoch, PairMemory::default()));
        }
        let (epoch, last) = &mut self.pairs[parts];
        if *epoch != self.epoch {
            (*epoch, *last) = (self.epoch, PairMemory::default());
        }
        last
    }

    /// Forgets all of them.
    pub fn forget(&mut self) {
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
        let mut memories = PairMemories::default();
        for epoch in [0, u32::MAX] {
            memories.epoch = epoch;
            memories.of(3).last = super::super::gjk::LastFeatures::of_point();
            assert_eq!((memories.of(3).last.count(), memories.of(0).last.count()), (1, 0));
            memories.forget();
            assert_eq!(memories.of(3).last.count(), 0);
        }
    }
}

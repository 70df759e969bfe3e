//! Entries of a priority queue that hands out the least lower bound first.

use std::cmp::Ordering;

/// Two indices, with a meaning that the owner of the queue chooses, and a lower bound \[m\]. The
/// entry with the least bound is the greatest; the indices break ties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    pub bound: f64,
    pub first: u32,
    pub second: u32,
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        let ties = (other.first, other.second).cmp(&(self.first, self.second));
        other.bound.total_cmp(&self.bound).then(ties)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

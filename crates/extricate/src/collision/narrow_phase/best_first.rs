//! Entries of a priority queue that hands out the least lower bound first.

use std::cmp::Ordering;

/// Two indices and a lower bound \[m\]; the least bound is the greatest entry, ties go by the
/// indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// \[m\]
    pub bound: f64,
    /// As the owner of the queue means it.
    pub first: u32,
    /// The same.
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

//! When a query has spent what it may.

use std::time::Instant;

use super::options::Stop;

/// Where a query ends before it is done.
#[derive(Debug, Clone, Default)]
pub struct Limit {
    /// Most exact checks and contact evaluations.
    pub checks: Option<usize>,
    /// When to end.
    pub deadline: Option<Instant>,
    /// Who may end it before.
    pub stop: Option<Stop>,
}

impl Limit {
    /// Whether it is reached after so many `checks`.
    pub fn is_reached(&self, checks: usize) -> bool {
        self.checks.is_some_and(|most| checks >= most)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || self.is_stopped()
    }

    /// Whether the caller ended the query.
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(Stop::is_asked)
    }
}

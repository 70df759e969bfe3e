//! When a query has spent what it may.

use std::time::{Duration, Instant};

use super::options::{QueryBudget, QueryOptions, Stop};

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
    /// That of a query which begins now.
    pub fn of(options: &QueryOptions) -> Self {
        // Seconds that no clock can hold are no limit; negative ones and NaN are none left.
        let until = |seconds: f64| match Duration::try_from_secs_f64(seconds.max(0.0)) {
            Ok(duration) => Instant::now().checked_add(duration),
            Err(_) => None,
        };
        let QueryBudget { checks, seconds } = options.budget;
        Self { checks, deadline: seconds.and_then(until), stop: options.stop.clone() }
    }

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

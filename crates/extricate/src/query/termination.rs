//! When a query ends before it is done.

use crate::interface::setters;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// When a query stops early, with the best answer so far.
///
/// # Guarantee
/// More of either never gives a larger depth: a query is a fixed sequence of steps, and a budget
/// ends it after some of them. (Time can end two runs of the same budget at different steps.) A
/// spent budget still leaves a free witness, verified but for [`crate::Effort::Nearest`], and its
/// proved bound. A query with a clearance of its own ([`crate::QueryOptions::clearance`]) may keep
/// more of it with a larger budget, and be deeper for that; the search for what keeps less has what
/// is left of the budget.
///
/// It is overdrawn by what it takes to find a first exit, since an answer is worth more than the
/// budget: a query with a budget has an answer whenever one without has, and no descent begins once
/// it is spent. Only a [`Stop`] ends that search, and leaves no answer.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Termination {
    /// Collision checks and distance evaluations. Overdrawn by what ends the query: at most three
    /// of them for the answer, one for each of several [`crate::query::Answer::exits`], one for the
    /// segment if that is requested, and the search for a first exit.
    pub max_checks: Option<usize>,
    /// Seconds from the start of the call; tested before each step. Overdrawn by the same.
    pub max_seconds: Option<f64>,
    /// Who may end the query before.
    pub stop: Option<Stop>,
}

setters! {
    Termination {
        max_checks: usize = Some,
        max_seconds: f64 = Some,
        stop: Stop = Some,
    }
}

impl Termination {
    /// After so many collision checks and distance evaluations.
    pub fn after_checks(checks: usize) -> Self {
        Self { max_checks: Some(checks), ..Self::default() }
    }

    /// After so many seconds.
    pub fn after_seconds(seconds: f64) -> Self {
        Self { max_seconds: Some(seconds), ..Self::default() }
    }
}

/// A question put before each step of a query, on its thread: `true` ends it, with what a spent
/// budget leaves. Two are equal where one is a clone of the other.
#[derive(Clone)]
pub struct Stop(Arc<dyn Fn() -> bool + Send + Sync>);

impl Stop {
    /// Ends queries where `ask` says so; steps take some tens of microseconds, so it should take
    /// far less.
    pub fn when(ask: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(ask))
    }

    /// Whether to end now.
    pub fn is_asked(&self) -> bool {
        (self.0)()
    }
}

impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Stop(..)")
    }
}

/// Where a query ends before it is done.
#[derive(Debug, Clone, Default)]
pub struct Deadline {
    /// Most exact checks and contact evaluations.
    pub checks: Option<usize>,
    /// When to end.
    pub deadline: Option<Instant>,
    /// Who may end it before.
    pub stop: Option<Stop>,
}

impl Deadline {
    /// That of a query which begins now.
    pub fn of(termination: &Termination) -> Self {
        // Seconds that no clock can hold are no limit; negative ones and NaN are none left.
        let until = |seconds: f64| match Duration::try_from_secs_f64(seconds.max(0.0)) {
            Ok(duration) => Instant::now().checked_add(duration),
            Err(_) => None,
        };
        let Termination { max_checks, max_seconds, stop } = termination;
        Self { checks: *max_checks, deadline: max_seconds.and_then(until), stop: stop.clone() }
    }

    /// What is left of it after so many `checks`, for a query that begins now.
    pub fn left(&self, checks: usize) -> Termination {
        let until = |deadline: Instant| deadline.saturating_duration_since(Instant::now()).as_secs_f64();
        Termination {
            max_checks: self.checks.map(|most| most.saturating_sub(checks)),
            max_seconds: self.deadline.map(until),
            stop: self.stop.clone(),
        }
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

//! Termination of a query before it is done: budgets and stops.

use crate::interface::setters;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// When a query stops early, with the best answer so far.
///
/// # Guarantee
/// More checks or seconds never give a larger depth: a query is a fixed sequence of steps, and a
/// budget ends it after some of them. (Time can end two runs of the same budget at different
/// steps.) A spent budget still leaves a free witness, verified but for [`crate::Effort::Nearest`],
/// and its proved bound. A query with a clearance of its own ([`crate::QueryOptions::clearance`])
/// is an exception. With a larger budget it may keep more of it, and be deeper for that; the search
/// with a smaller clearance gets the rest of the budget.
///
/// Finding a first exit may overdraw the budget, since an answer is worth more: a query with a
/// budget has an answer whenever one without has. No other descent begins once it is spent. Only a
/// [`Stop`] ends the search for a first exit, and then leaves no answer.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Termination {
    /// Most collision checks and distance evaluations. Overdrawn by the search for a first exit,
    /// and by the end of the query: at most three checks for the answer, one for each of several
    /// [`crate::query::Answer::exits`], one for the segment if requested.
    pub max_checks: Option<usize>,
    /// Most seconds from the start of the call, tested before each step; overdrawn like
    /// `max_checks`.
    pub max_seconds: Option<f64>,
    /// A condition by which the caller ends the query early.
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
    /// Ends queries after so many collision checks and distance evaluations.
    pub fn after_checks(checks: usize) -> Self {
        Self { max_checks: Some(checks), ..Self::default() }
    }

    /// Ends queries after so many seconds.
    pub fn after_seconds(seconds: f64) -> Self {
        Self { max_seconds: Some(seconds), ..Self::default() }
    }
}

/// A condition that is tested before each step of a query, on its thread: `true` ends it, with the
/// result that a spent budget leaves. Two are equal if one is a clone of the other.
#[derive(Clone)]
pub struct Stop(Arc<dyn Fn() -> bool + Send + Sync>);

impl Stop {
    /// Ends queries once `ask` returns `true`. Steps take some tens of microseconds, so it should
    /// take far less.
    pub fn when(ask: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(ask))
    }

    /// Returns whether to end the query now.
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

/// Limits of a running query.
#[derive(Debug, Clone, Default)]
pub struct Deadline {
    /// Most exact checks and contact evaluations.
    pub checks: Option<usize>,
    pub deadline: Option<Instant>,
    pub stop: Option<Stop>,
}

impl Deadline {
    /// Returns the limits of a query that begins now.
    pub fn of(termination: &Termination) -> Self {
        // Seconds that no clock can hold are no limit; negative ones and NaN leave no time.
        let until = |seconds: f64| match Duration::try_from_secs_f64(seconds.max(0.0)) {
            Ok(duration) => Instant::now().checked_add(duration),
            Err(_) => None,
        };
        let Termination { max_checks, max_seconds, stop } = termination;
        Self { checks: *max_checks, deadline: max_seconds.and_then(until), stop: stop.clone() }
    }

    /// Returns what is left after so many `checks`, for a query that begins now.
    pub fn left(&self, checks: usize) -> Termination {
        let until = |deadline: Instant| deadline.saturating_duration_since(Instant::now()).as_secs_f64();
        Termination {
            max_checks: self.checks.map(|most| most.saturating_sub(checks)),
            max_seconds: self.deadline.map(until),
            stop: self.stop.clone(),
        }
    }

    /// Returns whether a limit is reached after so many `checks`.
    pub fn is_reached(&self, checks: usize) -> bool {
        self.checks.is_some_and(|most| checks >= most)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || self.is_stopped()
    }

    /// Returns whether the caller ended the query.
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(Stop::is_asked)
    }
}

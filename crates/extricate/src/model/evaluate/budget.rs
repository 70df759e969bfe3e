//! How much is measured of a model, and what that may cost. Nothing is measured here.

use std::time::Instant;

use crate::query::StartsPerDof;

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub struct EvaluationBudget {
    /// Seed of what is held out.
    pub seed: u64,
    /// Most configurations that are labelled to find colliding ones.
    pub draws: usize,
    /// Most colliding configurations that are asked.
    pub queries: usize,
    /// Checks after which no further one is asked.
    pub checks: usize,
    /// When to stop; what is found then depends on the machine.
    pub until: Option<Instant>,
    /// Starts for each degree of freedom as far as they are known before.
    pub known: Option<StartsPerDof>,
}

/// Queries that are compared, where labels allow it.
const QUERIES: usize = 64;
/// So many labels of learning pay for one check of measuring, which costs some times as much: a
/// part of the time.
const LABELS_A_CHECK: usize = 4;
/// Labels below which nothing is asked: they would pay for a query or two, which say nothing.
const LEAST_LABELS: usize = 10_000;
/// So many labels pay for one configuration that is labelled to be held out.
const LABELS_A_DRAW: usize = 4;
/// Most of them.
const MOST_DRAWS: usize = 4096;
/// Turns the seed of learning into another.
const LOOKS: u64 = u64::from_be_bytes(*b"  looked");

impl EvaluationBudget {
    /// After learning with `labels`.
    pub fn after(labels: usize, seed: u64) -> Self {
        let draws = (labels / LABELS_A_DRAW).min(MOST_DRAWS);
        let queries = if labels < LEAST_LABELS { 0 } else { QUERIES };
        Self { seed, draws, queries, checks: labels / LABELS_A_CHECK, until: None, known: None }
    }

    /// All that is ever measured, however few the labels.
    pub fn in_full(seed: u64) -> Self {
        Self { seed, draws: MOST_DRAWS, queries: QUERIES, checks: usize::MAX, until: None, known: None }
    }

    /// What a run that may end by its quality looks at. Not what the model is measured on in the
    /// end: a run that ends when a figure is good makes that figure look better than it is.
    pub fn for_stopping(seed: u64) -> Self {
        Self::in_full(seed ^ LOOKS)
    }

    /// Whether its time is over.
    pub fn is_over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }
}

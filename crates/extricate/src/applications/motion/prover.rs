//! Labels and proofs of edges in one set of configurations, counted, until a budget is spent.

use crate::collision::{CheckScratch, Checker, SegmentBudget, SegmentOptions, SegmentOutcome, prove};
use crate::cspace::Label;
use crate::query::{Deadline, Termination};

/// What may be asked of a set: of the free configurations, or of those that a checker with other
/// clearances of its pairs ([`Checker::with_floors`]) calls so.
pub struct Prover<'a> {
    /// Whose set it is.
    pub checker: &'a Checker,
    scratch: CheckScratch,
    /// Of the proofs of edges \[m\].
    resolution: f64,
    /// Configurations that were evaluated.
    pub checks: usize,
    limit: Deadline,
}

impl<'a> Prover<'a> {
    /// Spends nothing yet.
    pub fn new(checker: &'a Checker, resolution: f64, limit: Deadline) -> Self {
        Self { checker, scratch: CheckScratch::default(), resolution, checks: 0, limit }
    }

    /// Whether no more is to be asked.
    pub fn is_spent(&self) -> bool {
        self.limit.is_reached(self.checks)
    }

    /// What of the budget is left, for a query that is part of the same work.
    pub fn left(&self) -> Termination {
        self.limit.left(self.checks)
    }

    /// Lets no more than so many further checks be spent, until [`Prover::unlimit`] has what is
    /// returned.
    pub fn limited(&mut self, checks: usize) -> Option<usize> {
        let before = self.limit.checks;
        let most = self.checks.saturating_add(checks);
        self.limit.checks = Some(before.map_or(most, |before| before.min(most)));
        before
    }

    /// See [`Prover::limited`].
    pub fn unlimit(&mut self, before: Option<usize>) {
        self.limit.checks = before;
    }

    /// Whether a configuration within its limits is in the set.
    pub fn holds(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        self.checker.scene().space.is_within(q) && self.checker.label(q, &mut self.scratch) == Label::Free
    }

    /// Whether the whole edge from `a`, which is in the set, is proved to be in it before the
    /// budget is spent.
    pub fn proves(&mut self, a: &[f64], b: &[f64]) -> bool {
        let (limit, spent) = (&self.limit, self.checks);
        let budget = SegmentBudget { is_spent: &|checks| limit.is_reached(spent + checks), ..SegmentBudget::UNLIMITED };
        let proved = prove(self.checker, (a, b), self.resolution, &budget, &mut self.scratch);
        self.checks += proved.checks;
        proved.is_free
    }

    /// The fraction of the edge from `a` up to which it is proved to be in the set before the
    /// budget is spent: 1 where all of it is.
    pub fn proved_until(&mut self, a: &[f64], b: &[f64]) -> f64 {
        let options = SegmentOptions { resolution: self.resolution };
        let (limit, spent) = (&self.limit, self.checks);
        let budget = SegmentBudget { is_spent: &|checks| limit.is_reached(spent + checks), ..SegmentBudget::UNLIMITED };
        let outcome = self.checker.segment_within((a, b), &options, &budget, &mut self.scratch);
        self.checks += self.scratch.segment_checks();
        match outcome {
            SegmentOutcome::Free => 1.0,
            SegmentOutcome::Contact { free_until, .. } | SegmentOutcome::Undecided { free_until, .. } => free_until,
        }
    }

    /// Memory of checks, for what else is asked of the same checker.
    pub fn scratch(&mut self) -> &mut CheckScratch {
        &mut self.scratch
    }
}

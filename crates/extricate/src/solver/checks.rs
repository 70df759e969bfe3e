//! Exact checks of configurations and of motions between them.

use super::Solver;
use crate::collision::{CheckScratch, SegmentOptions, SegmentOutcome};
use crate::cspace::Label;
use crate::scene::PairId;

impl Solver {
    /// Returns whether every checked pair keeps the clearance at `q`, a configuration of the scene
    /// within its limits.
    ///
    /// # Panics
    /// If `q` is not `nq` long.
    pub fn check(&self, q: &[f64]) -> bool {
        let checker = self.checker();
        self.memory().of_checks(|scratch| checker.label(q, scratch)) == Label::Free
    }

    /// Returns the checked pairs that do not keep the clearance at `q`, a configuration of the
    /// scene within its limits.
    ///
    /// # Panics
    /// If `q` is not `nq` long.
    pub fn colliding_pairs(&self, q: &[f64]) -> Vec<PairId> {
        let checker = self.checker();
        let mut pairs = Vec::new();
        self.memory().of_checks(|scratch| checker.colliding_pairs(q, scratch, &mut pairs));
        pairs
    }

    /// The least signed distance \[m\] of any checked pair at `q`, see [`Checker::clearance`].
    ///
    /// # Panics
    /// If `q` is not `nq` long.
    ///
    /// [`Checker::clearance`]: crate::Checker::clearance
    pub fn distance(&self, q: &[f64]) -> f64 {
        let checker = self.checker();
        self.memory().of_checks(|scratch| checker.clearance(q, scratch))
    }

    /// Returns the signed distances \[m\] of all checked pairs at `q`, in the order of the pairs.
    ///
    /// # Panics
    /// If `q` is not `nq` long.
    pub fn pair_distances(&self, q: &[f64]) -> Vec<f64> {
        let checker = self.checker();
        self.memory().of_checks(|scratch| checker.signed_distances(q, scratch))
    }

    /// Tries to prove that the geodesic between two configurations is free, see
    /// [`Checker::segment`].
    ///
    /// # Panics
    /// If `from` or `to` is not `nq` long.
    ///
    /// [`Checker::segment`]: crate::Checker::segment
    pub fn check_segment(&self, from: &[f64], to: &[f64], options: &SegmentOptions) -> SegmentOutcome {
        let checker = self.checker();
        self.memory().of_checks(|scratch| checker.segment(from, to, options, scratch))
    }

    /// Calls `work` with scratch memory of the checker, which later checks reuse and nobody else
    /// uses meanwhile.
    pub fn with_scratch<T>(&self, work: impl FnOnce(&mut CheckScratch) -> T) -> T {
        self.memory().of_checks(work)
    }
}

//! Finds out how much deeper pairs would have to get for an escape to exist.

use super::options::EscapeOptions;
use super::relaxed::Relaxed;
use super::search::Search;
use crate::applications::motion::prover::Prover;
use crate::collision::CheckScratch;
use crate::query::{Deadline, QueryScratch};

/// Tolerances that are tried if no path is found \[m\].
const TOLERANCES_M: [f64; 4] = [1e-3, 2e-3, 5e-3, 1e-2];
/// Checks of the trees for each of them.
const TREE_CHECKS: usize = 500;

impl Search<'_> {
    /// Returns the least of some larger tolerances \[m\] with which a path is found.
    pub fn needed_tolerance(&mut self) -> Option<f64> {
        TOLERANCES_M.into_iter().filter(|tolerance| *tolerance > self.options.tolerance).find(|tolerance| {
            let (tolerance, termination) = (*tolerance, self.left());
            let tree_checks = TREE_CHECKS.min(self.options.tree_checks);
            let options = EscapeOptions { tolerance, tree_checks, termination, ..self.options.clone() };
            let relaxed = Relaxed::at(self.context.checker, self.q, tolerance, &mut CheckScratch::default());
            let (context, q, limit) = (self.context, self.q, Deadline::of(&options.termination));
            let prover = Prover::new(&relaxed.checker, options.resolution, limit).holding(context.kept);
            let mut search = Search {
                context,
                q,
                options: &options,
                relaxed: &relaxed,
                prover,
                query: QueryScratch::default(),
                has_exit: false,
            };
            let is_found = !search.prover.is_spent() && search.find().is_some();
            self.prover.checks += search.prover.checks;
            is_found
        })
    }
}

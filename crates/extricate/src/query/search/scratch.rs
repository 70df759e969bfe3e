//! Memory that queries reuse, and what can be asked of the last one.

use super::Known;
use super::evaluate::Evaluator;
use super::parts::IndependentParts;
use crate::cspace::{ConfigSpace, Label};
use crate::query::answer::Answer;
use crate::query::context::Context;
use crate::query::descent::DescentScratch;
use crate::query::report::scratch::ReportScratch;
use crate::samples::BoundaryScratch;

/// Memory that queries reuse; one per thread.
#[derive(Default)]
pub struct QueryScratch {
    pub(crate) evaluator: Evaluator,
    pub(crate) descent: DescentScratch,
    pub(crate) boundary: BoundaryScratch,
    pub(crate) known: Known,
    pub(crate) parts: IndependentParts,
    pub(crate) report: ReportScratch,
}

impl QueryScratch {
    /// An exact check, counted.
    pub(crate) fn label(&mut self, context: &Context, q: &[f64]) -> Label {
        self.evaluator.label(context, q)
    }

    /// Checks of the last query so far.
    pub(crate) fn checks(&self) -> usize {
        self.evaluator.checks
    }

    /// Other exits with their depths, distinct from the answer and from each other, where descents
    /// of the last query ended besides: nearest first, not carried to the last digit and not
    /// checked. At most four where one was wanted.
    pub(crate) fn other_exits(&mut self, space: &ConfigSpace, answer: &Answer) -> Vec<(f64, Vec<f64>)> {
        let Known { exits, local, .. } = &mut self.known;
        let others = exits.besides(space, local, answer.depth, &answer.witness);
        others.map(|(depth, config)| (depth, config.to_vec())).collect()
    }
}

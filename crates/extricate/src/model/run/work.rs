//! What learning and adapting do not share: their stages, their units of work, and what they have
//! found. How a run goes from one to the next is not here.

use std::ops::ControlFlow;

use super::context::RunContext;
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::exploration::Exploration;
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::learning::{Budget, LearnProgress};
use crate::model::evaluate::EvaluationBudget;
use crate::model::evaluate::figures::ClassifierAccuracy;
use crate::model::solve::SolvePlace;
use crate::model::solve::policy::Solving;
use crate::model::statistics::{Adapted, EndedBy};
use crate::samples::SampleSet;
use crate::samples::trace::{TracePlace, Tracer};

/// Receives the state of a run after every batch of labels, and may stop it.
pub type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

/// What the next unit belongs to.
pub trait Stage: Clone {
    /// The last one; the run has ended for this reason.
    fn measuring(why: EndedBy) -> Self;

    fn kind(&self) -> StageKind<Self>;

    /// As progress reports name it.
    fn name(&self) -> &'static str;
}

/// A stage as the run sees it.
pub enum StageKind<S> {
    /// Without it there would be nothing to keep: it says nothing before its first labels.
    First,
    /// However few labels and seconds are left, it is done to its end; where memory is full, the
    /// run goes on at this one.
    Whole(S),
    /// It ends with labels, seconds or memory.
    Limited,
    /// As [`Self::Limited`]: exits of colliding configurations are looked for.
    Solving,
    /// What was found is measured; the run has ended for this reason.
    Measuring(EndedBy),
}

/// What learning and adapting do not share: the units before solving, and what the lists mean.
pub trait Work: Send + Sized {
    type Stage: Stage;

    /// That of the unit to come.
    fn stage(&self) -> &Self::Stage;

    /// Ends a unit here: `stage` is that of the next one.
    fn enter(&mut self, stage: Self::Stage, spent: Spent, nq: usize);

    /// Does a unit that neither solves nor measures; the stage of the next one.
    fn unit(&mut self, ground: &RunContext, tracer: &mut Option<Tracer>, budget: &mut Budget) -> Self::Stage;

    fn found(&self) -> Found<'_>;

    /// How it solves.
    fn solving(&self, ground: &RunContext) -> Solving;

    /// What is solved, samples that exits are appended to, and how far that has come.
    fn to_solve(&mut self) -> (&mut Exploration, &mut Vec<f64>, &mut SolvePlace);

    /// Whether the run is as good as its options ask for. False where the caller stopped it
    /// meanwhile, which `budget` then says.
    fn is_good_enough(&mut self, _: &RunContext, _: &mut Budget) -> bool {
        false
    }

    /// Where the tracer stands that memory is counted of.
    fn traced<'a>(&'a self, tracer: Option<&'a Tracer>) -> Option<&'a TracePlace>;

    /// What two exits know of their contacts \[bytes\], where `solver` has some.
    fn bytes_of_two_exits(&self, solver: Option<&SampleSet>) -> usize;

    /// Makes good before the index is made what the run had no time for; whether the caller
    /// stopped that.
    fn complete(&mut self, ground: &RunContext, spent: &mut Spent, report: &mut Report) -> bool;

    /// What to do where nothing free is known; `None` where nobody waited for it.
    fn advice(&self, ground: &RunContext, end: Option<EndedBy>) -> Option<String>;

    /// How much is measured after so many labels.
    fn extent(&self, ground: &RunContext, labels: usize) -> EvaluationBudget;

    fn conclude(self) -> Conclusion;
}

/// What has been found, row major.
pub struct Found<'a> {
    pub free: &'a [f64],
    /// Boundary samples, the last of which are exits.
    pub samples: &'a [f64],
    /// How many of them are.
    pub exits: usize,
    /// Exits that are not among the samples yet.
    pub apart: &'a [f64],
    /// Memory of all lists \[bytes\].
    pub bytes: usize,
    /// Of the classifier, for the reports.
    pub accuracy: Option<f64>,
}

/// What a model is made of beside its samples.
pub struct Conclusion {
    pub classifier: Option<ObstacleClassifier>,
    pub judged: ClassifierAccuracy,
    /// Checks that looks at how good the run is have taken.
    pub quality_checks: usize,
    pub adapted: Option<Adapted>,
}

/// What left a run nothing that another pass could be paid with: the time may have run out within
/// the last one.
pub fn spent(budget: &Budget) -> EndedBy {
    if budget.end() == Some(BudgetEnd::Seconds) { EndedBy::Seconds } else { EndedBy::Labels }
}

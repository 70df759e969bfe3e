//! A run in units of work: learning and adapting differ only in what their units do.

mod ending;
mod ground;
mod memory;

use std::sync::Arc;

use super::EndedBy;
use super::learner::Report;
use super::quality::Judged;
use super::solve::SolvePlace;
use super::solving::Solving;
use crate::boundary::SampleSet;
use crate::boundary::trace::{TracePlace, Tracer};
use crate::learning::Budget;
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::explore::Exploration;
use crate::learning::union::UnionClassifier;
use crate::model::Adapted;
use crate::model::measure::Extent;
use ending::Ready;
pub use ground::{RunGround, labels};
pub use memory::bytes;

/// A run between two units of work.
pub struct Run<W> {
    pub ground: RunGround,
    /// What is its own, and what it has found.
    pub work: W,
    pool: Arc<rayon::ThreadPool>,
    /// Made when needed: it holds indices over what was found.
    tracer: Option<Tracer>,
    /// The samples that solving starts from, made when needed.
    solver: Option<SampleSet>,
    /// What was spent, the unit that was stopped included.
    spent: Spent,
    end: Option<EndedBy>,
    /// After the last unit.
    ready: Option<Ready>,
}

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
    /// As [`Self::Limited`]: ways out of colliding configurations are looked for.
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
    fn unit(&mut self, ground: &RunGround, tracer: &mut Option<Tracer>, budget: &mut Budget) -> Self::Stage;

    fn found(&self) -> Found<'_>;

    /// How it solves.
    fn solving(&self, ground: &RunGround) -> Solving;

    /// What is solved, samples that exits are appended to, and how far that has come.
    fn to_solve(&mut self) -> (&mut Exploration, &mut Vec<f64>, &mut SolvePlace);

    /// Whether the run is as good as its options ask for. False where the caller stopped it
    /// meanwhile, which `budget` then says.
    fn is_good_enough(&mut self, _: &RunGround, _: &mut Budget) -> bool {
        false
    }

    /// Where the tracer stands that memory is counted of.
    fn traced<'a>(&'a self, tracer: Option<&'a Tracer>) -> Option<&'a TracePlace>;

    /// What two exits know of their contacts \[bytes\], where `solver` has some.
    fn bytes_of_two_exits(&self, solver: Option<&SampleSet>) -> usize;

    /// Makes good before the index is made what the run had no time for; whether the caller
    /// stopped that.
    fn complete(&mut self, ground: &RunGround, spent: &mut Spent, report: &mut Report) -> bool;

    /// What to do where nothing free is known; `None` where nobody waited for it.
    fn advice(&self, ground: &RunGround, end: Option<EndedBy>) -> Option<String>;

    /// How much is measured after so many labels.
    fn extent(&self, ground: &RunGround, labels: usize) -> Extent;

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
    pub classifier: Option<UnionClassifier>,
    pub judged: Judged,
    /// Checks that looks at how good the run is have taken.
    pub looks: usize,
    pub adapted: Option<Adapted>,
}

impl<W: Work> Run<W> {
    /// A run that has spent as much on what `work` holds.
    pub fn new(pool: rayon::ThreadPool, ground: RunGround, work: W, spent: Spent) -> Self {
        let (tracer, solver, end, ready) = (None, None, None, None);
        Self { ground, work, pool: pool.into(), tracer, solver, spent, end, ready }
    }

    /// Does one unit of work; whether there is more to do.
    pub fn step(&mut self, report: &mut Report) -> bool {
        if self.end.is_none() {
            let pool = self.pool.clone();
            pool.install(|| self.unit(report));
            if self.end.is_none() && bytes(self) > self.ground.options.memory {
                let next = match self.work.stage().kind() {
                    StageKind::Whole(next) => next,
                    StageKind::Measuring(_) => return true,
                    _ => Stage::measuring(EndedBy::Memory),
                };
                self.work.enter(next, self.spent.clone(), self.ground.nq());
            }
        }
        self.end.is_none()
    }

    fn unit(&mut self, report: &mut Report) {
        let stage = self.work.stage().clone();
        let kind = stage.kind();
        if let StageKind::Measuring(why) = kind {
            return self.measure(why, report);
        }
        let mut budget = Budget::resumed(&self.ground.options, &self.spent, report);
        let found = self.work.found();
        budget.note(found.samples.len() / self.ground.nq(), found.accuracy);
        if !matches!(kind, StageKind::First) || budget.left() == 0 {
            budget.stage(stage.name());
        }
        let is_whole = matches!(kind, StageKind::Whole(_));
        let next = match kind {
            StageKind::Solving => self.solve(&mut budget).map_or(stage, Stage::measuring),
            _ => self.work.unit(&self.ground, &mut self.tracer, &mut budget),
        };
        self.spent = budget.spent_so_far();
        let next = match (budget.end(), next.kind()) {
            (Some(BudgetEnd::Interrupted), _) => {
                self.end = Some(EndedBy::Interruption);
                return;
            }
            // What has ended for another reason did so before it ran out.
            (Some(_), kind) if !is_whole && !matches!(kind, StageKind::Measuring(_)) => {
                Stage::measuring(spent(&budget))
            }
            _ => next,
        };
        self.work.enter(next, self.spent.clone(), self.ground.nq());
    }

    /// A pass of solving; why it was the last one.
    fn solve(&mut self, budget: &mut Budget) -> Option<EndedBy> {
        // What tracing held is not needed any more.
        self.tracer = None;
        let Self { ground, work, solver, .. } = self;
        let to_solve = ground.to_solve(work.solving(ground));
        let (known, samples, place) = work.to_solve();
        let paid = to_solve.pass(known, samples, place, solver, &|configs| ground.label(configs), budget);
        if !paid {
            return Some(spent(budget));
        }
        (budget.end().is_none() && work.is_good_enough(ground, budget)).then_some(EndedBy::Quality)
    }
}

/// What left a run nothing that another pass could be paid with: the time may have run out within
/// the last one.
pub fn spent(budget: &Budget) -> EndedBy {
    if budget.end() == Some(BudgetEnd::Seconds) { EndedBy::Seconds } else { EndedBy::Labels }
}

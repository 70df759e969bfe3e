//! A learning run that can be stopped between two units of work, kept, and gone on with.

mod advice;

use std::sync::Arc;

use rayon::prelude::*;

use super::evaluate::calibrate::unmeasured;
use super::evaluate::figures::ClassifierAccuracy;
use super::evaluate::{EvaluationBudget, is_within};
use super::learned::Model;
use super::run::ending::finish;
use super::run::state::{QualityChecks, RunState, Stage};
use super::run::work::{Conclusion, Found, Report, Work, spent};
use super::run::{self, Run, RunContext};
use super::solve::SolvePlace;
use super::solve::near_miss::NearMisses;
use super::solve::policy::{Solving, TRACED_BY};
use super::solve::recombine::recombine;
use super::statistics::EndedBy;
use crate::collision::{CheckScratch, Checker};
use crate::error::Result;
use crate::learning::active_learning::{classify, surprising_first};
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::exploration::{BATCH, Exploration};
use crate::learning::obstacle_classifier::Parts;
use crate::learning::{Budget, LearnOptions};
use crate::metric::MetricScratch;
use crate::metric::relative::{self, RelativePoses};
use crate::samples::SampleSet;
use crate::samples::trace::{TracePlace, Tracer};
use crate::scene::Scene;

/// Share of the budget, labels or seconds, spent on exploration before the boundary is traced.
const EXPLORATION_SHARE: f64 = 0.2;
/// With fewer free configurations among those that were explored, and more colliding ones for each,
/// others are put together limb by limb.
const FEW_FREE: usize = 64;
const SELDOM_FREE: usize = 50;
/// Labels that exploration spends at most; tracing draws what it needs beyond them.
const MOST_EXPLORATION: usize = 200_000;
/// Part of the memory, one in so many, that exploration fills at most: the boundary needs the rest.
const EXPLORATION_PART: usize = 3;
/// Seeds looked at for surprises for every second of the limit: a share of the time that is small
/// on any robot.
const SURPRISES_A_SECOND: f64 = 1000.0;
/// A run that may end by its quality is looked at whenever its boundary samples have grown by this
/// factor: what all looks cost is then a few times the last one, and no run goes on for much longer
/// than it has to.
const BETWEEN_LOOKS: f64 = 1.4;

/// A run between two units of work: a batch of exploration, the training, a pass of tracing, and at
/// last measuring what was learned.
///
/// ```
/// use std::ops::ControlFlow;
/// use extricate::{LearnOptions, Learner, builtin};
/// let options = LearnOptions { labels: 2000, seconds: None, ..LearnOptions::default() };
/// let mut learner = Learner::new(builtin::scene("planar-arm")?, &options)?;
/// while learner.step(&mut |_| ControlFlow::Continue(())) {} // between two steps it can be stored
/// assert!(learner.finish(&mut |_| ControlFlow::Continue(()))?.statistics().labels <= 2000);
/// # extricate::Result::Ok(())
/// ```
///
/// # Guarantee
/// Without a limit in seconds the model depends on scene, labels and seed alone: not on the number
/// of threads, nor on where the run was stopped and resumed.
pub struct Learner(Run<Learning>);

/// What of a run is learning.
struct Learning {
    /// What the kernels see, whatever the metric: on joint angles they learn far less.
    relative: RelativePoses,
    state: RunState,
}

impl Learner {
    /// A run from nothing. Nothing is labelled yet.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for an option that makes no sense.
    pub fn new(scene: Scene, options: &LearnOptions) -> Result<Self> {
        Self::resume(scene, options, RunState::default())
    }

    /// A run that has come as far as `state`, which has to be one of this scene and these options.
    pub(crate) fn resume(scene: Scene, options: &LearnOptions, state: RunState) -> Result<Self> {
        let (pool, scene) = (options.pool()?, Arc::new(scene));
        let (relative, spent) = (RelativePoses::new(scene.clone()), state.mark.spent.clone());
        let ground = RunContext::new(scene, options, options.seed);
        Ok(Self(Run::new(pool, ground, Learning { relative, state }, spent)))
    }

    /// Does one unit of work, a second or so; whether there is more to do. `report` is called after
    /// every batch of labels. Where it stops the run, what the unit found by then is kept for
    /// [`Learner::finish`] but is no part of a checkpoint.
    pub fn step(&mut self, report: &mut Report) -> bool {
        self.0.step(report)
    }

    /// The model of what has been found so far; measured where the run was not stopped before.
    /// Where nothing of the boundary was traced yet, one small pass is made for it.
    ///
    /// # Errors
    /// [`Error::NothingFree`](crate::Error::NothingFree) where no free configuration was found;
    /// [`Error::Interrupted`](crate::Error::Interrupted) where the caller stopped before one was.
    pub fn finish(self, report: &mut Report) -> Result<Model> {
        finish(self.0, report)
    }

    /// Memory that the run holds, counted \[bytes\]: lists, indices over them, what exits know of
    /// their contacts, and on top of these what is larger, the index that [`Learner::finish`] will
    /// make or a checkpoint. Kernel rows of training are bounded besides. Not counted: scene and
    /// checker, what a thread works with, and what a unit of work holds only while it lasts.
    pub fn bytes(&self) -> usize {
        run::bytes(&self.0)
    }

    /// The scene that is learned.
    pub fn scene(&self) -> &Scene {
        self.0.ground.scene()
    }

    /// What the run may spend, and its seed.
    pub fn options(&self) -> &LearnOptions {
        &self.0.ground.options
    }

    /// What has been found, and where the last whole unit of work ended.
    pub fn state(&self) -> &RunState {
        &self.0.work.state
    }
}

impl Work for Learning {
    type Stage = Stage;

    fn stage(&self) -> &Stage {
        &self.state.mark.stage
    }

    fn enter(&mut self, stage: Stage, spent: Spent, _: usize) {
        self.state.set_mark(stage, spent);
    }

    fn unit(&mut self, ground: &RunContext, tracer: &mut Option<Tracer>, budget: &mut Budget) -> Stage {
        match self.state.mark.stage.clone() {
            Stage::Exploring => self.explore(ground, budget),
            Stage::Training => self.train(ground, budget),
            Stage::Tracing(place) => self.trace(ground, place, tracer, budget),
            stage @ (Stage::Solving | Stage::Measuring(_)) => stage,
        }
    }

    fn found(&self) -> Found<'_> {
        let RunState { known, samples, solved, classified, .. } = &self.state;
        let (bytes, accuracy) = (known.bytes() + size_of_val(&samples[..]), classified.balanced_accuracy());
        Found { free: &known.free, samples, exits: solved.exits, apart: &[], bytes, accuracy }
    }

    fn solving(&self, ground: &RunContext) -> Solving {
        Solving::of(ground.options.labels, ground.metric.kind()).unwrap_or(Solving::Thorough)
    }

    fn to_solve(&mut self) -> (&mut Exploration, &mut Vec<f64>, &mut SolvePlace) {
        let RunState { known, samples, solved, .. } = &mut self.state;
        (known, samples, solved)
    }

    fn is_good_enough(&mut self, ground: &RunContext, budget: &mut Budget) -> bool {
        let (state, options) = (&self.state, &ground.options);
        let agrees = options.target_disagreement.is_none_or(|target| state.classified.is_within(target));
        let Some(target) = options.target_excess else { return options.target_disagreement.is_some() && agrees };
        let rows = state.samples.len() / ground.nq();
        if !agrees || rows == 0 || (rows as f64) < BETWEEN_LOOKS * state.checks_of_quality.samples as f64 {
            return false;
        }
        budget.stage("measuring");
        let boundary = ground.index(state.samples.clone(), state.solved.exits);
        let extent = EvaluationBudget { until: budget.until(), ..EvaluationBudget::for_stopping(options.seed) };
        let mut go_on = || {
            budget.stage("measuring");
            budget.end() != Some(BudgetEnd::Interrupted)
        };
        let to_query = ground.to_query(&boundary, unmeasured());
        let Some((within, checks)) = is_within(&to_query, target, &extent, &mut go_on) else { return false };
        self.state.checks_of_quality =
            QualityChecks { samples: rows, checks: self.state.checks_of_quality.checks + checks };
        within
    }

    fn traced<'a>(&'a self, tracer: Option<&'a Tracer>) -> Option<&'a TracePlace> {
        tracer.map(Tracer::place)
    }

    fn bytes_of_two_exits(&self, solver: Option<&SampleSet>) -> usize {
        solver.map_or(0, |set| 2 * set.bytes_of_planes() / set.solved().max(1))
    }

    /// Makes a small pass where none was made.
    fn complete(&mut self, ground: &RunContext, spent: &mut Spent, report: &mut Report) -> bool {
        let RunState { known, samples, .. } = &mut self.state;
        if !samples.is_empty() {
            return false;
        }
        let label = |configs: &[f64]| ground.label(configs);
        let to_trace = ground.to_trace(&label, true);
        let mut budget = Budget::resumed(&ground.options, spent, report);
        if budget.left() > 0 {
            let mut tracer = Tracer::new(&to_trace, known);
            tracer.pass(&to_trace, known, samples, &ground.halton, usize::MAX, &mut budget);
        }
        *spent = budget.spent_so_far();
        budget.end() == Some(BudgetEnd::Interrupted)
    }

    fn advice(&self, ground: &RunContext, end: Option<EndedBy>) -> Option<String> {
        let colliding = &self.state.known.colliding;
        (end != Some(EndedBy::Interruption)).then(|| advice::advice(&ground.checker, colliding))
    }

    fn extent(&self, ground: &RunContext, labels: usize) -> EvaluationBudget {
        let LearnOptions { target_excess, seed, .. } = ground.options;
        target_excess.map_or_else(|| EvaluationBudget::after(labels, seed), |_| EvaluationBudget::in_full(seed))
    }

    fn conclude(self) -> Conclusion {
        let RunState { classified, colliding_share, checks_of_quality, .. } = self.state;
        let accuracy = [classified.accuracy_free, classified.accuracy_colliding];
        let judged = ClassifierAccuracy { accuracy, held_out: classified.held_out, colliding_share };
        Conclusion {
            classifier: classified.classifier,
            judged,
            quality_checks: checks_of_quality.checks,
            adapted: None,
        }
    }
}

impl Learning {
    fn explore(&mut self, ground: &RunContext, budget: &mut Budget) -> Stage {
        let (RunContext { options, halton, .. }, space) = (ground, &ground.scene().space);
        let RunState { known, colliding_share, .. } = &mut self.state;
        let label = |configs: &[f64]| ground.label(configs);
        let first = ((options.labels as f64 * EXPLORATION_SHARE) as usize).clamp(1, MOST_EXPLORATION);
        let enough = |budget: &Budget, known: &Exploration| {
            budget.spent() >= first || budget.fraction() >= EXPLORATION_SHARE || is_full(ground, known)
        };
        let to_come = first.saturating_sub(budget.spent());
        let batch = if enough(budget, known) { BATCH } else { to_come.min(BATCH) };
        known.extend(space, halton, batch, &label, budget);
        let [colliding, free] = [&known.colliding, &known.free].map(Vec::len);
        *colliding_share = colliding as f64 / (colliding + free).max(1) as f64;
        if !enough(budget, known) {
            return Stage::Exploring;
        }
        let [free, colliding] = [&known.free, &known.colliding].map(|list| list.len() / space.nq());
        if free < FEW_FREE && colliding > SELDOM_FREE * free.max(1) {
            recombine(&ground.checker, known, FEW_FREE, &label, budget);
        }
        if known.free.is_empty() { Stage::Exploring } else { Stage::Training }
    }

    fn train(&mut self, ground: &RunContext, budget: &mut Budget) -> Stage {
        let (RunContext { checker, metric, options, .. }, nq) = (ground, ground.nq());
        let Self { relative, state } = self;
        let label = |configs: &[f64]| ground.label(configs);
        let features = |configs: &[f64], pairs: &[u32]| relative_poses(relative, nq, configs, pairs);
        let containing = |configs: &[f64]| colliding_parts(checker, relative, configs);
        let parts = Parts {
            count: checker.scene().pairs.len(),
            nq,
            containing: &containing,
            features: &features,
            width: relative::WIDTH,
        };
        let known = &mut state.known;
        state.classified = classify(&checker.scene().space, &parts, known, options, budget);
        let seeds = NearMisses::new(checker, metric).seeds(known, &label, budget);
        if let Some(classifier) = &state.classified.classifier
            && budget.end() != Some(BudgetEnd::Interrupted)
        {
            let by_time = budget.seconds().map_or(usize::MAX, |limit| (limit * SURPRISES_A_SECOND) as usize);
            let count = by_time.min(budget.left() / 8);
            surprising_first(classifier, &features, nq, count, &mut known.colliding);
        }
        if budget.end() != Some(BudgetEnd::Interrupted) {
            known.colliding.splice(..0, seeds);
        }
        Stage::Tracing(Tracer::first_place(known, nq))
    }

    fn trace(
        &mut self,
        ground: &RunContext,
        place: TracePlace,
        tracer: &mut Option<Tracer>,
        budget: &mut Budget,
    ) -> Stage {
        let options = &ground.options;
        let RunState { known, samples, .. } = &mut self.state;
        let label = |configs: &[f64]| ground.label(configs);
        let to_trace = ground.to_trace(&label, true);
        let tracer = tracer.get_or_insert_with(|| Tracer::at(&to_trace, known, samples, place.clone()));
        let solving = Solving::of(options.labels, ground.metric.kind());
        let solves = |samples: &[f64]| solving.is_some() && !samples.is_empty();
        // Solving starts from samples: without any, the first pass takes what it needs; or, where
        // exploring and training left nothing of the share, as much of what is left.
        let share = |labels: usize| (TRACED_BY * labels as f64) as usize;
        let most = match place.passes {
            0 if solving == Some(Solving::Sparing) => share(budget.left()),
            _ if solves(samples) => share(options.labels).saturating_sub(budget.spent()),
            _ => usize::MAX,
        };
        let paid = budget.end().is_some() || tracer.pass(&to_trace, known, samples, &ground.halton, most, budget);
        let solves = solves(samples);
        if budget.end().is_none() && self.is_good_enough(ground, budget) {
            Stage::Measuring(EndedBy::Quality)
        } else if solves && (!paid || budget.fraction() >= TRACED_BY) {
            Stage::Solving
        } else if !paid {
            Stage::Measuring(spent(budget))
        } else {
            Stage::Tracing(tracer.place().clone())
        }
    }
}

/// Whether what was explored, as the first pass of tracing will hold it, fills its part of the
/// memory.
fn is_full(ground: &RunContext, known: &Exploration) -> bool {
    let nq = ground.nq();
    let starts = Tracer::first_place(known, nq).starts;
    known.bytes() + SampleSet::bytes(&ground.metric, nq, starts, 0) > ground.options.memory / EXPLORATION_PART
}

/// The numbers of the relative poses of `pairs` at many configurations (row major), a configuration
/// after the other.
pub(super) fn relative_poses(poses: &RelativePoses, nq: usize, configs: &[f64], pairs: &[u32]) -> Vec<f64> {
    let mut out = Vec::with_capacity(configs.len() / nq * pairs.len() * relative::WIDTH);
    let mut scratch = MetricScratch::default();
    configs.chunks_exact(nq).for_each(|q| poses.embed(q, pairs, &mut scratch, &mut out));
    out
}

/// The parts that each of many configurations (row major) lies in, ascending.
fn colliding_parts(checker: &Checker, relative: &RelativePoses, configs: &[f64]) -> Vec<Vec<u32>> {
    let of = |scratch: &mut CheckScratch, q: &[f64]| {
        let mut pairs = Vec::new();
        checker.colliding_pairs(q, scratch, &mut pairs);
        let mut inside: Vec<u32> = pairs.into_iter().map(|pair| relative.part(pair).first).collect();
        inside.sort_unstable();
        inside.dedup();
        inside
    };
    configs.par_chunks_exact(checker.scene().space.nq()).map_init(CheckScratch::default, of).collect()
}

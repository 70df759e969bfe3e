//! A learning run that can be stopped between two units of work, kept, and gone on with.

mod ending;
mod memory;

use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::EndedBy;
use super::calibrate::unmeasured;
use super::measure::{Extent, is_within};
use super::near_miss::NearMisses;
use super::run_state::{Looks, RunState, Stage};
use super::solve::SolveGround;
use super::solving::Solving;
use crate::boundary::SampleSet;
use crate::boundary::trace::{TraceGround, Tracer};
use crate::collision::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::Result;
use crate::learning::active::{classify, surprising_first};
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::union::Parts;
use crate::learning::{Budget, LearnOptions, LearnProgress};
use crate::metric::relative::{self, RelativePoses};
use crate::metric::{Metric, MetricScratch};
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::coverage::Coverage;
use crate::penetration::{Context, Learned, index_samples};
use crate::scene::Scene;
use ending::Ready;
use memory::is_full;

/// Share of the budget, labels or seconds, spent on exploration before the boundary is traced.
const EXPLORATION_SHARE: f64 = 0.2;
/// Labels that exploration spends at most; tracing draws what it needs beyond them.
const MOST_EXPLORATION: usize = 200_000;
/// Seeds looked at for surprises for every second of the limit: a share of the time that is small on any robot.
const SURPRISES_A_SECOND: f64 = 1000.0;
/// Boundary samples have a colliding configuration within this share of the space's diameter.
pub(super) const GAP_SHARE: f64 = 1.0 / 2000.0;
/// Share of the budget after which the boundary is not traced further, and colliding configurations are solved.
pub(super) const TRACED_BY: f64 = 0.3;
/// Boundary samples below which free configurations stand in for those that are missing: a query wants sixteen starts that are not alike.
const STAND_INS: usize = 128;
/// A run that may end by its quality is looked at whenever its boundary samples have grown by this factor: what all looks cost is
/// then a few times the last one, and no run goes on for much longer than it has to.
const BETWEEN_LOOKS: f64 = 1.4;

/// Receives the state of a run after every batch of labels, and may stop it.
pub type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

/// A run between two units of work: a batch of exploration, the training, a pass of tracing, and at last measuring what was learned.
///
/// ```
/// use std::ops::ControlFlow;
/// use extricate::{LearnOptions, Learner, scene::builtin};
/// let options = LearnOptions { labels: 2000, seconds: None, ..LearnOptions::default() };
/// let mut learner = Learner::new(builtin::scene("planar-arm")?, &options)?;
/// while learner.step(&mut |_| ControlFlow::Continue(())) {} // between two steps it can be stored
/// assert!(learner.finish(&mut |_| ControlFlow::Continue(()))?.statistics().labels <= 2000);
/// # extricate::Result::Ok(())
/// ```
///
/// # Guarantee
/// Without a limit in seconds the model depends on scene, labels and seed alone: not on the number of threads, nor on where the
/// run was stopped and resumed.
pub struct Learner {
    ground: LearnGround,
    pool: Arc<rayon::ThreadPool>,
    options: LearnOptions,
    state: RunState,
    /// Made when needed: it holds indices over what `state` holds.
    tracer: Option<Tracer>,
    /// The samples that solving starts from, made when needed.
    solver: Option<SampleSet>,
    /// What was spent, the unit that was stopped included.
    spent: Spent,
    end: Option<EndedBy>,
    /// After the last unit.
    ready: Option<Ready>,
}

/// What does not change while learning.
struct LearnGround {
    checker: Checker,
    metric: Metric,
    /// What the kernels see, whatever the metric: on joint angles they learn far less.
    relative: RelativePoses,
    halton: Halton,
    /// Metric units.
    gap: f64,
    balls: OnceLock<InteriorBalls>,
    /// Of nothing: held-out queries need none.
    no_coverage: Coverage,
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
        let pool = options.pool()?;
        let scene = Arc::new(scene);
        let metric = Metric::new(scene.clone());
        let ground = LearnGround {
            relative: RelativePoses::new(scene.clone()),
            halton: Halton::new(scene.space.nv(), options.seed),
            gap: GAP_SHARE * metric.diameter(),
            checker: Checker::new(scene),
            metric,
            balls: OnceLock::new(),
            no_coverage: Coverage::default(),
        };
        let spent = state.mark.spent.clone();
        Ok(Self {
            ground,
            pool: pool.into(),
            options: options.clone(),
            state,
            tracer: None,
            solver: None,
            spent,
            end: None,
            ready: None,
        })
    }

    /// Does one unit of work, a second or so; whether there is more to do. `report` is called after every batch of labels. Where
    /// it stops the run, what the unit found by then is kept for [`Learner::finish`] but is no part of a checkpoint.
    pub fn step(&mut self, report: &mut Report) -> bool {
        if self.end.is_none() {
            let pool = self.pool.clone();
            pool.install(|| self.unit(report));
            let learns = self.end.is_none() && !matches!(self.state.mark.stage, Stage::Measuring(_));
            if learns && self.bytes() > self.options.memory {
                self.state.mark.stage = Stage::Measuring(EndedBy::Memory);
            }
        }
        self.end.is_none()
    }

    fn unit(&mut self, report: &mut Report) {
        if let Stage::Measuring(why) = self.state.mark.stage {
            return self.measure(why, report);
        }
        let Self { ground, options, state, tracer, solver, .. } = self;
        let (scene, nq) = (ground.checker.scene(), ground.checker.scene().space.nq());
        let label = |configs: &[f64]| ground.label(configs);
        let mut budget = Budget::resumed(options, &self.spent, report);
        budget.note(state.samples.len() / nq, state.classified.balanced_accuracy());
        // Without a first batch there would be nothing to keep, however little time or patience there is.
        if state.mark.stage != Stage::Exploring || budget.left() == 0 {
            budget.stage(state.mark.stage.name());
        }
        let mut next = match state.mark.stage.clone() {
            Stage::Exploring => {
                let first = ((options.labels as f64 * EXPLORATION_SHARE) as usize).clamp(1, MOST_EXPLORATION);
                let enough = |budget: &Budget, known: &Exploration| {
                    let full = is_full(&ground.metric, known, nq, options);
                    budget.spent() >= first || budget.fraction() >= EXPLORATION_SHARE || full
                };
                let to_come = first.saturating_sub(budget.spent());
                let batch = if enough(&budget, &state.known) { BATCH } else { to_come.min(BATCH) };
                state.known.extend(&scene.space, &ground.halton, batch, &label, &mut budget);
                state.colliding_share = share(state.known.colliding.len(), state.known.free.len());
                if enough(&budget, &state.known) && !state.known.free.is_empty() {
                    Stage::Training
                } else {
                    Stage::Exploring
                }
            }
            Stage::Training => {
                let features = |configs: &[f64], pairs: &[u32]| relative_poses(&ground.relative, nq, configs, pairs);
                let containing = |configs: &[f64]| colliding_pairs(&ground.checker, configs);
                let parts = Parts {
                    count: scene.pairs.len(),
                    nq,
                    containing: &containing,
                    features: &features,
                    width: relative::WIDTH,
                };
                let known = &mut state.known;
                state.classified = classify(&scene.space, &parts, known, options, &mut budget);
                let seeds = NearMisses::new(&ground.checker, &ground.metric).seeds(known, &label, &mut budget);
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
            Stage::Tracing(place) => {
                let trace_ground = ground.trace_ground(&label, options);
                let tracer = tracer
                    .get_or_insert_with(|| Tracer::at(&trace_ground, &state.known, &state.samples, place.clone()));
                let (known, samples) = (&mut state.known, &mut state.samples);
                let solving = Solving::of(options.labels, ground.metric.kind());
                let solves = |samples: &[f64]| solving.is_some() && !samples.is_empty();
                // Solving starts from samples: without any, the first pass takes what it needs; or, where exploring and training left nothing of the
                // share, as much of what is left.
                let share = |labels: usize| (TRACED_BY * labels as f64) as usize;
                let most = match place.passes {
                    0 if solving == Some(Solving::Sparing) => share(budget.left()),
                    _ if solves(samples) => share(options.labels).saturating_sub(budget.spent()),
                    _ => usize::MAX,
                };
                let paid = budget.end().is_some()
                    || tracer.pass(&trace_ground, known, samples, &ground.halton, most, &mut budget);
                if budget.end().is_none() && look(ground, options, state, &mut budget) {
                    Stage::Measuring(EndedBy::Quality)
                } else if solves(&state.samples) && (!paid || budget.fraction() >= TRACED_BY) {
                    Stage::Solving
                } else if !paid {
                    Stage::Measuring(spent(&budget))
                } else {
                    Stage::Tracing(tracer.place().clone())
                }
            }
            Stage::Solving => {
                // What tracing held is not needed any more.
                *tracer = None;
                let RunState { known, samples, solved, .. } = state;
                let paid = ground.to_solve(options).pass(known, samples, solved, solver, &label, &mut budget);
                if budget.end().is_none() && paid && look(ground, options, state, &mut budget) {
                    Stage::Measuring(EndedBy::Quality)
                } else if paid {
                    Stage::Solving
                } else {
                    Stage::Measuring(spent(&budget))
                }
            }
            Stage::Measuring(why) => Stage::Measuring(why),
        };
        self.spent = budget.spent_so_far();
        match budget.end() {
            Some(BudgetEnd::Interrupted) => {
                self.end = Some(EndedBy::Interruption);
                return;
            }
            // What ended by its quality did so before it ran out.
            Some(_) if matches!(next, Stage::Measuring(_)) => {}
            Some(BudgetEnd::Labels) => next = Stage::Measuring(EndedBy::Labels),
            Some(BudgetEnd::Seconds) => next = Stage::Measuring(EndedBy::Seconds),
            None => {}
        }
        self.state.set_mark(next, self.spent.clone());
    }

    /// The scene that is learned.
    pub fn scene(&self) -> &Scene {
        self.ground.checker.scene()
    }

    /// What the run may spend, and its seed.
    pub fn options(&self) -> &LearnOptions {
        &self.options
    }

    /// What has been found, and where the last whole unit of work ended.
    pub fn state(&self) -> &RunState {
        &self.state
    }
}

/// What left a run nothing that another pass could be paid with: the time may have run out within the last one.
fn spent(budget: &Budget) -> EndedBy {
    if budget.end() == Some(BudgetEnd::Seconds) { EndedBy::Seconds } else { EndedBy::Labels }
}

/// Whether the run is as good as its options ask for. False where the caller stopped the run meanwhile, which `budget` then says.
fn look(ground: &LearnGround, options: &LearnOptions, state: &mut RunState, budget: &mut Budget) -> bool {
    let agrees = options.target_disagreement.is_none_or(|target| state.classified.is_within(target));
    let Some(target) = options.target_excess else { return options.target_disagreement.is_some() && agrees };
    let nq = ground.checker.scene().space.nq();
    let rows = state.samples.len() / nq;
    if !agrees || rows == 0 || (rows as f64) < BETWEEN_LOOKS * state.looks.samples as f64 {
        return false;
    }
    budget.stage("measuring");
    let boundary =
        index_samples(&ground.checker, &ground.metric, state.samples.clone(), state.solved.exits, options.seed);
    let extent = Extent { until: budget.until(), ..Extent::for_stopping(options.seed) };
    let mut go_on = || {
        budget.stage("measuring");
        budget.end() != Some(BudgetEnd::Interrupted)
    };
    let Some((within, checks)) = is_within(&ground.to_query(&boundary), target, &extent, &mut go_on) else {
        return false;
    };
    state.looks = Looks { samples: rows, checks: state.looks.checks + checks };
    within
}

impl LearnGround {
    /// What queries stand on, with the samples so far.
    fn to_query<'a>(&'a self, boundary: &'a SampleSet) -> Context<'a> {
        let balls = self.balls.get_or_init(|| InteriorBalls::new(&self.checker));
        let learned = Learned { boundary, coverage: &self.no_coverage, starts: unmeasured() };
        Context::new((&self.checker, &self.metric, balls), learned, None)
    }

    fn to_solve(&self, options: &LearnOptions) -> SolveGround<'_> {
        SolveGround {
            checker: &self.checker,
            metric: &self.metric,
            balls: self.balls.get_or_init(|| InteriorBalls::new(&self.checker)),
            no_coverage: &self.no_coverage,
            halton: &self.halton,
            gap: self.gap,
            seed: options.seed,
            solving: Solving::of(options.labels, self.metric.kind()).unwrap_or(Solving::Thorough),
        }
    }

    fn label(&self, configs: &[f64]) -> Vec<Label> {
        let mut labels = vec![Label::Free; configs.len() / self.checker.scene().space.nq()];
        self.checker.label_batch(configs, &mut labels);
        labels
    }

    fn trace_ground<'a>(
        &'a self,
        label: &'a crate::learning::LabelBatch<'a>,
        options: &LearnOptions,
    ) -> TraceGround<'a> {
        let space = &self.checker.scene().space;
        TraceGround { space, metric: &self.metric, label, gap: self.gap, seed: options.seed, draws_seeds: true }
    }
}

/// The first of the `free` configurations (row major) that stand in where there are few `samples`.
pub(super) fn stand_ins<'a>(free: &'a [f64], samples: &[f64], nq: usize) -> &'a [f64] {
    let missing = STAND_INS.saturating_sub(samples.len() / nq) * nq;
    &free[..free.len().min(missing)]
}

/// The numbers of the relative poses of `pairs` at many configurations (row major), a configuration after the other.
pub(super) fn relative_poses(poses: &RelativePoses, nq: usize, configs: &[f64], pairs: &[u32]) -> Vec<f64> {
    let mut out = Vec::with_capacity(configs.len() / nq * pairs.len() * relative::WIDTH);
    let mut scratch = MetricScratch::default();
    configs.chunks_exact(nq).for_each(|q| poses.embed(q, pairs, &mut scratch, &mut out));
    out
}

/// The pairs that collide at each of many configurations (row major).
fn colliding_pairs(checker: &Checker, configs: &[f64]) -> Vec<Vec<u32>> {
    let of = |scratch: &mut CheckScratch, q: &[f64]| {
        let mut pairs = Vec::new();
        checker.colliding_pairs(q, scratch, &mut pairs);
        pairs.into_iter().map(|pair| pair as u32).collect()
    };
    configs.par_chunks_exact(checker.scene().space.nq()).map_init(CheckScratch::default, of).collect()
}

/// `part / (part + rest)`; 0 of nothing.
fn share(part: usize, rest: usize) -> f64 {
    part as f64 / (part + rest).max(1) as f64
}

//! A learning run that can be stopped between two units of work, kept, and gone on with.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::run_state::{RunState, Stage};
use super::{EndedBy, Model, Statistics};
use crate::boundary::SampleSet;
use crate::boundary::trace::{TraceGround, Tracer};
use crate::collision::{Checker, always_colliding};
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::{Error, Result};
use crate::learning::active::{classify, surprising_first};
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::classifier::Classifier;
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::{Budget, LearnOptions, LearnProgress};
use crate::metric::{Metric, MetricScratch};
use crate::scene::{MetricSpec, Scene};

/// Share of the budget, labels or seconds, spent on exploration before the boundary is traced.
const EXPLORATION_SHARE: f64 = 0.2;
/// Labels that exploration spends at most; tracing draws what it needs beyond them.
const MOST_EXPLORATION: usize = 200_000;
/// Configurations below which "collides every time" says nothing.
const FEW: usize = 100;
/// Seeds looked at for surprises for every second of the limit: a share of the time that is small on any robot.
const SURPRISES_A_SECOND: f64 = 1000.0;
/// Boundary samples have a colliding configuration within this share of the space's diameter.
const GAP_SHARE: f64 = 1.0 / 2000.0;
/// Free configurations that stand in for boundary samples where there are none.
const STAND_INS: usize = 1024;

/// Receives the state of a run after every batch of labels, and may stop it.
pub type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

/// A run between two units of work: a batch of exploration, the training, a pass of tracing.
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
    /// What was spent, the unit that was stopped included.
    spent: Spent,
    end: Option<EndedBy>,
}

/// What does not change while learning.
struct LearnGround {
    checker: Checker,
    metric: Metric,
    /// What the kernel sees: the bodies' displacement, whatever the metric; on joint angles it learns far less.
    feature_metric: Metric,
    halton: Halton,
    /// Metric units.
    gap: f64,
}

impl Learner {
    /// A run from nothing. Nothing is labelled yet.
    ///
    /// # Errors
    /// [`Error::Option`] for an option that makes no sense.
    pub fn new(scene: Scene, options: &LearnOptions) -> Result<Self> {
        Self::resume(scene, options, RunState::default())
    }

    /// A run that has come as far as `state`, which has to be one of this scene and these options.
    pub(crate) fn resume(scene: Scene, options: &LearnOptions, state: RunState) -> Result<Self> {
        if options.labels == 0 {
            return Err(Error::Option { name: "labels", value: "0".into(), expected: "at least 1" });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build().map_err(|e| Error::Option {
            name: "threads",
            value: format!("{} ({e})", options.threads),
            expected: "a number of threads that the system can start",
        })?;
        let scene = Arc::new(scene);
        let metric = Metric::new(scene.clone());
        let ground = LearnGround {
            feature_metric: Metric::of_kind(scene.clone(), MetricSpec::ObjectNorm),
            halton: Halton::new(scene.space.nv(), options.seed),
            gap: GAP_SHARE * metric.diameter(),
            checker: Checker::new(scene),
            metric,
        };
        let spent = state.mark.spent.clone();
        Ok(Self { ground, pool: pool.into(), options: options.clone(), state, tracer: None, spent, end: None })
    }

    /// Does one unit of work, a second or so; whether there is more to do. `report` is called after every batch of labels. Where
    /// it stops the run, what the unit found by then is kept for [`Learner::finish`] but is no part of a checkpoint.
    pub fn step(&mut self, report: &mut Report) -> bool {
        if let Stage::Done(why) = self.state.mark.stage {
            self.end = Some(why);
        }
        if self.end.is_none() {
            let pool = self.pool.clone();
            pool.install(|| self.unit(report));
            if self.end.is_none() && self.bytes() > self.options.memory {
                self.end = Some(EndedBy::Memory);
                self.state.mark.stage = Stage::Done(EndedBy::Memory);
            }
        }
        self.end.is_none()
    }

    fn unit(&mut self, report: &mut Report) {
        let Self { ground, options, state, tracer, .. } = self;
        let (scene, nq) = (ground.checker.scene(), ground.checker.scene().space.nq());
        let label = |configs: &[f64]| ground.label(configs);
        let mut budget = Budget::resumed(options, &self.spent, report);
        budget.note(state.samples.len() / nq, state.classified.balanced_accuracy());
        // Without a first batch there would be nothing to keep, however little time or patience there is.
        if state.mark.stage != Stage::Exploring || budget.left() == 0 {
            budget.stage(state.mark.stage.name());
        }
        let next = match state.mark.stage.clone() {
            Stage::Exploring => {
                let first = ((options.labels as f64 * EXPLORATION_SHARE) as usize).clamp(1, MOST_EXPLORATION);
                let enough = |budget: &Budget| budget.spent() >= first || budget.fraction() >= EXPLORATION_SHARE;
                let to_come = first.saturating_sub(budget.spent());
                let batch = if enough(&budget) { BATCH } else { to_come.min(BATCH) };
                state.known.extend(&scene.space, &ground.halton, batch, &label, &mut budget);
                state.colliding_share = share(state.known.colliding.len(), state.known.free.len());
                if enough(&budget) && !state.known.free.is_empty() { Stage::Training } else { Stage::Exploring }
            }
            Stage::Training => {
                let features = |q: &[f64]| ground.features(q);
                let known = &mut state.known;
                state.classified = classify(&scene.space, &features, known, &label, options.seed, &mut budget);
                if let Some(classifier) = &state.classified.classifier
                    && budget.end() != Some(BudgetEnd::Interrupted)
                {
                    let by_time = budget.seconds().map_or(usize::MAX, |limit| (limit * SURPRISES_A_SECOND) as usize);
                    let count = by_time.min(budget.left() / 8);
                    surprising_first(classifier, &features, nq, count, &mut known.colliding);
                }
                Stage::Tracing(Tracer::first_place(known, nq))
            }
            Stage::Tracing(place) => {
                let trace_ground = ground.trace_ground(&label, options);
                let tracer = tracer
                    .get_or_insert_with(|| Tracer::at(&trace_ground, &state.known, &state.samples, place.clone()));
                let (known, samples) = (&mut state.known, &mut state.samples);
                let paid =
                    budget.end().is_some() || tracer.pass(&trace_ground, known, samples, &ground.halton, &mut budget);
                if paid { Stage::Tracing(tracer.place().clone()) } else { Stage::Done(EndedBy::Labels) }
            }
            Stage::Done(why) => Stage::Done(why),
        };
        self.spent = budget.spent_so_far();
        self.end = budget.end().map(|end| match end {
            BudgetEnd::Labels => EndedBy::Labels,
            BudgetEnd::Seconds => EndedBy::Seconds,
            BudgetEnd::Interrupted => EndedBy::Interruption,
        });
        if self.end != Some(EndedBy::Interruption) {
            self.state.set_mark(next, self.spent.clone());
        }
    }

    /// The model of what has been found so far. Where nothing of the boundary was traced yet, one small pass is made for it.
    ///
    /// # Errors
    /// [`Error::NothingFree`] where no free configuration was found; [`Error::Interrupted`] where the caller stopped before one
    /// was.
    pub fn finish(mut self, report: &mut Report) -> Result<Model> {
        let pool = self.pool.clone();
        pool.install(|| {
            if self.state.known.free.is_empty() {
                return Err(self.nothing_free());
            }
            if self.state.samples.is_empty() {
                self.trace_a_little(report);
            }
            Ok(self.into_model(report))
        })
    }

    fn trace_a_little(&mut self, report: &mut Report) {
        let Self { ground, options, state, .. } = self;
        let label = |configs: &[f64]| ground.label(configs);
        let trace_ground = ground.trace_ground(&label, options);
        let mut budget = Budget::resumed(options, &self.spent, report);
        if budget.left() > 0 {
            let mut tracer = Tracer::new(&trace_ground, &state.known);
            tracer.pass(&trace_ground, &mut state.known, &mut state.samples, &ground.halton, &mut budget);
        }
        self.spent = budget.spent_so_far();
    }

    fn into_model(self, report: &mut Report) -> Model {
        let Self { ground, options, state, spent, end, tracer, .. } = self;
        drop(tracer);
        let RunState { known, mut samples, classified, colliding_share, .. } = state;
        let nq = ground.checker.scene().space.nq();
        let traced = !samples.is_empty();
        if !traced {
            // Nothing collided, or nothing was traced in time: free configurations are answers too, only far ones.
            samples.extend_from_slice(&known.free[..known.free.len().min(STAND_INS * nq)]);
        }
        let statistics = Statistics {
            labels: spent.labels,
            seed: options.seed,
            boundary_samples: samples.len() / nq,
            support_vectors: classified.classifier.as_ref().map_or(0, Classifier::support_vectors),
            colliding_share,
            accuracy_free: classified.accuracy_free,
            accuracy_colliding: classified.accuracy_colliding,
            boundary_gap: traced.then_some(ground.gap),
            // A run that its owner stops stepping was interrupted too.
            ended_by: end.unwrap_or(EndedBy::Interruption),
        };
        let mut budget = Budget::resumed(&options, &spent, report);
        budget.note(samples.len() / nq, classified.balanced_accuracy());
        budget.stage("indexing");
        Model::from_parts(ground.checker, ground.metric, samples, classified.classifier, statistics)
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

    /// Memory that the run holds, counted \[bytes\]: lists, indices over them, and the index that [`Learner::finish`] will make.
    /// Training takes its kernel cache besides.
    pub fn bytes(&self) -> usize {
        let RunState { known, samples, .. } = &self.state;
        let nq = self.scene().space.nq();
        let indexed = |rows: usize| SampleSet::bytes(&self.ground.metric, nq, rows);
        let starts = self.tracer.as_ref().map_or(0, |t| indexed(t.place().starts) + indexed(t.place().indexed));
        8 * (known.free.len() + known.colliding.len() + samples.len()) + starts + indexed(samples.len() / nq)
    }

    fn nothing_free(&self) -> Error {
        if self.end == Some(EndedBy::Interruption) {
            return Error::Interrupted;
        }
        let (checker, known): (&Checker, &Exploration) = (&self.ground.checker, &self.state.known);
        let scene = checker.scene();
        let tried: Vec<Vec<f64>> =
            known.colliding.chunks_exact(scene.space.nq()).take(1000).map(<[f64]>::to_vec).collect();
        let named = |pair: usize| format!("[\"{}\", \"{}\"]", scene.pair_names(pair)[0], scene.pair_names(pair)[1]);
        let always: Vec<String> = always_colliding(checker, &tried).into_iter().map(named).collect();
        let advice = if tried.len() < FEW {
            "too few to tell why; spend more labels or seconds".into()
        } else if always.is_empty() {
            "no single pair is to blame; widen the limits, lower the clearance or spend more labels".into()
        } else {
            format!(
                "these pairs collide every time; if by design, add to the scene: [pairs] disable = [{}]",
                always.join(", ")
            )
        };
        Error::NothingFree { labels: self.spent.labels, advice }
    }
}

impl LearnGround {
    fn label(&self, configs: &[f64]) -> Vec<Label> {
        let mut labels = vec![Label::Free; configs.len() / self.checker.scene().space.nq()];
        self.checker.label_batch(configs, &mut labels);
        labels
    }

    fn features(&self, q: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.feature_metric.embedding_len()];
        self.feature_metric.embed(q, &mut MetricScratch::default(), &mut out);
        out
    }

    fn trace_ground<'a>(
        &'a self,
        label: &'a crate::learning::LabelBatch<'a>,
        options: &LearnOptions,
    ) -> TraceGround<'a> {
        let space = &self.checker.scene().space;
        TraceGround { space, metric: &self.metric, label, gap: self.gap, seed: options.seed }
    }
}

/// `part / (part + rest)`; 0 of nothing.
fn share(part: usize, rest: usize) -> f64 {
    part as f64 / (part + rest).max(1) as f64
}

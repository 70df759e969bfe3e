//! A run that adapts a model, which can be stopped between two units of work, kept, and gone on with.

use std::sync::{Arc, OnceLock};

use super::ending::Ready;
use super::state::{AdaptStage, AdaptState, Judged};
use super::{BATCHES_A_UNIT, FEW_SEEDS, JUDGED, MARGIN, STREAM, carried_over, configs_at, labels, origin, sort_out};
use crate::boundary::SampleSet;
use crate::boundary::trace::{TraceGround, TracePlace, Tracer};
use crate::collision::Checker;
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::Result;
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::union::UnionClassifier;
use crate::learning::{Budget, LabelBatch, LearnOptions};
use crate::metric::Metric;
use crate::metric::relative::RelativePoses;
use crate::model::learner::{GAP_SHARE, Report, relative_poses};
use crate::model::scene_change::compare;
use crate::model::solve::SolveGround;
use crate::model::solving::Solving;
use crate::model::{EndedBy, Model};
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::coverage::Coverage;
use crate::scene::Scene;

/// How many copies of the lists there are beside them while a checkpoint is written.
const COPIES_TO_STORE: usize = 2;
/// What is learned anew is solved as in a run of many labels, for exits that still hold are there to start from. Of models of fewer than 73,143 labels,
/// which hold some hundreds, that was not measured.
const SOLVING: Solving = Solving::Thorough;

/// A run between two units of work: a look at some of the stored samples, a pass of tracing or of solving, and at last measuring; what it does
/// is told at [`adapt`](super::adapt).
///
/// ```
/// use std::ops::ControlFlow;
/// use extricate::{LearnOptions, Model, model::adapt::Adapter, scene::builtin};
/// let scene = builtin::scene("planar-arm")?;
/// let options = LearnOptions { labels: 2000, seconds: None, ..LearnOptions::default() };
/// let model = Model::learn(scene.clone(), &options, &mut |_| ControlFlow::Continue(()))?;
/// let wider = extricate::Scene { clearance: 1e-3, ..scene };
/// let mut adapter = Adapter::new(&model, wider, &options)?;
/// while adapter.step(&mut |_| ControlFlow::Continue(())) {} // between two steps it can be stored
/// assert_eq!(adapter.finish()?.scene().clearance, 1e-3);
/// # extricate::Result::Ok(())
/// ```
///
/// # Guarantee
/// Without a limit in seconds the model depends on the old model, scene, labels and seed alone: not on the number of threads, nor on where the
/// run was stopped and resumed.
pub struct Adapter<'a> {
    pub(super) old: &'a Model,
    pub(super) ground: AdaptGround,
    pub(super) pool: Arc<rayon::ThreadPool>,
    pub(super) options: LearnOptions,
    pub(super) state: AdaptState,
    /// Made when needed: it holds indices over what `state` holds.
    tracer: Option<Tracer>,
    /// The samples that solving starts from, made when needed.
    solver: Option<SampleSet>,
    /// What was spent, the unit that was stopped included.
    pub(super) spent: Spent,
    pub(super) end: Option<EndedBy>,
    /// After the last unit.
    pub(super) ready: Option<Ready>,
}

/// What does not change meanwhile.
pub(super) struct AdaptGround {
    pub(super) checker: Checker,
    pub(super) metric: Metric,
    /// Of the pairs that changed, with a margin.
    near_change: Checker,
    pub(super) classifier: Option<UnionClassifier>,
    halton: Halton,
    /// Metric units.
    pub(super) gap: f64,
    pub(super) balls: OnceLock<InteriorBalls>,
    /// Of nothing: held-out queries need none.
    pub(super) no_coverage: Coverage,
}

impl<'a> Adapter<'a> {
    /// A run from its beginning. Nothing is labelled yet.
    ///
    /// # Errors
    /// [`Error::Adapt`](crate::Error::Adapt) where robots, limits or metric differ, [`Error::Option`](crate::Error::Option) for an option that makes no sense.
    pub fn new(old: &'a Model, scene: Scene, options: &LearnOptions) -> Result<Self> {
        Self::resume(old, scene, options, AdaptState::default())
    }

    /// A run that has come as far as `state`, which has to be one of this model, scene and options.
    pub(crate) fn resume(old: &'a Model, scene: Scene, options: &LearnOptions, state: AdaptState) -> Result<Self> {
        let pool = options.pool()?;
        let scene = Arc::new(scene);
        let metric = Metric::new(scene.clone());
        let gap = GAP_SHARE * metric.diameter();
        let change = compare(old.scene(), &scene, MARGIN * metric.lever() * gap)?;
        // Configurations that the last time solved would be solved to the same exits again.
        let times = origin(old.statistics()).times as u64;
        let ground = AdaptGround {
            classifier: carried_over(old, &scene),
            halton: Halton::new(scene.space.nv(), (options.seed ^ STREAM).wrapping_add(times)),
            near_change: Checker::new(Arc::new(change.affected)),
            checker: Checker::new(scene),
            metric,
            gap,
            balls: OnceLock::new(),
            no_coverage: Coverage::default(),
        };
        let (options, spent) = (options.clone(), state.mark.spent.clone());
        let (tracer, solver, end, ready) = (None, None, None, None);
        Ok(Self { old, ground, pool: pool.into(), options, state, tracer, solver, spent, end, ready })
    }

    /// Does one unit of work, a second or so; whether there is more to do. `report` is called after every batch of labels. Where
    /// it stops the run, what the unit found by then is kept for [`Adapter::finish`] but is no part of a checkpoint.
    pub fn step(&mut self, report: &mut Report) -> bool {
        if self.end.is_none() {
            let pool = self.pool.clone();
            pool.install(|| self.unit(report));
            if self.end.is_none() && self.bytes() > self.options.memory {
                match self.state.mark.stage {
                    // The classifier is judged all the same, which takes little.
                    AdaptStage::Verifying => self.state.mark.stage = AdaptStage::Judging,
                    AdaptStage::Tracing(_) | AdaptStage::Solving => {
                        self.join_exits();
                        self.state.set_mark(AdaptStage::Measuring(EndedBy::Memory), self.spent.clone());
                    }
                    AdaptStage::Judging | AdaptStage::Measuring(_) => {}
                }
            }
        }
        self.end.is_none()
    }

    fn unit(&mut self, report: &mut Report) {
        if let AdaptStage::Measuring(why) = self.state.mark.stage {
            return self.measure(why, report);
        }
        let mut budget = Budget::resumed(&self.options, &self.spent, report);
        budget.note(self.state.samples.len() / self.nq(), None);
        budget.stage(self.state.mark.stage.name());
        let stage = self.state.mark.stage.clone();
        let mut next = match stage.clone() {
            AdaptStage::Verifying => self.verify(&mut budget),
            AdaptStage::Judging => self.judge(&mut budget),
            AdaptStage::Tracing(place) => self.trace(place, &mut budget),
            AdaptStage::Solving => self.solve(&mut budget),
            AdaptStage::Measuring(why) => AdaptStage::Measuring(why),
        };
        self.spent = budget.spent_so_far();
        let traces = matches!(stage, AdaptStage::Tracing(_) | AdaptStage::Solving);
        match budget.end() {
            Some(BudgetEnd::Interrupted) => {
                self.end = Some(EndedBy::Interruption);
                return;
            }
            // All samples are looked at, however long that takes: what is not would be lost.
            Some(BudgetEnd::Seconds) if traces => next = AdaptStage::Measuring(EndedBy::Seconds),
            Some(BudgetEnd::Labels) if traces => next = AdaptStage::Measuring(EndedBy::Labels),
            _ => {}
        }
        match next {
            AdaptStage::Tracing(_) => self.state.doubtful.clear(),
            AdaptStage::Solving | AdaptStage::Measuring(_) => self.join_exits(),
            AdaptStage::Verifying | AdaptStage::Judging => {}
        }
        self.state.set_mark(next, self.spent.clone());
    }

    /// Looks at some of the stored samples: where no changed pair is near, they are what they were.
    fn verify(&mut self, budget: &mut Budget) -> AdaptStage {
        let (nq, stand_ins) = (self.nq(), self.old.statistics().stand_ins);
        let Self { old, ground, state, .. } = self;
        let affects = |configs: &[f64]| labels(&ground.near_change, configs);
        let stored = &old.boundary().configs()[stand_ins * nq..];
        let (total, of_samples) = (stored.len() / nq, old.boundary().len() - old.boundary().exits() - stand_ins);
        for _ in 0..BATCHES_A_UNIT {
            let first = state.place.verified;
            if first == total || budget.end() == Some(BudgetEnd::Interrupted) {
                break;
            }
            let is_exits = first >= of_samples;
            let rows = BATCH.min(if is_exits { total } else { of_samples } - first);
            // What cannot be looked at is not kept.
            let batch = &stored[first * nq..(first + rows.min(budget.left())) * nq];
            for (q, near) in batch.chunks_exact(nq).zip(budget.label(&affects, batch)) {
                let kept = if is_exits { &mut state.exits } else { &mut state.samples };
                if near == Label::Free { kept } else { &mut state.doubtful }.extend_from_slice(q);
            }
            state.place.verified += rows;
        }
        budget.note(state.samples.len() / nq, None);
        if state.place.verified < total { AdaptStage::Verifying } else { AdaptStage::Judging }
    }

    /// Labels what a change came near, and uniform configurations, by which the old classifier is judged.
    fn judge(&mut self, budget: &mut Budget) -> AdaptStage {
        let (nq, labels_in_all) = (self.nq(), self.options.labels);
        let Self { ground, state, .. } = self;
        let scene = ground.checker.scene_arc();
        let label = |configs: &[f64]| labels(&ground.checker, configs);
        let doubtful = &state.doubtful[..state.doubtful.len().min(budget.left().saturating_mul(nq))];
        sort_out(doubtful, budget.label(&label, doubtful), &mut state.known, nq);
        let count = JUDGED.min(budget.left() / 8);
        let configs = configs_at(scene, &ground.halton, 0, count);
        let truth = budget.label(&label, &configs);
        let poses = RelativePoses::new(scene.clone());
        let features = |configs: &[f64], pairs: &[u32]| relative_poses(&poses, nq, configs, pairs);
        let classifier = ground.classifier.as_ref();
        let accuracy = classifier.map_or([None; 2], |classifier| classifier.accuracy(nq, &features, &configs, &truth));
        let mut uniform = Exploration::default();
        sort_out(&configs, truth, &mut uniform, nq);
        let held_out = [&uniform.free, &uniform.colliding].map(|list| list.len() / nq);
        let colliding_share = held_out[1] as f64 / count.max(1) as f64;
        // What is free on the far side of where an obstacle went is no old sample, and no changed pair comes near it.
        state.known.free.extend_from_slice(&uniform.free);
        state.fresh.colliding = uniform.colliding;
        let solves = ground.explores()
            && (!state.exits.is_empty() || Solving::of(labels_in_all, ground.metric.kind()) == Some(SOLVING));
        let place = &mut state.place;
        place.judged = Judged { accuracy, held_out, colliding_share };
        (place.kept, place.solves) = (state.samples.len() / nq, solves);
        place.kept_back = if solves { budget.left() / 2 } else { 0 };
        AdaptStage::Tracing(None)
    }

    /// A pass from what collides now; where little does, further configurations that a changed pair comes near are labelled before it.
    fn trace(&mut self, place: Option<TracePlace>, budget: &mut Budget) -> AdaptStage {
        let nq = self.nq();
        let Self { ground, options, state, tracer, .. } = self;
        let kept_back = state.place.kept_back;
        let after = if state.place.solves { AdaptStage::Solving } else { AdaptStage::Measuring(EndedBy::Labels) };
        if budget.end().is_some() || budget.left() <= kept_back + 1 {
            return after;
        }
        let scene = ground.checker.scene();
        let label = |configs: &[f64]| labels(&ground.checker, configs);
        let known = &mut state.known;
        let used = place.as_ref().map_or(0, |place| place.seeds_used);
        // Tracing starts from something free: until there is, it is looked for, as long as there are labels.
        let nothing_free = state.samples.is_empty() && known.free.is_empty();
        if (nothing_free || known.colliding.len() / nq < used + FEW_SEEDS) && ground.explores() {
            let count = BATCH.min((budget.left() - kept_back) / 2);
            let configs = configs_at(scene, &ground.halton, JUDGED as u64 + known.next, count);
            known.next += count as u64;
            let near = budget.label(&|configs: &[f64]| labels(&ground.near_change, configs), &configs);
            let of_interest = configs.chunks_exact(nq).zip(near).filter(|(_, near)| *near == Label::Colliding);
            let configs: Vec<f64> = of_interest.flat_map(|(q, _)| q.iter().copied()).collect();
            sort_out(&configs, budget.label(&label, &configs), known, nq);
        }
        if known.colliding.len() / nq == used || (state.samples.is_empty() && known.free.is_empty()) {
            return if ground.explores() { AdaptStage::Tracing(place) } else { after };
        }
        let trace_ground = ground.trace_ground(&label, options.seed);
        let tracer = tracer.get_or_insert_with(|| {
            let first = || TracePlace { indexed: state.place.kept, ..Tracer::first_place(known, nq) };
            Tracer::at(&trace_ground, known, &state.samples, place.unwrap_or_else(first))
        });
        let most = budget.left().saturating_sub(kept_back);
        let paid = tracer.pass(&trace_ground, known, &mut state.samples, &ground.halton, most, budget);
        if paid { AdaptStage::Tracing(Some(tracer.place().clone())) } else { after }
    }

    fn solve(&mut self, budget: &mut Budget) -> AdaptStage {
        // What tracing held is not needed any more.
        self.tracer = None;
        let Self { ground, options, state, solver, .. } = self;
        let label = |configs: &[f64]| labels(&ground.checker, configs);
        let AdaptState { samples, fresh, place, .. } = state;
        let ground = ground.to_solve(options.seed);
        let paid = ground.pass(fresh, samples, &mut place.solved, solver, &label, budget);
        if paid { AdaptStage::Solving } else { AdaptStage::Measuring(EndedBy::Labels) }
    }

    /// Puts the exits behind the samples, and what is solved next behind what was judged and explored.
    pub(super) fn join_exits(&mut self) {
        let AdaptState { samples, exits, fresh, known, place, mark, .. } = &mut self.state;
        if matches!(mark.stage, AdaptStage::Solving | AdaptStage::Measuring(_)) {
            return;
        }
        place.solved.exits = exits.len() / self.ground.checker.scene().space.nq();
        samples.append(exits);
        fresh.next = JUDGED as u64 + known.next;
    }

    /// Memory that the run holds, counted \[bytes\]: lists, indices over them, and on top of these what is larger, the index that
    /// [`Adapter::finish`] will make or a checkpoint. Not counted: the old model, scene and checker, what a thread works with, and what a unit of
    /// work holds only while it lasts.
    pub fn bytes(&self) -> usize {
        let (nq, state) = (self.nq(), &self.state);
        let indexed = |rows: usize, exits: usize| SampleSet::bytes(&self.ground.metric, nq, rows, exits);
        let listed: usize = state.lists().iter().map(|list| size_of_val(&list[..])).sum();
        // Told by where the run stands, as one that was just resumed holds no tracer yet.
        let starts = match &state.mark.stage {
            AdaptStage::Tracing(Some(place)) => indexed(place.starts, 0) + indexed(place.indexed, 0),
            _ => 0,
        };
        let (solver, solved_from) = self.solver.as_ref().map_or((0, 0), |set| (set.bytes_of_planes(), set.exits()));
        let solver_index = self.solver.as_ref().map_or(0, |set| indexed(set.len(), set.exits()));
        let exits = state.exits.len() / nq + state.place.solved.exits;
        // Exits are alike in what they know, also to those of the old model. While it is gathered there are two of it.
        let old = self.old.boundary();
        let planes_of_one = (old.bytes_of_planes() / old.exits().max(1)).max(solver / solved_from.max(1));
        let finished = indexed((state.samples.len() + state.exits.len()) / nq, exits) + 2 * planes_of_one * exits;
        listed + starts + solver + solver_index + finished.max(COPIES_TO_STORE * listed)
    }

    /// The new scene.
    pub fn scene(&self) -> &Scene {
        self.ground.checker.scene()
    }

    /// The model that is adapted.
    pub fn old(&self) -> &Model {
        self.old
    }

    /// What the run may spend, and its seed.
    pub fn options(&self) -> &LearnOptions {
        &self.options
    }

    /// What has been found, and where the last whole unit of work ended.
    pub fn state(&self) -> &AdaptState {
        &self.state
    }

    pub(super) fn nq(&self) -> usize {
        self.scene().space.nq()
    }
}

impl AdaptGround {
    /// Whether any pair changed.
    fn explores(&self) -> bool {
        !self.near_change.scene().pairs.is_empty()
    }

    fn trace_ground<'a>(&'a self, label: &'a LabelBatch<'a>, seed: u64) -> TraceGround<'a> {
        let space = &self.checker.scene().space;
        TraceGround { space, metric: &self.metric, label, gap: self.gap, seed, draws_seeds: false }
    }

    fn to_solve(&self, seed: u64) -> SolveGround<'_> {
        SolveGround {
            checker: &self.checker,
            metric: &self.metric,
            balls: self.balls.get_or_init(|| InteriorBalls::new(&self.checker)),
            no_coverage: &self.no_coverage,
            halton: &self.halton,
            gap: self.gap,
            seed,
            solving: SOLVING,
        }
    }
}

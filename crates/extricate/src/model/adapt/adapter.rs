//! A run that adapts a model, which can be stopped between two units of work, kept, and gone on
//! with.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::carried::{carried_over, configs_at, origin, sort_out};
use super::scene_change::compare;
use super::state::{AdaptStage, AdaptState, ClassifierAccuracy};
use crate::collision::Checker;
use crate::cspace::Label;
use crate::error::{Error, Result};
use crate::learning::budget::{BudgetEnd, Spent};
use crate::learning::exploration::{BATCH, Exploration};
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::learning::{Budget, LearnOptions};
use crate::metric::relative::RelativePoses;
use crate::model::evaluate::EvaluationBudget;
use crate::model::learned::Model;
use crate::model::learner::relative_poses;
use crate::model::run::ending::finish;
use crate::model::run::work::{Conclusion, Found, Report, Work, spent};
use crate::model::run::{self, Run, RunContext, labels};
use crate::model::solve::SolvePlace;
use crate::model::solve::policy::Solving;
use crate::model::statistics::{Adapted, EndedBy};
use crate::samples::SampleSet;
use crate::samples::trace::{TracePlace, Tracer};
use crate::scene::Scene;

/// What is learned anew is solved as in a run of many labels, for exits that still hold are there
/// to start from. Of models of fewer than 73,143 labels, which hold some hundreds, that was not
/// measured.
const SOLVING: Solving = Solving::Thorough;

/// A changed pair is far where it is farther apart than twice what the boundary's gap typically
/// moves any point.
const MARGIN: f64 = 2.0;
/// Uniform configurations that the classifier is judged by.
const JUDGED: usize = 2000;
/// Batches of stored samples that are looked at in one unit of work: a tenth of a second or so.
const BATCHES_A_UNIT: usize = 16;
/// Seeds below which more are looked for: a small pass, so that passes and exploration share the
/// budget.
const FEW_SEEDS: usize = 256;
/// Turns the seed into another one: what is explored shall not be what the old model was learned
/// from.
const STREAM: u64 = 0x61_64_61_70_74;

/// A run between two units of work: a look at some of the stored samples, a pass of tracing or of
/// solving, and at last measuring; [`adapt`](super::adapt) says what it does.
///
/// ```
/// use std::ops::ControlFlow;
/// use extricate::{Adapter, LearnOptions, Model, builtin};
/// let scene = builtin::scene("planar-arm")?;
/// let options = LearnOptions { labels: 2000, seconds: None, ..LearnOptions::default() };
/// let model = Model::learn(scene.clone(), &options)?;
/// let wider = extricate::Scene { clearance: 1e-3, ..scene };
/// let mut adapter = Adapter::new(&model, wider, &options)?;
/// while adapter.step(&mut |_| ControlFlow::Continue(())) {} // between two steps it can be stored
/// assert_eq!(adapter.finish()?.scene().clearance, 1e-3);
/// # extricate::Result::Ok(())
/// ```
///
/// # Guarantee
/// Without a limit in seconds the model depends on the old model, scene, labels and seed alone: not
/// on the number of threads, nor on where the run was stopped and resumed.
pub struct Adapter<'a>(Run<Adapting<'a>>);

/// What of a run is adapting.
struct Adapting<'a> {
    old: &'a Model,
    /// Of the pairs that changed, with a margin.
    near_change: Checker,
    relative: RelativePoses,
    classifier: Option<ObstacleClassifier>,
    state: AdaptState,
}

impl<'a> Adapter<'a> {
    /// A run from its beginning. Nothing is labelled yet.
    ///
    /// # Errors
    /// [`Error::Adapt`](crate::Error::Adapt) where robots, limits or metric differ,
    /// [`Error::Option`](crate::Error::Option) for an option that makes no sense.
    pub fn new(old: &'a Model, scene: Scene, options: &LearnOptions) -> Result<Self> {
        Self::resume(old, scene, options, AdaptState::default())
    }

    /// A run that has come as far as `state`, which has to be one of this model, scene and options.
    pub(crate) fn resume(old: &'a Model, scene: Scene, options: &LearnOptions, state: AdaptState) -> Result<Self> {
        let (pool, scene) = (options.pool()?, Arc::new(scene));
        // Configurations that the last time solved would be solved to the same exits again.
        let times = origin(old.statistics()).times as u64;
        let ground = RunContext::new(scene.clone(), options, (options.seed ^ STREAM).wrapping_add(times));
        let change = compare(old.scene(), &scene, MARGIN * ground.metric.lever() * ground.gap)?;
        let near_change = Checker::new(Arc::new(change.affected));
        let relative = RelativePoses::new(scene);
        let (classifier, spent) = (carried_over(old, &relative), state.mark.spent.clone());
        Ok(Self(Run::new(pool, ground, Adapting { old, near_change, relative, classifier, state }, spent)))
    }

    /// Does one unit of work, a second or so; whether there is more to do. `report` is called after
    /// every batch of labels. Where it stops the run, what the unit found by then is kept for
    /// [`Adapter::finish`] but is no part of a checkpoint.
    pub fn step(&mut self, report: &mut Report) -> bool {
        self.0.step(report)
    }

    /// The model of what has been found so far; measured where the run was not stopped before.
    ///
    /// # Errors
    /// [`Error::Interrupted`] where the caller stopped before every
    /// stored sample was checked; [`Error::NothingFree`] where nothing
    /// free is known of the new scene.
    pub fn finish(self) -> Result<Model> {
        if self.state().mark.stage == AdaptStage::Verifying {
            return Err(Error::Interrupted);
        }
        finish(self.0, &mut |_| ControlFlow::Continue(()))
    }

    /// Memory that the run holds, counted \[bytes\]: lists, indices over them, and on top of these
    /// what is larger, the index that [`Adapter::finish`] will make or a checkpoint. Not counted:
    /// the old model, scene and checker, what a thread works with, and what a unit of work holds
    /// only while it lasts.
    pub fn bytes(&self) -> usize {
        run::bytes(&self.0)
    }

    /// The new scene.
    pub fn scene(&self) -> &Scene {
        self.0.ground.scene()
    }

    /// The model that is adapted.
    pub fn old(&self) -> &Model {
        self.0.work.old
    }

    /// What the run may spend, and its seed.
    pub fn options(&self) -> &LearnOptions {
        &self.0.ground.options
    }

    /// What has been found, and where the last whole unit of work ended.
    pub fn state(&self) -> &AdaptState {
        &self.0.work.state
    }
}

impl Work for Adapting<'_> {
    type Stage = AdaptStage;

    fn stage(&self) -> &AdaptStage {
        &self.state.mark.stage
    }

    fn enter(&mut self, stage: AdaptStage, spent: Spent, nq: usize) {
        match stage {
            AdaptStage::Tracing(_) => self.state.doubtful.clear(),
            AdaptStage::Solving | AdaptStage::Measuring(_) => self.join_exits(nq),
            AdaptStage::Verifying | AdaptStage::Judging => {}
        }
        self.state.set_mark(stage, spent);
    }

    fn unit(&mut self, ground: &RunContext, tracer: &mut Option<Tracer>, budget: &mut Budget) -> AdaptStage {
        match self.state.mark.stage.clone() {
            AdaptStage::Verifying => self.verify(ground, budget),
            AdaptStage::Judging => self.judge(ground, budget),
            AdaptStage::Tracing(place) => self.trace(ground, place, tracer, budget),
            stage @ (AdaptStage::Solving | AdaptStage::Measuring(_)) => stage,
        }
    }

    fn found(&self) -> Found<'_> {
        let AdaptState { known, samples, exits: apart, place, .. } = &self.state;
        let bytes = self.state.lists().iter().map(|list| size_of_val(&list[..])).sum();
        Found { free: &known.free, samples, exits: place.solved.exits, apart, bytes, accuracy: None }
    }

    fn solving(&self, _: &RunContext) -> Solving {
        SOLVING
    }

    fn to_solve(&mut self) -> (&mut Exploration, &mut Vec<f64>, &mut SolvePlace) {
        let AdaptState { fresh, samples, place, .. } = &mut self.state;
        (fresh, samples, &mut place.solved)
    }

    /// Told by where the run stands, as one that was just resumed holds no tracer yet.
    fn traced<'a>(&'a self, _: Option<&'a Tracer>) -> Option<&'a TracePlace> {
        if let AdaptStage::Tracing(place) = &self.state.mark.stage { place.as_ref() } else { None }
    }

    /// Exits are alike in what they know, also to those of the old model.
    fn bytes_of_two_exits(&self, solver: Option<&SampleSet>) -> usize {
        let of_one = |set: &SampleSet| set.bytes_of_planes() / set.solved().max(1);
        2 * of_one(self.old.boundary()).max(solver.map_or(0, of_one))
    }

    fn complete(&mut self, ground: &RunContext, _: &mut Spent, _: &mut Report) -> bool {
        self.join_exits(ground.nq());
        false
    }

    fn advice(&self, _: &RunContext, _: Option<EndedBy>) -> Option<String> {
        Some("no stored sample is free in the new scene; learn it anew".into())
    }

    fn extent(&self, ground: &RunContext, labels: usize) -> EvaluationBudget {
        EvaluationBudget {
            known: Some(self.old.statistics().starts_per_dof),
            ..EvaluationBudget::after(labels, ground.options.seed)
        }
    }

    fn conclude(self) -> Conclusion {
        let from = origin(self.old.statistics());
        let adapted = Some(Adapted { times: from.times + 1, ..from });
        Conclusion { classifier: self.classifier, judged: self.state.place.judged, quality_checks: 0, adapted }
    }
}

impl Adapting<'_> {
    /// Whether any pair changed.
    fn explores(&self) -> bool {
        !self.near_change.scene().pairs.is_empty()
    }

    /// Looks at some of the stored samples: where no changed pair is near, they are what
    /// they were.
    fn verify(&mut self, ground: &RunContext, budget: &mut Budget) -> AdaptStage {
        let (nq, stand_ins) = (ground.nq(), self.old.statistics().stand_ins);
        let Self { old, near_change, state, .. } = self;
        let affects = |configs: &[f64]| labels(near_change, configs);
        let stored = &old.boundary().configs()[stand_ins * nq..];
        let (total, of_samples) = (stored.len() / nq, old.boundary().len() - old.boundary().solved() - stand_ins);
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

    /// Labels what a change came near, and uniform configurations, by which the old classifier is
    /// judged.
    fn judge(&mut self, ground: &RunContext, budget: &mut Budget) -> AdaptStage {
        let (nq, explores) = (ground.nq(), self.explores());
        let Self { classifier, relative, state, .. } = self;
        let label = |configs: &[f64]| ground.label(configs);
        let doubtful = &state.doubtful[..state.doubtful.len().min(budget.left().saturating_mul(nq))];
        sort_out(doubtful, budget.label(&label, doubtful), &mut state.known, nq);
        let count = JUDGED.min(budget.left() / 8);
        let configs = configs_at(ground.scene(), &ground.halton, 0, count);
        let truth = budget.label(&label, &configs);
        let features = |configs: &[f64], pairs: &[u32]| relative_poses(relative, nq, configs, pairs);
        let accuracy =
            classifier.as_ref().map_or([None; 2], |classifier| classifier.accuracy(nq, &features, &configs, &truth));
        let mut uniform = Exploration::default();
        sort_out(&configs, truth, &mut uniform, nq);
        let held_out = [&uniform.free, &uniform.colliding].map(|list| list.len() / nq);
        let colliding_share = held_out[1] as f64 / count.max(1) as f64;
        // What is free on the far side of where an obstacle went is no old sample, and no changed
        // pair comes near it.
        state.known.free.extend_from_slice(&uniform.free);
        state.fresh.colliding = uniform.colliding;
        let by_labels = Solving::of(ground.options.labels, ground.metric.kind());
        let solves = explores && (!state.exits.is_empty() || by_labels == Some(SOLVING));
        let place = &mut state.place;
        place.judged = ClassifierAccuracy { accuracy, held_out, colliding_share };
        (place.kept, place.solves) = (state.samples.len() / nq, solves);
        place.kept_back = if solves { budget.left() / 2 } else { 0 };
        AdaptStage::Tracing(None)
    }

    /// A pass from what collides now; where little does, further configurations that a changed pair
    /// comes near are labelled before it.
    fn trace(
        &mut self,
        ground: &RunContext,
        place: Option<TracePlace>,
        tracer: &mut Option<Tracer>,
        budget: &mut Budget,
    ) -> AdaptStage {
        let (nq, explores) = (ground.nq(), self.explores());
        let Self { near_change, state, .. } = self;
        let (kept_back, solves) = (state.place.kept_back, state.place.solves);
        let after = |budget: &Budget| if solves { AdaptStage::Solving } else { AdaptStage::Measuring(spent(budget)) };
        if budget.end().is_some() || budget.left() <= kept_back + 1 {
            return after(budget);
        }
        let label = |configs: &[f64]| ground.label(configs);
        let known = &mut state.known;
        let used = place.as_ref().map_or(0, |place| place.seeds_used);
        // Tracing starts from something free: until there is, it is looked for, as long as there
        // are labels.
        let nothing_free = state.samples.is_empty() && known.free.is_empty();
        if (nothing_free || known.colliding.len() / nq < used + FEW_SEEDS) && explores {
            let count = BATCH.min((budget.left() - kept_back) / 2);
            let configs = configs_at(ground.scene(), &ground.halton, JUDGED as u64 + known.next, count);
            known.next += count as u64;
            let near = budget.label(&|configs: &[f64]| labels(near_change, configs), &configs);
            let of_interest = configs.chunks_exact(nq).zip(near).filter(|(_, near)| *near == Label::Colliding);
            let configs: Vec<f64> = of_interest.flat_map(|(q, _)| q.iter().copied()).collect();
            sort_out(&configs, budget.label(&label, &configs), known, nq);
        }
        if known.colliding.len() / nq == used || (state.samples.is_empty() && known.free.is_empty()) {
            return if explores { AdaptStage::Tracing(place) } else { after(budget) };
        }
        let to_trace = ground.to_trace(&label, false);
        let tracer = tracer.get_or_insert_with(|| {
            let first = || TracePlace { indexed: state.place.kept, ..Tracer::first_place(known, nq) };
            Tracer::at(&to_trace, known, &state.samples, place.unwrap_or_else(first))
        });
        let most = budget.left().saturating_sub(kept_back);
        let paid = tracer.pass(&to_trace, known, &mut state.samples, &ground.halton, most, budget);
        if paid { AdaptStage::Tracing(Some(tracer.place().clone())) } else { after(budget) }
    }

    /// Puts the exits behind the samples, and what is solved next behind what was judged and
    /// explored.
    fn join_exits(&mut self, nq: usize) {
        let AdaptState { samples, exits, fresh, known, place, mark, .. } = &mut self.state;
        if matches!(mark.stage, AdaptStage::Solving | AdaptStage::Measuring(_)) {
            return;
        }
        place.solved.exits = exits.len() / nq;
        samples.append(exits);
        fresh.next = JUDGED as u64 + known.next;
    }
}

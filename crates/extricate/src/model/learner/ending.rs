//! How a run ends: what it found is indexed and measured, and becomes a model.

use std::time::{Duration, Instant};

use super::super::measure::{Extent, Measured, measure};
use super::super::quality::interval;
use super::super::run_state::{RunState, Stage};
use super::super::{EndedBy, Model, Statistics};
use super::{LearnGround, Learner, Report, stand_ins};
use crate::boundary::SampleSet;
use crate::boundary::trace::Tracer;
use crate::collision::{Checker, most_often_colliding};
use crate::error::{Error, Result};
use crate::learning::Budget;
use crate::learning::budget::BudgetEnd;
use crate::learning::explore::Exploration;
use crate::learning::union::UnionClassifier;
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::index_samples;

/// Configurations below which "collides every time" says nothing.
const FEW: usize = 100;

/// Pairs that an error names.
const NAMED: usize = 5;

/// What the last unit makes of the run.
pub struct Ready {
    boundary: SampleSet,
    measured: Measured,
}

impl Learner {
    /// The last unit: what was learned, `why` it ended, is indexed and measured. A resumed run does it again, to the same end.
    pub(super) fn measure(&mut self, why: EndedBy, report: &mut Report) {
        let started = Instant::now();
        if self.state.known.free.is_empty() {
            self.end = Some(why);
            return;
        }
        let interrupted = self.trace_a_little(report);
        let boundary = self.index();
        let Self { ground, options, state, spent, .. } = self;
        let mut budget = Budget::resumed(options, spent, report);
        budget.note(boundary.len(), state.classified.balanced_accuracy());
        let mut extent = match options.target_excess {
            Some(_) => Extent::in_full(options.seed),
            None => Extent::after(spent.labels, options.seed),
        };
        // A limit that no clock can hold is none.
        let left = options.seconds.map(|limit| Duration::try_from_secs_f64((limit - spent.seconds).max(0.0)));
        extent.until = left.and_then(|left| started.checked_add(left.ok()?));
        let mut go_on = || {
            budget.stage("measuring");
            budget.end() != Some(BudgetEnd::Interrupted)
        };
        let measured = if interrupted { None } else { measure(&ground.to_query(&boundary), &extent, &mut go_on) };
        self.end = Some(if measured.is_some() { why } else { EndedBy::Interruption });
        if measured.is_some() {
            self.state.set_mark(Stage::Measuring(why), self.spent.clone());
        }
        self.ready = Some(Ready { boundary, measured: measured.unwrap_or_default() });
    }

    /// The model of what has been found so far; measured where the run was not stopped before. Where nothing of the boundary was
    /// traced yet, one small pass is made for it.
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
            if self.ready.is_none() {
                self.trace_a_little(report);
                self.ready = Some(Ready { boundary: self.index(), measured: Measured::default() });
            }
            Ok(self.into_model())
        })
    }

    /// Makes a small pass where none was made; whether the caller stopped it.
    fn trace_a_little(&mut self, report: &mut Report) -> bool {
        let Self { ground, options, state, .. } = self;
        if !state.samples.is_empty() {
            return false;
        }
        let label = |configs: &[f64]| ground.label(configs);
        let trace_ground = ground.trace_ground(&label, options);
        let mut budget = Budget::resumed(options, &self.spent, report);
        if budget.left() > 0 {
            let mut tracer = Tracer::new(&trace_ground, &state.known);
            let (known, samples) = (&mut state.known, &mut state.samples);
            tracer.pass(&trace_ground, known, samples, &ground.halton, usize::MAX, &mut budget);
        }
        self.spent = budget.spent_so_far();
        budget.end() == Some(BudgetEnd::Interrupted)
    }

    /// The index of the samples and of what stands in for them: where nothing collided, or little was traced in time, free
    /// configurations are answers too, only farther ones.
    fn index(&mut self) -> SampleSet {
        (self.tracer, self.solver) = (None, None);
        let RunState { known, samples, .. } = &self.state;
        let nq = self.ground.checker.scene().space.nq();
        let configs = [stand_ins(&known.free, samples, nq), samples].concat();
        let LearnGround { checker, metric, .. } = &self.ground;
        index_samples(checker, metric, configs, self.state.solved.exits, self.options.seed)
    }

    fn into_model(self) -> Model {
        let Self { ground, options, state, spent, end, ready, .. } = self;
        let RunState { samples, classified, colliding_share, looks, .. } = state;
        let Ready { boundary, measured } = ready.expect("indexed before");
        let statistics = Statistics {
            labels: spent.labels,
            seed: options.seed,
            boundary_samples: boundary.len(),
            exits: boundary.exits(),
            stand_ins: boundary.len() - samples.len() / ground.checker.scene().space.nq(),
            support_vectors: classified.classifier.as_ref().map_or(0, UnionClassifier::support_vectors),
            colliding_share,
            accuracy_free: classified.accuracy_free,
            accuracy_free_interval: interval(classified.accuracy_free, classified.held_out[0]),
            accuracy_colliding: classified.accuracy_colliding,
            accuracy_colliding_interval: interval(classified.accuracy_colliding, classified.held_out[1]),
            boundary_gap: (!samples.is_empty()).then_some(ground.gap),
            density: measured.density,
            excess: measured.excess,
            starts_per_dof: measured.starts,
            measuring_checks: looks.checks + measured.checks,
            // A run that its owner stops stepping was interrupted too.
            ended_by: end.unwrap_or(EndedBy::Interruption),
            adapted: None,
        };
        let balls = ground.balls.into_inner().unwrap_or_else(|| InteriorBalls::new(&ground.checker));
        Model {
            checker: ground.checker,
            metric: ground.metric,
            boundary,
            classifier: classified.classifier,
            balls,
            coverage: measured.coverage,
            statistics,
        }
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
        let often = most_often_colliding(checker, &tried);
        let always: Vec<String> =
            often.iter().take_while(|(_, count)| *count == tried.len()).map(|(pair, _)| named(*pair)).collect();
        let share = |(pair, count): &(usize, usize)| format!("{} ({} %)", named(*pair), 100 * count / tried.len());
        let others: Vec<String> = often.iter().skip(always.len()).take(NAMED).map(share).collect();
        let (always, others) = (always.join(", "), others.join(", "));
        let advice = if tried.len() < FEW {
            "too few to tell why; spend more labels or seconds".into()
        } else if always.is_empty() {
            format!(
                "no single pair is to blame; {others} collide most often: disable those that overlap by design, widen the limits, \
                 lower the clearance or spend more labels"
            )
        } else {
            // Where those are by design, the next ones may be too: who has to run again for each of them learns of one a run.
            let others =
                if others.is_empty() { others } else { format!("; of the others, {others} collide most often") };
            format!(
                "these pairs collide every time; if by design, add to the scene: [pairs] disable = [{always}]{others}"
            )
        };
        Error::NothingFree { labels: self.spent.labels, advice }
    }
}

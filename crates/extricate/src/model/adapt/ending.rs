//! How an adapting run ends: what it found is indexed and measured, and becomes a model.

use std::time::{Duration, Instant};

use super::adapter::Adapter;
use super::origin;
use super::state::{AdaptStage, AdaptState};
use crate::boundary::SampleSet;
use crate::error::{Error, Result};
use crate::learning::Budget;
use crate::learning::budget::BudgetEnd;
use crate::learning::union::UnionClassifier;
use crate::model::learner::{Report, stand_ins};
use crate::model::measure::{Extent, Measured, measure};
use crate::model::quality::interval;
use crate::model::{Adapted, EndedBy, Model, Statistics};
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::{Context, Learned, index_samples};

/// What the last unit makes of the run.
pub struct Ready {
    boundary: SampleSet,
    /// `None` where the caller stopped it.
    measured: Option<Measured>,
}

impl Adapter<'_> {
    /// The last unit: what was found, `why` the run ended, is indexed and measured. A resumed run does it again, to the same end.
    pub(super) fn measure(&mut self, why: EndedBy, report: &mut Report) {
        let started = Instant::now();
        if self.is_empty() {
            self.end = Some(why);
            return;
        }
        let boundary = self.index();
        let starts = self.old.statistics().starts_per_dof;
        let Self { ground, options, spent, .. } = self;
        let mut budget = Budget::resumed(options, spent, report);
        budget.note(boundary.len(), None);
        let mut extent = Extent { known: Some(starts), ..Extent::after(spent.labels, options.seed) };
        // A limit that no clock can hold is none.
        let left = options.seconds.map(|limit| Duration::try_from_secs_f64((limit - spent.seconds).max(0.0)));
        extent.until = left.and_then(|left| started.checked_add(left.ok()?));
        let mut go_on = || {
            budget.stage("measuring");
            budget.end() != Some(BudgetEnd::Interrupted)
        };
        let balls = ground.balls.get_or_init(|| InteriorBalls::new(&ground.checker));
        let learned = Learned { boundary: &boundary, coverage: &ground.no_coverage, starts };
        let to_query = Context::new((&ground.checker, &ground.metric, balls), learned, None);
        let measured = measure(&to_query, &extent, &mut go_on);
        self.end = Some(if measured.is_some() { why } else { EndedBy::Interruption });
        self.ready = Some(Ready { boundary, measured });
    }

    /// The model of what has been found so far; measured where the run was not stopped before.
    ///
    /// # Errors
    /// [`Error::Interrupted`] where the caller stopped before every stored sample was looked at; [`Error::NothingFree`] where nothing free is
    /// known of the new scene.
    pub fn finish(mut self) -> Result<Model> {
        if self.state.mark.stage == AdaptStage::Verifying {
            return Err(Error::Interrupted);
        }
        if self.is_empty() {
            let advice = "no stored sample is free in the new scene; learn it anew".into();
            return Err(Error::NothingFree { labels: self.spent.labels, advice });
        }
        let pool = self.pool.clone();
        pool.install(|| {
            if self.ready.is_none() {
                self.join_exits();
                self.ready = Some(Ready { boundary: self.index(), measured: None });
            }
            Ok(self.into_model())
        })
    }

    /// Whether nothing free is known.
    fn is_empty(&self) -> bool {
        let AdaptState { samples, exits, known, .. } = &self.state;
        samples.is_empty() && exits.is_empty() && known.free.is_empty()
    }

    /// The index of the samples and of what stands in for them.
    fn index(&self) -> SampleSet {
        let AdaptState { known, samples, place, .. } = &self.state;
        let configs = [stand_ins(&known.free, samples, self.nq()), samples].concat();
        let (checker, metric) = (&self.ground.checker, &self.ground.metric);
        index_samples(checker, metric, configs, place.solved.exits, self.options.seed)
    }

    fn into_model(self) -> Model {
        let nq = self.nq();
        let Self { old, ground, options, state, spent, end, ready, .. } = self;
        let Ready { boundary, measured } = ready.expect("indexed before");
        let starts = old.statistics().starts_per_dof;
        let measured = measured.unwrap_or_else(|| Measured { starts, ..Measured::default() });
        let (judged, classifier, from) = (&state.place.judged, ground.classifier, origin(old.statistics()));
        let statistics = Statistics {
            labels: spent.labels,
            seed: options.seed,
            boundary_samples: boundary.len(),
            exits: boundary.exits(),
            stand_ins: boundary.len() - state.samples.len() / nq,
            support_vectors: classifier.as_ref().map_or(0, UnionClassifier::support_vectors),
            colliding_share: judged.colliding_share,
            accuracy_free: judged.accuracy[0],
            accuracy_free_interval: interval(judged.accuracy[0], judged.held_out[0]),
            accuracy_colliding: judged.accuracy[1],
            accuracy_colliding_interval: interval(judged.accuracy[1], judged.held_out[1]),
            boundary_gap: (!state.samples.is_empty()).then_some(ground.gap),
            density: measured.density,
            excess: measured.excess,
            starts_per_dof: measured.starts,
            measuring_checks: measured.checks,
            // A run that its owner stops stepping was interrupted too.
            ended_by: end.unwrap_or(EndedBy::Interruption),
            adapted: Some(Adapted { times: from.times + 1, ..from }),
        };
        let balls = ground.balls.into_inner().unwrap_or_else(|| InteriorBalls::new(&ground.checker));
        Model {
            checker: ground.checker,
            metric: ground.metric,
            boundary,
            classifier,
            balls,
            coverage: measured.coverage,
            statistics,
        }
    }
}

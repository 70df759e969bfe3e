//! How a run ends: what it found is indexed and measured, and becomes a model.

use std::time::{Duration, Instant};

use super::{Conclusion, Found, Run, Stage, Work};
use crate::boundary::SampleSet;
use crate::error::{Error, Result};
use crate::learning::Budget;
use crate::learning::budget::BudgetEnd;
use crate::learning::union::UnionClassifier;
use crate::model::calibrate::unmeasured;
use crate::model::learner::Report;
use crate::model::measure::{Measured, measure};
use crate::model::quality::{Judged, interval};
use crate::model::{EndedBy, Model, Statistics};

/// Boundary samples below which free configurations stand in for those that are missing: a query
/// wants several starts that are not alike.
const STAND_INS: usize = 128;

/// What the last unit makes of the run.
pub struct Ready {
    boundary: SampleSet,
    /// `None` where the caller stopped it.
    measured: Option<Measured>,
}

impl Found<'_> {
    /// Whether nothing free is known.
    fn is_empty(&self) -> bool {
        self.free.is_empty() && self.samples.is_empty() && self.apart.is_empty()
    }
}

impl<W: Work> Run<W> {
    /// The last unit: what was found, `why` the run ended, is indexed and measured. A resumed run
    /// does it again, to the same end.
    pub(super) fn measure(&mut self, why: EndedBy, report: &mut Report) {
        let started = Instant::now();
        if self.work.found().is_empty() {
            self.end = Some(why);
            return;
        }
        let stopped = self.work.complete(&self.ground, &mut self.spent, report);
        let boundary = self.index();
        let Self { ground, work, spent, .. } = self;
        let options = &ground.options;
        let mut budget = Budget::resumed(options, spent, report);
        budget.note(boundary.len(), work.found().accuracy);
        let mut extent = work.extent(ground, spent.labels);
        // A limit that no clock can hold is none.
        let left = options.seconds.map(|limit| Duration::try_from_secs_f64((limit - spent.seconds).max(0.0)));
        extent.until = left.and_then(|left| started.checked_add(left.ok()?));
        let mut go_on = || {
            budget.stage("measuring");
            budget.end() != Some(BudgetEnd::Interrupted)
        };
        let to_query = ground.to_query(&boundary, extent.known.unwrap_or_else(unmeasured));
        let measured = if stopped { None } else { measure(&to_query, &extent, &mut go_on) };
        self.end = Some(if measured.is_some() { why } else { EndedBy::Interruption });
        if measured.is_some() {
            self.work.enter(Stage::measuring(why), self.spent.clone(), self.ground.nq());
        }
        self.ready = Some(Ready { boundary, measured });
    }

    /// The model of what has been found so far; measured where the run was not stopped before.
    pub fn finish(mut self, report: &mut Report) -> Result<Model> {
        let pool = self.pool.clone();
        pool.install(|| {
            if self.work.found().is_empty() {
                let (advice, labels) = (self.work.advice(&self.ground, self.end), self.spent.labels);
                return Err(advice.map_or(Error::Interrupted, |advice| Error::NothingFree { labels, advice }));
            }
            if self.ready.is_none() {
                self.work.complete(&self.ground, &mut self.spent, report);
                self.ready = Some(Ready { boundary: self.index(), measured: None });
            }
            Ok(self.into_model())
        })
    }

    /// The index of the samples and of what stands in for them: where nothing collided, or little
    /// was traced in time, free configurations are answers too, only farther ones.
    fn index(&mut self) -> SampleSet {
        (self.tracer, self.solver) = (None, None);
        let (Found { free, samples, exits, .. }, nq) = (self.work.found(), self.ground.nq());
        let missing = STAND_INS.saturating_sub(samples.len() / nq) * nq;
        self.ground.index([&free[..free.len().min(missing)], samples].concat(), exits)
    }

    fn into_model(self) -> Model {
        let Self { ground, work, spent, end, ready, .. } = self;
        let Ready { boundary, measured } = ready.expect("indexed before");
        let starts = work.extent(&ground, spent.labels).known.unwrap_or_else(unmeasured);
        let measured = measured.unwrap_or_else(|| Measured { starts, ..Measured::default() });
        let samples = work.found().samples.len() / ground.nq();
        let Conclusion { classifier, judged, looks, adapted } = work.conclude();
        let Judged { accuracy, held_out, colliding_share } = judged;
        let statistics = Statistics {
            labels: spent.labels,
            seed: ground.options.seed,
            boundary_samples: boundary.len(),
            exits: boundary.exits(),
            stand_ins: boundary.len() - samples,
            support_vectors: classifier.as_ref().map_or(0, UnionClassifier::support_vectors),
            colliding_share,
            accuracy_free: accuracy[0],
            accuracy_free_interval: interval(accuracy[0], held_out[0]),
            accuracy_colliding: accuracy[1],
            accuracy_colliding_interval: interval(accuracy[1], held_out[1]),
            boundary_gap: (samples > 0).then_some(ground.gap),
            density: measured.density,
            excess: measured.excess,
            gap: measured.gap,
            starts_per_dof: measured.starts,
            measuring_checks: looks + measured.checks,
            // A run that its owner stops stepping was interrupted too.
            ended_by: end.unwrap_or(EndedBy::Interruption),
            adapted,
        };
        Model { world: ground.into_world(), boundary, classifier, coverage: measured.coverage, statistics }
    }
}

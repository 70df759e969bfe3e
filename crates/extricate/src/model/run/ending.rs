//! How a run ends: what it found is indexed and measured, and becomes a model.

use std::time::{Duration, Instant};

use super::work::{Conclusion, Found, Report, Stage, Work};
use super::{Ready, Run};
use crate::error::{Error, Result};
use crate::learning::Budget;
use crate::learning::budget::BudgetEnd;
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::model::evaluate::calibrate::unmeasured;
use crate::model::evaluate::figures::{ClassifierAccuracy, interval};
use crate::model::evaluate::{Evaluation, measure};
use crate::model::learned::Model;
use crate::model::statistics::{EndedBy, Statistics};
use crate::samples::SampleSet;

/// Boundary samples below which free configurations stand in for those that are missing: a query
/// wants several starts that are not alike.
const STAND_INS: usize = 128;

impl Found<'_> {
    /// Whether nothing free is known.
    fn is_empty(&self) -> bool {
        self.free.is_empty() && self.samples.is_empty() && self.apart.is_empty()
    }
}

/// The last unit: what was found, `why` the run ended, is indexed and measured. A resumed run
/// does it again, to the same end.
pub fn end<W: Work>(run: &mut Run<W>, why: EndedBy, report: &mut Report) {
    let started = Instant::now();
    if run.work.found().is_empty() {
        run.end = Some(why);
        return;
    }
    let stopped = run.work.complete(&run.ground, &mut run.spent, report);
    let boundary = index(run);
    let Run { ground, work, spent, .. } = run;
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
    run.end = Some(if measured.is_some() { why } else { EndedBy::Interruption });
    if measured.is_some() {
        run.work.enter(Stage::measuring(why), run.spent.clone(), run.ground.nq());
    }
    run.ready = Some(Ready { boundary, measured });
}

/// The model of what has been found so far; measured where the run was not stopped before.
pub fn finish<W: Work>(mut run: Run<W>, report: &mut Report) -> Result<Model> {
    let pool = run.pool.clone();
    pool.install(|| {
        if run.work.found().is_empty() {
            let (advice, labels) = (run.work.advice(&run.ground, run.end), run.spent.labels);
            return Err(advice.map_or(Error::Interrupted, |advice| Error::NothingFree { labels, advice }));
        }
        if run.ready.is_none() {
            run.work.complete(&run.ground, &mut run.spent, report);
            run.ready = Some(Ready { boundary: index(&mut run), measured: None });
        }
        Ok(into_model(run))
    })
}

/// The index of the samples and of what stands in for them: where nothing collided, or little
/// was traced in time, free configurations are answers too, only farther ones.
fn index<W: Work>(run: &mut Run<W>) -> SampleSet {
    (run.tracer, run.solver) = (None, None);
    let (Found { free, samples, exits, .. }, nq) = (run.work.found(), run.ground.nq());
    let missing = STAND_INS.saturating_sub(samples.len() / nq) * nq;
    run.ground.index([&free[..free.len().min(missing)], samples].concat(), exits)
}

fn into_model<W: Work>(run: Run<W>) -> Model {
    let Run { ground, work, spent, end, ready, .. } = run;
    let Ready { boundary, measured } = ready.expect("indexed before");
    let starts = work.extent(&ground, spent.labels).known.unwrap_or_else(unmeasured);
    let measured = measured.unwrap_or_else(|| Evaluation { starts, ..Evaluation::default() });
    let samples = work.found().samples.len() / ground.nq();
    let Conclusion { classifier, judged, quality_checks, adapted } = work.conclude();
    let ClassifierAccuracy { accuracy, held_out, colliding_share } = judged;
    let statistics = Statistics {
        labels: spent.labels,
        seed: ground.options.seed,
        boundary_samples: boundary.len(),
        solved_samples: boundary.solved(),
        stand_ins: boundary.len() - samples,
        support_vectors: classifier.as_ref().map_or(0, ObstacleClassifier::support_vectors),
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
        measuring_checks: quality_checks + measured.checks,
        // A run that its owner stops stepping was interrupted too.
        ended_by: end.unwrap_or(EndedBy::Interruption),
        adapted,
    };
    Model { world: ground.into_world(), boundary, classifier, coverage: measured.coverage, statistics }
}

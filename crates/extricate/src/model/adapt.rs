//! A model of a changed scene from the model of the old one: what still holds is kept, what changed is learned.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::learner::{GAP_SHARE, Report, relative_poses, stand_ins};
use super::measure::{Extent, Measured, measure};
use super::quality::interval;
use super::scene_change::compare;
use super::solve::{SolveGround, SolvePlace, pays};
use super::{Adapted, EndedBy, Model, Statistics};
use crate::boundary::trace::{TraceGround, TracePlace, Tracer};
use crate::collision::Checker;
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::{Error, Result};
use crate::learning::budget::BudgetEnd;
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::union::UnionClassifier;
use crate::learning::{Budget, LearnOptions};
use crate::metric::Metric;
use crate::metric::relative::RelativePoses;
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::coverage::Coverage;
use crate::penetration::{Ground, index_samples};
use crate::scene::Scene;

/// Labels that learning spent, over those that adapting the model spends where nothing else is asked for.
const LEARNING_OVER_ADAPTING: usize = 5;

/// A changed pair is far where it is farther apart than twice what the boundary's gap typically moves any point.
const MARGIN: f64 = 2.0;
/// Uniform configurations that the classifier is judged by.
const JUDGED: usize = 2000;
/// Seeds below which more are looked for: a small pass, so that passes and exploration share the budget.
const FEW_SEEDS: usize = 256;
/// Turns the seed into another one: what is explored shall not be what the old model was learned from.
const STREAM: u64 = 0x61_64_61_70_74;

/// Labels that adapting `model` spends where nothing else is asked for: a fifth of what it took to learn from nothing, however often it was adapted since.
pub fn labels_to_adapt(model: &Model) -> usize {
    (origin(&model.statistics).learned_labels / LEARNING_OVER_ADAPTING).max(1)
}

/// Adapts `model` to `scene`, whose obstacles or pairs differ from those of the model's scene.
///
/// Stored samples that no changed pair comes near keep what is known of them: the pairs that are checked there are those of
/// before. The others are labelled anew. Tracing then starts from them, and from random configurations that a changed pair
/// affects, in turns with exploration. Where the old model has exits, or the budget is large enough for some, random colliding
/// configurations are solved with the second half of what verifying left; else tracing goes on until the budget ends.
///
/// # Guarantee
/// Every sample is free in the new scene. Of samples that were kept, a colliding configuration within the gap is expected,
/// not proved: how far a step of the gap moves a body is measured, not bounded. For the rest as [`Model::learn`], with the same
/// dependence on the options.
///
/// # Errors
/// [`Error::Adapt`] where robots, limits or metric differ; [`Error::Interrupted`] where the caller stopped before every sample was
/// looked at; [`Error::NothingFree`] where nothing free is known of the new scene.
pub fn adapt(model: &Model, scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build().map_err(|e| Error::Option {
        name: "threads",
        value: format!("{} ({e})", options.threads),
        expected: "a number of threads that the system can start",
    })?;
    pool.install(|| adapt_here(model, scene, options, report))
}

fn adapt_here(model: &Model, scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let (started, scene) = (Instant::now(), Arc::new(scene));
    let metric = Metric::new(scene.clone());
    let gap = GAP_SHARE * metric.diameter();
    let change = compare(model.scene(), &scene, MARGIN * metric.lever() * gap)?;
    let (checker, near_change) = (Checker::new(scene.clone()), Checker::new(Arc::new(change.affected)));
    let nq = scene.space.nq();
    let label = |configs: &[f64]| labels(&checker, configs);
    let affects = |configs: &[f64]| labels(&near_change, configs);
    let mut budget = Budget::new(options, report);

    budget.stage("verifying samples");
    let (mut samples, mut exits, mut doubtful) = (Vec::new(), Vec::new(), Vec::new());
    let traced = nq * (model.boundary().len() - model.boundary().exits());
    let (old_samples, old_exits) = model.boundary().configs().split_at(traced);
    let old_samples = &old_samples[model.statistics().stand_ins * nq..];
    let batches = old_samples.chunks(BATCH * nq).map(|batch| (batch, false));
    for (batch, is_exits) in batches.chain(old_exits.chunks(BATCH * nq).map(|batch| (batch, true))) {
        if budget.end() == Some(BudgetEnd::Interrupted) {
            return Err(Error::Interrupted);
        }
        // What cannot be looked at is not kept.
        let batch = &batch[..batch.len().min(budget.left().saturating_mul(nq))];
        for (q, near) in batch.chunks_exact(nq).zip(budget.label(&affects, batch)) {
            let kept = if is_exits { &mut exits } else { &mut samples };
            if near == Label::Free { kept } else { &mut doubtful }.extend_from_slice(q);
        }
    }
    doubtful.truncate(budget.left().saturating_mul(nq));
    let mut known = Exploration::default();
    sort_out(&doubtful, budget.label(&label, &doubtful), &mut known, nq);
    budget.note(samples.len() / nq, None);

    let from = origin(&model.statistics);
    // Configurations that the last time solved would be solved to the same exits again.
    let halton = Halton::new(scene.space.nv(), (options.seed ^ STREAM).wrapping_add(from.times as u64));
    let classifier = carried_over(model, &scene);
    let judged = judge(classifier.as_ref(), &scene, &halton, &label, &mut budget);
    // What is free on the far side of where an obstacle went is no old sample, and no changed pair comes near it.
    known.free.extend_from_slice(&judged.uniform.free);

    budget.stage("tracing what changed");
    let ground = TraceGround {
        space: &scene.space,
        metric: &metric,
        label: &label,
        gap,
        seed: options.seed,
        draws_seeds: false,
    };
    let kept = samples.len() / nq;
    let mut tracer: Option<Tracer> = None;
    let explores = !near_change.scene().pairs.is_empty();
    let solves = explores && (!exits.is_empty() || pays(options.labels));
    let kept_back = if solves { budget.left() / 2 } else { 0 };
    while budget.end().is_none() && budget.left() > kept_back + 1 {
        let left = budget.left() - kept_back;
        let used = tracer.as_ref().map_or(0, |t| t.place().seeds_used);
        let few = known.colliding.len() / nq < used + FEW_SEEDS;
        if few && explores {
            let configs = configs_at(&scene, &halton, JUDGED as u64 + known.next, BATCH.min(left / 2));
            known.next += (configs.len() / nq) as u64;
            let near = budget.label(&affects, &configs);
            let of_interest = configs.chunks_exact(nq).zip(near).filter(|(_, near)| *near == Label::Colliding);
            let configs: Vec<f64> = of_interest.flat_map(|(q, _)| q.iter().copied()).collect();
            sort_out(&configs, budget.label(&label, &configs), &mut known, nq);
        }
        if known.colliding.len() / nq == used || (samples.is_empty() && known.free.is_empty()) {
            if explores { continue } else { break }
        }
        let tracer = tracer.get_or_insert_with(|| {
            let starts = Tracer::first_place(&known, nq);
            Tracer::at(&ground, &known, &samples, TracePlace { indexed: kept, ..starts })
        });
        let most = budget.left().saturating_sub(kept_back);
        if !tracer.pass(&ground, &mut known, &mut samples, &halton, most, &mut budget) {
            break;
        }
    }
    drop(tracer);
    if samples.is_empty() && exits.is_empty() && known.free.is_empty() {
        let advice = "no stored sample is free in the new scene; learn it anew".into();
        return Err(Error::NothingFree { labels: budget.spent(), advice });
    }
    let (balls, coverage) = (InteriorBalls::new(&checker), &Coverage::default());
    let mut place = SolvePlace { exits: exits.len() / nq, ..SolvePlace::default() };
    samples.extend_from_slice(&exits);
    if solves {
        budget.stage("solving");
        let (halton, seed) = (&halton, options.seed);
        let ground =
            SolveGround { checker: &checker, metric: &metric, balls: &balls, no_coverage: coverage, halton, gap, seed };
        let mut fresh = Exploration { next: JUDGED as u64 + known.next, ..judged.uniform };
        let mut indexed = None;
        while budget.end().is_none()
            && ground.pass(&mut fresh, &mut samples, &mut place, &mut indexed, &label, &mut budget)
        {}
    }
    budget.stage("measuring");
    let standing_in = stand_ins(&known.free, &samples, nq);
    samples.splice(..0, standing_in.iter().copied());
    let boundary = index_samples(&checker, &metric, samples, place.exits, options.seed);
    let (clearance, scale) = (scene.clearance, metric.diameter());
    let ground = Ground {
        checker: &checker,
        metric: &metric,
        boundary: &boundary,
        balls: &balls,
        coverage,
        clearance,
        scale,
        width: model.statistics.width,
        is_lean: false,
        change: None,
    };
    let mut extent = Extent { known: Some(model.statistics.width), ..Extent::after(budget.spent(), options.seed) };
    let limit = options.seconds.and_then(|limit| Duration::try_from_secs_f64(limit.max(0.0)).ok());
    extent.until = limit.and_then(|limit| started.checked_add(limit));
    let mut interrupted = || {
        budget.stage("measuring");
        budget.end() == Some(BudgetEnd::Interrupted)
    };
    let measured = measure(&ground, &extent, &mut || !interrupted())
        .unwrap_or_else(|| Measured { width: ground.width, ..Measured::default() });
    let statistics = Statistics {
        labels: budget.spent(),
        seed: options.seed,
        boundary_samples: boundary.len(),
        exits: boundary.exits(),
        stand_ins: standing_in.len() / nq,
        support_vectors: classifier.as_ref().map_or(0, UnionClassifier::support_vectors),
        colliding_share: judged.colliding_share,
        accuracy_free: judged.accuracy[0],
        accuracy_free_interval: interval(judged.accuracy[0], judged.held_out[0]),
        accuracy_colliding: judged.accuracy[1],
        accuracy_colliding_interval: interval(judged.accuracy[1], judged.held_out[1]),
        boundary_gap: (standing_in.len() < boundary.configs().len()).then_some(gap),
        density: measured.density,
        excess: measured.excess,
        width: measured.width,
        measuring_checks: measured.checks,
        ended_by: match budget.end() {
            Some(BudgetEnd::Seconds) => EndedBy::Seconds,
            Some(BudgetEnd::Interrupted) => EndedBy::Interruption,
            _ => EndedBy::Labels,
        },
        adapted: Some(Adapted { times: from.times + 1, ..from }),
    };
    let coverage = measured.coverage;
    Ok(Model { checker, metric, boundary, classifier, balls, coverage, statistics })
}

/// Where a model with these statistics comes from, itself if it was learned from nothing.
fn origin(statistics: &Statistics) -> Adapted {
    statistics.adapted.unwrap_or(Adapted { learned_labels: statistics.labels, times: 0 })
}

fn labels(checker: &Checker, configs: &[f64]) -> Vec<Label> {
    let mut labels = vec![Label::Free; configs.len() / checker.scene().space.nq()];
    checker.label_batch(configs, &mut labels);
    labels
}

/// `count` low-discrepancy configurations from index `first` on, row major.
fn configs_at(scene: &Scene, halton: &Halton, first: u64, count: usize) -> Vec<f64> {
    let mut configs = vec![0.0; count * scene.space.nq()];
    let rows = configs.chunks_exact_mut(scene.space.nq()).enumerate();
    rows.for_each(|(i, q)| halton.config(&scene.space, first + i as u64, q));
    configs
}

fn sort_out(configs: &[f64], labels: Vec<Label>, known: &mut Exploration, nq: usize) {
    for (q, label) in configs.chunks_exact(nq).zip(labels) {
        if label == Label::Free { &mut known.free } else { &mut known.colliding }.extend_from_slice(q);
    }
}

/// The old classifier's machines of the pairs that the new scene has too. Each sees the pose of one body relative to the other, so
/// what it learned of an obstacle holds where that has moved.
fn carried_over(model: &Model, scene: &Scene) -> Option<UnionClassifier> {
    let number = |part: u32| {
        let names = model.scene().pair_names(part as usize);
        (0..scene.pairs.len()).find(|pair| scene.pair_names(*pair) == names).map(|pair| pair as u32)
    };
    model.classifier().map(|classifier| classifier.renumbered(number))
}

/// Of uniform configurations in the new scene.
struct Judged {
    uniform: Exploration,
    /// How often the old classifier is right, on free and on colliding ones.
    accuracy: [Option<f64>; 2],
    /// How many of each there are.
    held_out: [usize; 2],
    colliding_share: f64,
}

fn judge(
    classifier: Option<&UnionClassifier>,
    scene: &Arc<Scene>,
    halton: &Halton,
    label: &crate::learning::LabelBatch,
    budget: &mut Budget,
) -> Judged {
    let (count, nq) = (JUDGED.min(budget.left() / 8), scene.space.nq());
    let configs = configs_at(scene, halton, 0, count);
    let truth = budget.label(label, &configs);
    let poses = RelativePoses::new(scene.clone());
    let features = |configs: &[f64], pairs: &[u32]| relative_poses(&poses, nq, configs, pairs);
    let accuracy = classifier.map_or([None; 2], |classifier| classifier.accuracy(nq, &features, &configs, &truth));
    let mut uniform = Exploration::default();
    sort_out(&configs, truth, &mut uniform, nq);
    let held_out = [&uniform.free, &uniform.colliding].map(|list| list.len() / nq);
    Judged { uniform, accuracy, held_out, colliding_share: held_out[1] as f64 / count.max(1) as f64 }
}

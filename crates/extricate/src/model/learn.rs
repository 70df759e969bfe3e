//! Learning: goes from a scene to a model, in one straight function.
//!
//! The method is that of H. Tian, X. Zhang, C. Wang, J. Pan and D. Manocha, "Efficient global
//! penetration depth computation for articulated models", Computer-Aided Design 70, 2016.
//! A classifier of the obstacle region chooses the configurations to label. Its boundary is sampled
//! densely, and the nearest sample is the answer. Added are solved samples: exits of colliding
//! configurations, with their contact planes.

use std::ops::ControlFlow;
use std::sync::Arc;

use rayon::prelude::*;

use super::advice::advice;
use super::evaluate::figures::interval;
use super::evaluate::{Evaluation, Extent, measure};
use super::learned::Model;
use super::near_miss::NearMisses;
use super::solve::solve;
use super::statistics::{EndedBy, Statistics};
use crate::collision::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::{Error, Result};
use crate::learning::active_learning::{Classified, classify, surprising_first};
use crate::learning::budget::BudgetEnd;
use crate::learning::exploration::{BATCH, Exploration};
use crate::learning::obstacle_classifier::{ObstacleClassifier, Parts};
use crate::learning::{Budget, LearnOptions, LearnProgress};
use crate::metric::MetricScratch;
use crate::metric::relative::{self, RelativePoses};
use crate::query::prepared::Prepared;
use crate::query::{QueryOptions, QueryScratch, Termination, index_samples, nearest_exit};
use crate::samples::SampleSet;
use crate::samples::trace::{TraceInputs, trace};
use crate::scene::Scene;

/// Receives the state of learning after every batch of labels, and may stop it.
type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

/// Share of the budget, in labels or seconds, that exploration takes.
const EXPLORED_SHARE: f64 = 0.2;
/// Most labels that exploration takes; training the classifier needs far fewer.
const MAX_EXPLORED_LABELS: usize = 20_000;
/// If fewer configurations than this are free, exits of as many colliding ones are added.
const MIN_FREE_CONFIGS: usize = 64;
/// Exits are added only if more colliding configurations than this were found for each free one:
/// many limbs are hardly ever all free at once.
const MIN_COLLIDING_PER_FREE: usize = 50;
/// Share of the budget after which the boundary is not traced further.
const MAX_TRACING_SHARE: f64 = 0.2;
/// Boundary samples have a colliding configuration within this share of the space's diameter.
const GAP_SHARE: f64 = 1.0 / 2000.0;
/// Fewest samples of a model: free configurations stand in for missing boundary samples.
const MIN_SAMPLES: usize = 128;
/// Seeds that the classifier searches for surprises, for every second of the limit.
const SURPRISE_SEEDS_PER_SECOND: f64 = 1000.0;

/// Learns a model of `scene`; see [`Model::learn_with`].
pub fn learn(scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    options.pool()?.install(|| {
        let mut budget = Budget::new(options, report);
        let inputs = LearnInputs::new(scene, options);

        let (mut known, colliding_share) = explore(&inputs, &mut budget);
        if known.free.is_empty() {
            return Err(nothing_free(&inputs, &known, &budget));
        }
        let classified = train(&inputs, &mut known, &mut budget);
        let mut samples = trace_boundary(&inputs, &mut known, &mut budget);
        let solved = solve(&inputs.prepared, inputs.gap, &inputs.halton, &mut known, &mut samples, &mut budget);
        let stand_ins = stand_in(&inputs, &known, &mut samples);
        let boundary =
            index_samples(inputs.prepared.checker(), inputs.prepared.metric(), samples, solved, options.seed);
        let end_of_learning = budget.end();
        let measured = measure_learned(&inputs, &boundary, &mut budget);

        let Evaluation { density, excess, gap, checks } = measured;
        let Classified { classifier, accuracy_free, accuracy_colliding, held_out } = classified;
        let statistics = Statistics {
            labels: budget.spent(),
            seed: options.seed,
            boundary_samples: boundary.len(),
            solved_samples: boundary.solved(),
            stand_ins,
            support_vectors: classifier.as_ref().map_or(0, ObstacleClassifier::support_vectors),
            colliding_share,
            accuracy_free,
            accuracy_free_interval: interval(accuracy_free, held_out[0]),
            accuracy_colliding,
            accuracy_colliding_interval: interval(accuracy_colliding, held_out[1]),
            boundary_gap: (stand_ins < boundary.len()).then_some(inputs.gap),
            density,
            excess,
            gap,
            measuring_checks: checks,
            ended_by: ended_by(end_of_learning, &budget),
        };
        Ok(Model { prepared: inputs.prepared.into(), boundary, classifier, statistics })
    })
}

/// The inputs that all steps share.
struct LearnInputs<'a> {
    options: &'a LearnOptions,
    /// The scene, without samples.
    prepared: Prepared,
    /// Sequence that configurations are drawn from.
    halton: Halton,
    /// Every boundary sample has a colliding configuration within this distance (metric units).
    gap: f64,
}

impl<'a> LearnInputs<'a> {
    fn new(scene: Scene, options: &'a LearnOptions) -> Self {
        let prepared = Prepared::new(Arc::new(scene));
        let halton = Halton::new(prepared.scene().space.nv(), options.seed);
        let gap = GAP_SHARE * prepared.metric().diameter();
        Self { options, prepared, halton, gap }
    }

    fn nq(&self) -> usize {
        self.prepared.scene().space.nq()
    }

    /// Returns the exact labels of many configurations (row major).
    fn label(&self, configs: &[f64]) -> Vec<Label> {
        let mut labels = vec![Label::Free; configs.len() / self.nq()];
        self.prepared.checker().label_batch(configs, &mut labels);
        labels
    }
}

/// Labels evenly spread configurations up to its share of the budget, and further until one is
/// free. Also returns the share that collides.
fn explore(inputs: &LearnInputs, budget: &mut Budget) -> (Exploration, f64) {
    let (space, nq) = (&inputs.prepared.scene().space, inputs.nq());
    let label = |configs: &[f64]| inputs.label(configs);
    let wanted = ((inputs.options.labels as f64 * EXPLORED_SHARE) as usize).clamp(1, MAX_EXPLORED_LABELS);
    let mut known = Exploration::default();
    while budget.end().is_none() && budget.spent() < wanted && budget.fraction() < EXPLORED_SHARE {
        let batch = BATCH.min(wanted - budget.spent());
        known.extend(space, &inputs.halton, batch, &label, budget);
    }
    let [free, colliding] = [&known.free, &known.colliding].map(|list| list.len() / nq);
    let colliding_share = colliding as f64 / (colliding + free).max(1) as f64;
    if free < MIN_FREE_CONFIGS && colliding > MIN_COLLIDING_PER_FREE * free.max(1) {
        add_exits(inputs, &mut known, budget);
    }
    while budget.end().is_none() && known.free.is_empty() {
        known.extend(space, &inputs.halton, BATCH, &label, budget);
    }
    (known, colliding_share)
}

/// Adds exits of colliding configurations to the free ones.
fn add_exits(inputs: &LearnInputs, known: &mut Exploration, budget: &mut Budget) {
    let (context, space, mut scratch) =
        (inputs.prepared.context(), &inputs.prepared.scene().space, QueryScratch::default());
    for seed in known.colliding.chunks_exact(inputs.nq()).take(MIN_FREE_CONFIGS) {
        if budget.end().is_some() {
            break;
        }
        let options = QueryOptions { termination: Termination::after_checks(budget.left()), ..QueryOptions::default() };
        let answer = space.config(seed).ok().and_then(|q| nearest_exit(&context, &q, &options, &mut scratch));
        budget.spend(scratch.checks().min(budget.left()));
        known.free.extend(answer.into_iter().flat_map(|answer| Vec::from(answer.witness)));
    }
}

/// Returns why there is no model: the caller stopped, or nothing was free (with advice).
fn nothing_free(inputs: &LearnInputs, known: &Exploration, budget: &Budget) -> Error {
    if budget.end() == Some(BudgetEnd::Interrupted) {
        return Error::Interrupted;
    }
    Error::NothingFree { labels: budget.spent(), advice: advice(inputs.prepared.checker(), &known.colliding) }
}

/// Trains the classifier of the obstacle region, one support vector machine for each pair of
/// bodies. Then orders the colliding configurations for the next steps: near misses and those that
/// the classifier gets wrong come first, since small components hide among them.
fn train(inputs: &LearnInputs, known: &mut Exploration, budget: &mut Budget) -> Classified {
    if budget.end().is_some() {
        return Classified::default();
    }
    budget.stage("training");
    let (checker, nq) = (inputs.prepared.checker(), inputs.nq());
    let relative = RelativePoses::new(checker.scene_arc().clone());
    let label = |configs: &[f64]| inputs.label(configs);
    let features = |configs: &[f64], pairs: &[u32]| relative_poses(&relative, nq, configs, pairs);
    let containing = |configs: &[f64]| colliding_parts(checker, &relative, configs);
    let parts = Parts {
        count: checker.scene().pairs.len(),
        nq,
        containing: &containing,
        features: &features,
        width: relative::WIDTH,
    };
    let classified = classify(&checker.scene().space, &parts, known, inputs.options.seed, budget);
    let seeds = NearMisses::new(checker, inputs.prepared.metric()).seeds(known, &label, budget);
    if let Some(classifier) = &classified.classifier
        && budget.end() != Some(BudgetEnd::Interrupted)
    {
        let by_time = budget.seconds().map_or(usize::MAX, |limit| (limit * SURPRISE_SEEDS_PER_SECOND) as usize);
        surprising_first(classifier, &features, nq, by_time.min(budget.left() / 8), &mut known.colliding);
    }
    known.colliding.splice(..0, seeds);
    classified
}

/// Traces the boundary from colliding configurations to verified samples close to it, row major.
fn trace_boundary(inputs: &LearnInputs, known: &mut Exploration, budget: &mut Budget) -> Vec<f64> {
    budget.stage("tracing the boundary");
    let label = |configs: &[f64]| inputs.label(configs);
    let to_trace = TraceInputs {
        space: &inputs.prepared.scene().space,
        metric: inputs.prepared.metric(),
        label: &label,
        halton: &inputs.halton,
        gap: inputs.gap,
        seed: inputs.options.seed,
    };
    trace(&to_trace, known, MAX_TRACING_SHARE, budget)
}

/// Inserts free configurations before the samples if these are few, and returns how many.
fn stand_in(inputs: &LearnInputs, known: &Exploration, samples: &mut Vec<f64>) -> usize {
    let missing = MIN_SAMPLES.saturating_sub(samples.len() / inputs.nq()) * inputs.nq();
    let stand_ins = &known.free[..known.free.len().min(missing)];
    samples.splice(..0, stand_ins.iter().copied());
    stand_ins.len() / inputs.nq()
}

/// Measures the model on configurations that nothing was learned from. A run that the caller
/// stopped is not measured.
fn measure_learned(inputs: &LearnInputs, boundary: &SampleSet, budget: &mut Budget) -> Evaluation {
    if budget.end() == Some(BudgetEnd::Interrupted) {
        return Evaluation::default();
    }
    budget.note(boundary.len(), None);
    let extent = Extent { until: budget.until_measured(), ..Extent::after(budget.spent(), inputs.options.seed) };
    let mut go_on = || {
        budget.stage("measuring");
        budget.end() != Some(BudgetEnd::Interrupted)
    };
    measure(&inputs.prepared, boundary, &extent, &mut go_on).unwrap_or_default()
}

/// Returns what ended learning, or that the caller stopped measuring.
fn ended_by(end_of_learning: Option<BudgetEnd>, budget: &Budget) -> EndedBy {
    match end_of_learning {
        _ if budget.end() == Some(BudgetEnd::Interrupted) => EndedBy::Interruption,
        Some(BudgetEnd::Seconds) => EndedBy::Seconds,
        // If the labels did not end it, too few are left for another query.
        _ => EndedBy::Labels,
    }
}

/// Returns the relative poses of `pairs` as numbers, configuration after configuration (row major).
fn relative_poses(poses: &RelativePoses, nq: usize, configs: &[f64], pairs: &[u32]) -> Vec<f64> {
    let mut out = Vec::with_capacity(configs.len() / nq * pairs.len() * relative::WIDTH);
    let mut scratch = MetricScratch::default();
    configs.chunks_exact(nq).for_each(|q| poses.embed(q, pairs, &mut scratch, &mut out));
    out
}

/// Returns the parts that each configuration (row major) lies in, ascending.
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

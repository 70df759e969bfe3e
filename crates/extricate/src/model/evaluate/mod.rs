//! Measures a model, on colliding configurations that nothing was learned from.

pub mod figures;

use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::cspace::sampling::uniform;
use crate::cspace::{Config, Label};
use crate::metric::{Anchor, Metric};
use crate::query::prepared::Prepared;
use crate::query::{Context, Effort, QueryOptions, QueryScratch, Stored, Termination, query};
use crate::samples::{BoundaryScratch, SampleQuery, SampleSet};
use figures::{Density, Excess, Gap, percentile};

/// Limits of measuring a model.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Seed of the held-out configurations.
    pub seed: u64,
    /// Most configurations that are labelled to find colliding ones.
    pub draws: usize,
    /// Most colliding configurations that are queried.
    pub queries: usize,
    /// Checks after which no further query begins.
    pub checks: usize,
    /// Time at which to stop; the result then depends on the machine.
    pub until: Option<Instant>,
}

/// Most queries that are compared.
const MAX_QUERIES: usize = 64;
/// Labels of learning for each check of measuring. A check costs several times as much, so
/// measuring takes a part of the time.
const LABELS_PER_CHECK: usize = 4;
/// With fewer labels nothing is queried: they would pay for a query or two, which say nothing.
const MIN_LABELS: usize = 10_000;
/// Labels of learning for each configuration that is labelled to be held out.
const LABELS_PER_DRAW: usize = 4;
const MAX_DRAWS: usize = 4096;

impl Extent {
    /// Returns the limits after learning with `labels` labels.
    pub fn after(labels: usize, seed: u64) -> Self {
        let draws = (labels / LABELS_PER_DRAW).min(MAX_DRAWS);
        let queries = if labels < MIN_LABELS { 0 } else { MAX_QUERIES };
        Self { seed, draws, queries, checks: labels / LABELS_PER_CHECK, until: None }
    }

    fn is_over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }
}

/// What was measured of a model.
#[derive(Debug, Clone, Default)]
pub struct Evaluation {
    /// Density of the samples; `None` if no held-out configuration collides.
    pub density: Option<Density>,
    /// Excess of refined queries; `None` if none was compared.
    pub excess: Option<Excess>,
    /// Gap of the same queries.
    pub gap: Option<Gap>,
    /// Collision and distance evaluations spent, labels of held-out configurations included.
    pub checks: usize,
}

/// Held-out colliding configurations that suffice.
const MAX_HELD_OUT: usize = 1500;
/// Most boundary samples whose spacing is measured.
const MAX_SPACING_SAMPLES: usize = 500;
/// Configurations drawn, and queries made, between two readings of the clock.
const CONFIGS_PER_BATCH: usize = 512;
const QUERIES_PER_BATCH: usize = 16;
/// Starts of the longer search, half of them around the query: it takes about ten times the checks
/// of a refined query.
const LONG_STARTS: usize = 48;
/// Most checks of the longer search: about ten times what it takes, so that no query takes minutes.
const LONG_CHECKS: usize = 20_000;

/// Changes the seed of learning into another one.
const HELD_OUT_SEED: u64 = u64::from_be_bytes(*b"held-out");

/// Measures samples and queries on held-out configurations. `go_on` is called now and then; if it
/// returns `false`, the result is `None`.
///
/// # Guarantee
/// Without a time to stop at, the result depends on `prepared`, `samples` and `extent` alone, not
/// on the number of threads.
pub fn measure(
    prepared: &Prepared,
    samples: &SampleSet,
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<Evaluation> {
    let (context, nq) = (&prepared.with(Some(Stored { samples, holding: None })), samples.nq());
    let (colliding, mut checks) = held_out(context, extent, go_on)?;
    let reaches = nearest_others(prepared.metric(), samples, &colliding, 1);
    let spacings = nearest_others(prepared.metric(), samples, &evenly(samples.configs(), nq, MAX_SPACING_SAMPLES), 2);
    let density = (!reaches.is_empty()).then(|| Density {
        spacing_median: percentile(&spacings, 0.5),
        spacing_p95: percentile(&spacings, 0.95),
        reach_median: percentile(&reaches, 0.5),
        reach_p95: percentile(&reaches, 0.95),
    });
    let asked = &colliding[..colliding.len().min(extent.queries * nq)];
    let (compared, spent) = compare(context, asked, extent, go_on)?;
    checks += spent;
    let [excesses, gaps] = [0, 1].map(|k| compared.iter().map(|figures| figures[k]).collect::<Vec<f64>>());
    Some(Evaluation { density, excess: Excess::of(&excesses), gap: Gap::of(&gaps), checks })
}

/// Returns uniform colliding configurations, row major, and the number of labels that they took.
fn held_out(context: &Context, extent: &Extent, go_on: &mut dyn FnMut() -> bool) -> Option<(Vec<f64>, usize)> {
    let (space, mut rng) = (&context.checker.scene().space, ChaCha8Rng::seed_from_u64(extent.seed ^ HELD_OUT_SEED));
    let (nq, mut colliding, mut drawn) = (space.nq(), Vec::new(), 0);
    while drawn < extent.draws && colliding.len() < MAX_HELD_OUT * nq && !extent.is_over() {
        if !go_on() {
            return None;
        }
        let mut configs = vec![0.0; CONFIGS_PER_BATCH.min(extent.draws - drawn) * nq];
        configs.chunks_exact_mut(nq).for_each(|q| uniform(space, &mut rng, q));
        let mut labels = vec![Label::Free; configs.len() / nq];
        context.checker.label_batch(&configs, &mut labels);
        drawn += labels.len();
        let rows = configs.chunks_exact(nq).zip(labels);
        colliding.extend(rows.filter(|(_, label)| *label == Label::Colliding).flat_map(|(q, _)| q.iter().copied()));
    }
    colliding.truncate(MAX_HELD_OUT * nq);
    Some((colliding, drawn))
}

/// Returns at most `count` rows, at equal distances in the list.
fn evenly(rows: &[f64], nq: usize, count: usize) -> Vec<f64> {
    let step = (rows.len() / nq).div_ceil(count).max(1);
    rows.chunks_exact(nq).step_by(step).flatten().copied().collect()
}

/// Returns the distance of every configuration to its `count`-th nearest boundary sample. A
/// configuration that is a sample itself is its own first.
fn nearest_others(metric: &Metric, samples: &SampleSet, configs: &[f64], count: usize) -> Vec<f64> {
    let nearest = |(anchor, scratch, found): &mut (Anchor, BoundaryScratch, Vec<(u32, f64)>), q: &[f64]| {
        metric.anchor(q, anchor);
        // If two samples coincide, either may come first.
        samples.nearest(SampleQuery::NEAREST, metric, anchor, count, scratch, found);
        found.last().map(|(_, distance)| *distance)
    };
    configs.par_chunks_exact(samples.nq()).map_init(Default::default, nearest).flatten().collect()
}

/// Returns the excess and the gap of each refined query, and the checks of both searches; `None` if
/// `go_on` returns `false`. Queries that time may have cut short are left out.
fn compare(
    context: &Context,
    asked: &[f64],
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(Vec<[f64; 2]>, usize)> {
    let space = &context.checker.scene().space;
    let (mut found, mut checks, mut asked) = (Vec::new(), 0, asked);
    // Blocks start small, since the checks of a query differ a hundredfold from scene to scene.
    let mut size = 1;
    while !asked.is_empty() && checks < extent.checks {
        let (block, rest) = asked.split_at(asked.len().min(size * space.nq()));
        (asked, size) = (rest, QUERIES_PER_BATCH.min(2 * size));
        let left = extent.until.map(|until| until.saturating_duration_since(Instant::now()));
        if !go_on() {
            return None;
        }
        if left == Some(Duration::ZERO) {
            break;
        }
        let termination =
            Termination { max_checks: Some(LONG_CHECKS), max_seconds: left.map(|left| left.as_secs_f64()), stop: None };
        let rows: Vec<(Option<[f64; 2]>, usize)> = block
            .par_chunks_exact(space.nq())
            .with_max_len(1)
            .map_init(QueryScratch::default, |scratch, q| {
                // A drawn configuration keeps the limits but for rounding, which this corrects.
                space.config(q).map_or((None, 0), |q| compare_one(context, &q, &termination, scratch))
            })
            .collect();
        if extent.is_over() {
            break;
        }
        checks += rows.iter().map(|(_, checks)| checks).sum::<usize>();
        found.extend(rows.iter().filter_map(|(figures, _)| *figures));
    }
    Some((found, checks))
}

fn compare_one(
    context: &Context,
    q: &Config,
    termination: &Termination,
    scratch: &mut QueryScratch,
) -> (Option<[f64; 2]>, usize) {
    let refined = QueryOptions { termination: termination.clone(), ..QueryOptions::default() };
    let longer = QueryOptions { effort: Effort::Exhaustive, starts: Some(LONG_STARTS), ..refined.clone() };
    let answers = [refined, longer].map(|options| query(context, q, &options, scratch));
    let [Some(refined), Some(longer)] = answers else { return (None, 0) };
    let checks = refined.checks + longer.checks;
    // A free configuration has nothing to compare.
    let figures = || [refined.depth / refined.depth.min(longer.depth) - 1.0, refined.gap];
    ((longer.depth > 0.0).then(figures), checks)
}

#[cfg(test)]
pub(crate) mod tests;

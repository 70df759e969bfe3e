//! What a model measures of itself, on colliding configurations that nothing was learned from.

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

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Seed of what is held out.
    pub seed: u64,
    /// Most configurations that are labelled to find colliding ones.
    pub draws: usize,
    /// Most colliding configurations that are queried.
    pub queries: usize,
    /// Checks after which no further one is queried.
    pub checks: usize,
    /// When to stop; what is found then depends on the machine.
    pub until: Option<Instant>,
}

/// Queries that are compared, if the labels allow it.
const QUERIES: usize = 64;
/// So many labels of learning pay for one check of measuring, which costs some times as much: a
/// part of the time.
const LABELS_A_CHECK: usize = 4;
/// Labels below which nothing is queried: they would pay for a query or two, which say nothing.
const LEAST_LABELS: usize = 10_000;
/// So many labels pay for one configuration that is labelled to be held out.
const LABELS_A_DRAW: usize = 4;
/// Most configurations that are labelled.
const MOST_DRAWS: usize = 4096;

impl Extent {
    /// After learning with `labels`.
    pub fn after(labels: usize, seed: u64) -> Self {
        let draws = (labels / LABELS_A_DRAW).min(MOST_DRAWS);
        let queries = if labels < LEAST_LABELS { 0 } else { QUERIES };
        Self { seed, draws, queries, checks: labels / LABELS_A_CHECK, until: None }
    }

    fn is_over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }
}

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct Evaluation {
    /// Of the samples; `None` where nothing held out collides.
    pub density: Option<Density>,
    /// Of such queries; `None` where none was asked.
    pub excess: Option<Excess>,
    /// Of the same queries.
    pub gap: Option<Gap>,
    /// Collision and distance evaluations spent, labels of what was held out included.
    pub checks: usize,
}

/// Colliding ones that suffice.
const ENOUGH: usize = 1500;
/// Boundary samples whose nearest neighbours are looked at.
const SPACED: usize = 500;
/// Configurations drawn, and queries asked, between two looks at the clock.
const DRAWN_AT_ONCE: usize = 512;
const ASKED_AT_ONCE: usize = 16;
/// Starts of the longer search, half of them around the query: it takes about ten times the checks
/// of a refined query.
const LONG_STARTS: usize = 48;
/// Most checks of the longer search: some ten times what it takes, lest one query take minutes.
const LONG_CHECKS: usize = 20_000;

/// Turns the seed of learning into another.
const HELD_OUT: u64 = u64::from_be_bytes(*b"held-out");

/// Measures samples and queries on held-out configurations; `go_on` is asked now and then, `None`
/// where it says no.
///
/// # Guarantee
/// Without a time to stop at, the result depends on context and extent alone, not on the number of
/// threads.
pub fn measure(
    prepared: &Prepared,
    samples: &SampleSet,
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<Evaluation> {
    let (context, nq) = (&prepared.with(Some(Stored { samples, holding: None })), samples.nq());
    let (colliding, mut checks) = held_out(context, extent, go_on)?;
    let reaches = nearest_others(prepared.metric(), samples, &colliding, 1);
    let spacings = nearest_others(prepared.metric(), samples, &evenly(samples.configs(), nq, SPACED), 2);
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

/// Uniform colliding configurations, row major, and the labels that they took.
fn held_out(context: &Context, extent: &Extent, go_on: &mut dyn FnMut() -> bool) -> Option<(Vec<f64>, usize)> {
    let (space, mut rng) = (&context.checker.scene().space, ChaCha8Rng::seed_from_u64(extent.seed ^ HELD_OUT));
    let (nq, mut colliding, mut drawn) = (space.nq(), Vec::new(), 0);
    while drawn < extent.draws && colliding.len() < ENOUGH * nq && !extent.is_over() {
        if !go_on() {
            return None;
        }
        let mut configs = vec![0.0; DRAWN_AT_ONCE.min(extent.draws - drawn) * nq];
        configs.chunks_exact_mut(nq).for_each(|q| uniform(space, &mut rng, q));
        let mut labels = vec![Label::Free; configs.len() / nq];
        context.checker.label_batch(&configs, &mut labels);
        drawn += labels.len();
        let rows = configs.chunks_exact(nq).zip(labels);
        colliding.extend(rows.filter(|(_, label)| *label == Label::Colliding).flat_map(|(q, _)| q.iter().copied()));
    }
    colliding.truncate(ENOUGH * nq);
    Some((colliding, drawn))
}

/// At most `count` rows, the same number apart.
fn evenly(rows: &[f64], nq: usize, count: usize) -> Vec<f64> {
    let step = (rows.len() / nq).div_ceil(count).max(1);
    rows.chunks_exact(nq).step_by(step).flatten().copied().collect()
}

/// Distance of every configuration to the boundary sample that is its `count`-th nearest: where
/// they are samples themselves, each is its own first.
fn nearest_others(metric: &Metric, samples: &SampleSet, configs: &[f64], count: usize) -> Vec<f64> {
    let nearest = |(anchor, scratch, found): &mut (Anchor, BoundaryScratch, Vec<(u32, f64)>), q: &[f64]| {
        metric.anchor(q, anchor);
        // If two samples are at one place, either may come first.
        samples.nearest(SampleQuery::NEAREST, metric, anchor, count, scratch, found);
        found.last().map(|(_, distance)| *distance)
    };
    configs.par_chunks_exact(samples.nq()).map_init(Default::default, nearest).flatten().collect()
}

/// How much farther than a longer search refined queries end and their gaps, and the checks of
/// both; `None` if `go_on` says no. What time may have cut short is left out.
fn compare(
    context: &Context,
    asked: &[f64],
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(Vec<[f64; 2]>, usize)> {
    let space = &context.checker.scene().space;
    let (mut found, mut checks, mut asked) = (Vec::new(), 0, asked);
    // Few at first: how many checks one takes differs by a hundred times from scene to scene.
    let mut size = 1;
    while !asked.is_empty() && checks < extent.checks {
        let (block, rest) = asked.split_at(asked.len().min(size * space.nq()));
        (asked, size) = (rest, ASKED_AT_ONCE.min(2 * size));
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
                // A configuration that was drawn keeps the limits but for rounding, which this
                // mends.
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
    // Of a free one there is nothing to compare.
    let figures = || [refined.depth / refined.depth.min(longer.depth) - 1.0, refined.gap];
    ((longer.depth > 0.0).then(figures), checks)
}

#[cfg(test)]
pub(crate) mod tests;

//! What a model measures of itself, on colliding configurations that nothing was learned from.

pub mod budget;
pub mod calibrate;
pub mod figures;

use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::cspace::sampling::uniform;
use crate::cspace::{Config, Label};
use crate::metric::Anchor;
use crate::query::report::coverage::Coverage;
use crate::query::{
    Context, Effort, Learned, QueryOptions, QueryScratch, StartsPerDof, Termination, begins_with, query,
};
use crate::samples::{BoundaryScratch, SampleQuery};
pub use budget::EvaluationBudget;
use calibrate::{calibrate, unmeasured};
use figures::{Density, Excess, Gap, percentile};

/// What was found.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Of the samples; `None` where nothing held out collides.
    pub density: Option<Density>,
    /// Starts of a refined query for each degree of freedom.
    pub starts: StartsPerDof,
    /// Of such queries; `None` where none was asked.
    pub excess: Option<Excess>,
    /// Of the same queries.
    pub gap: Option<Gap>,
    /// To compare queries with.
    pub coverage: Coverage,
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

impl Default for Evaluation {
    /// Nothing was measured.
    fn default() -> Self {
        Self { density: None, starts: unmeasured(), excess: None, gap: None, coverage: Coverage::default(), checks: 0 }
    }
}

/// Turns the seed of learning into another.
const HELD_OUT: u64 = u64::from_be_bytes(*b"held-out");

/// Measures samples and queries on held-out configurations; `go_on` is asked now and then, `None`
/// where it says no.
///
/// # Guarantee
/// Without a time to stop at, the result depends on context and extent alone, not on the number of
/// threads.
pub fn measure(context: &Context, extent: &EvaluationBudget, go_on: &mut dyn FnMut() -> bool) -> Option<Evaluation> {
    let nq = context.checker.scene().space.nq();
    let (colliding, mut checks) = held_out(context, extent, go_on)?;
    let reaches = nearest_others(context, &colliding, 1, SampleQuery::NEAREST);
    let spacings = nearest_others(context, &evenly(context.samples().configs(), nq, SPACED), 2, SampleQuery::NEAREST);
    // As refined queries see them; others look among more samples.
    let coverage = Coverage::new(nearest_others(context, &colliding, 1, begins_with(context)));
    let density = (!reaches.is_empty()).then(|| Density {
        spacing_median: percentile(&spacings, 0.5),
        spacing_p95: percentile(&spacings, 0.95),
        reach_median: percentile(&reaches, 0.5),
        reach_p95: percentile(&reaches, 0.95),
    });
    let (asked, others) = colliding.split_at(colliding.len().min(extent.queries * nq));
    let mut stopped = false;
    let mut hopeful = || {
        stopped = stopped || !go_on();
        !stopped
    };
    // What a figure is chosen by makes it look better than it is: the excess is measured on others.
    let (starts, spent) = calibrate(context, others, extent, &mut hopeful);
    checks += spent;
    let (compared, spent) =
        compare(&Context { learned: Learned { starts, ..context.learned }, ..*context }, asked, extent, &mut |_| {
            hopeful()
        });
    checks += spent;
    if stopped {
        return None;
    }
    let [excesses, gaps] = [0, 1].map(|k| compared.iter().map(|figures| figures[k]).collect::<Vec<f64>>());
    Some(Evaluation { density, starts, excess: Excess::of(&excesses), gap: Gap::of(&gaps), coverage, checks })
}

/// The starts alone, and the evaluations that it took.
pub fn measure_starts(
    context: &Context,
    extent: &EvaluationBudget,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(StartsPerDof, usize)> {
    let nq = context.checker.scene().space.nq();
    let (colliding, drawn) = held_out(context, extent, go_on)?;
    let (_, others) = colliding.split_at(colliding.len().min(extent.queries * nq));
    let (starts, checks) = calibrate(context, others, extent, go_on);
    Some((starts, drawn + checks))
}

/// Whether at least 95 % of held-out queries have an excess of at most `target`, and the checks
/// that it took to tell; `None` where `go_on` said no. Not where fewer than `extent.queries`
/// collide among what is drawn.
pub fn is_within(
    context: &Context,
    target: f64,
    extent: &EvaluationBudget,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(bool, usize)> {
    let nq = context.checker.scene().space.nq();
    let (colliding, checks) = held_out(context, extent, go_on)?;
    if colliding.len() < extent.queries * nq {
        return Some((false, checks));
    }
    let beyond = |found: &[[f64; 2]]| found.iter().filter(|[excess, _]| *excess > target).count();
    let allowed = extent.queries / 20;
    let mut stopped = false;
    let mut hopeful = |found: &[[f64; 2]]| {
        stopped = stopped || !go_on();
        !stopped && beyond(found) <= allowed
    };
    let asked = &colliding[..extent.queries * nq];
    let (found, spent) = compare(context, asked, extent, &mut hopeful);
    // Fewer were given up or cut short by the clock: not shown to be within.
    let within = found.len() == extent.queries && beyond(&found) <= allowed;
    (!stopped).then_some((within, checks + spent))
}

/// Uniform colliding configurations, row major, and the labels that they took.
fn held_out(
    context: &Context,
    extent: &EvaluationBudget,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(Vec<f64>, usize)> {
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
fn nearest_others(context: &Context, configs: &[f64], count: usize, wanted: SampleQuery) -> Vec<f64> {
    let nearest = |(anchor, scratch, found): &mut (Anchor, BoundaryScratch, Vec<(u32, f64)>), q: &[f64]| {
        context.metric.anchor(q, anchor);
        // Of two samples at one place either may come first.
        context.samples().nearest(wanted, context.metric, anchor, count, scratch, found);
        found.last().map(|(_, distance)| *distance)
    };
    let nq = context.checker.scene().space.nq();
    configs.par_chunks_exact(nq).map_init(Default::default, nearest).flatten().collect()
}

/// How much farther than a longer search refined queries end and their gaps, and the checks of
/// both. `go_on` sees what was found so far and may end it. Where time runs out, what it may have
/// cut short is left out.
fn compare(
    context: &Context,
    asked: &[f64],
    extent: &EvaluationBudget,
    go_on: &mut dyn FnMut(&[[f64; 2]]) -> bool,
) -> (Vec<[f64; 2]>, usize) {
    let space = &context.checker.scene().space;
    let (mut found, mut checks, mut asked) = (Vec::new(), 0, asked);
    // Knn at first: how many checks one takes differs by a hundred times from scene to scene.
    let mut size = 1;
    while !asked.is_empty() && checks < extent.checks {
        let (block, rest) = asked.split_at(asked.len().min(size * space.nq()));
        (asked, size) = (rest, ASKED_AT_ONCE.min(2 * size));
        let left = extent.until.map(|until| until.saturating_duration_since(Instant::now()));
        if left == Some(Duration::ZERO) || !go_on(&found) {
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
    (found, checks)
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

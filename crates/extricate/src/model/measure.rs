//! What a model measures of itself, on colliding configurations that nothing was learned from.

use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::calibrate::{calibrate, unmeasured};
use super::quality::{Density, Excess, Gap, percentile};
use crate::boundary::{BoundaryScratch, Wanted};
use crate::cspace::sampling::uniform;
use crate::cspace::{Config, Label};
use crate::metric::Anchor;
use crate::penetration::coverage::Coverage;
use crate::penetration::{
    Context, Effort, Learned, QueryBudget, QueryOptions, QueryScratch, StartsPerDof, begins_with, query,
};

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Seed of what is held out.
    pub seed: u64,
    /// Most configurations that are labelled to find colliding ones.
    pub draws: usize,
    /// Most colliding configurations that are asked.
    pub queries: usize,
    /// Checks after which no further one is asked.
    pub checks: usize,
    /// When to stop; what is found then depends on the machine.
    pub until: Option<Instant>,
    /// Starts for each degree of freedom as far as they are known before.
    pub known: Option<StartsPerDof>,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Measured {
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

/// Queries that are compared, where labels allow it.
const QUERIES: usize = 64;
/// So many labels of learning pay for one check of measuring, which costs some times as much: a part of the time.
const LABELS_A_CHECK: usize = 4;
/// Labels below which nothing is asked: they would pay for a query or two, which say nothing.
const LEAST_LABELS: usize = 10_000;
/// So many labels pay for one configuration that is labelled to be held out.
const LABELS_A_DRAW: usize = 4;
/// Most of them.
const MOST_DRAWS: usize = 4096;
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

impl Default for Measured {
    /// Nothing was measured.
    fn default() -> Self {
        Self { density: None, starts: unmeasured(), excess: None, gap: None, coverage: Coverage::default(), checks: 0 }
    }
}

impl Extent {
    /// After learning with `labels`.
    pub fn after(labels: usize, seed: u64) -> Self {
        let draws = (labels / LABELS_A_DRAW).min(MOST_DRAWS);
        let queries = if labels < LEAST_LABELS { 0 } else { QUERIES };
        Self { seed, draws, queries, checks: labels / LABELS_A_CHECK, until: None, known: None }
    }

    /// All that is ever measured, however few the labels.
    pub fn in_full(seed: u64) -> Self {
        Self { seed, draws: MOST_DRAWS, queries: QUERIES, checks: usize::MAX, until: None, known: None }
    }

    /// What a run that may end by its quality looks at. Not what the model is measured on in the end: a run that ends when a
    /// figure is good makes that figure look better than it is.
    pub fn for_stopping(seed: u64) -> Self {
        Self::in_full(seed ^ LOOKS)
    }

    pub(super) fn is_over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }
}

/// Turn the seed of learning into others.
const HELD_OUT: u64 = u64::from_be_bytes(*b"held-out");
const LOOKS: u64 = u64::from_be_bytes(*b"  looked");

/// Measures samples and queries on held-out configurations; `go_on` is asked now and then, `None`
/// where it says no.
///
/// # Guarantee
/// Without a time to stop at, the result depends on context and extent alone, not on the number of
/// threads.
pub fn measure(context: &Context, extent: &Extent, go_on: &mut dyn FnMut() -> bool) -> Option<Measured> {
    let nq = context.checker.scene().space.nq();
    let (colliding, mut checks) = held_out(context, extent, go_on)?;
    let reaches = nearest_others(context, &colliding, 1, Wanted::NEAREST);
    let spacings = nearest_others(context, &evenly(context.samples().configs(), nq, SPACED), 2, Wanted::NEAREST);
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
    Some(Measured { density, starts, excess: Excess::of(&excesses), gap: Gap::of(&gaps), coverage, checks })
}

/// The starts alone, and the evaluations that it took.
pub fn measure_starts(
    context: &Context,
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<(StartsPerDof, usize)> {
    let nq = context.checker.scene().space.nq();
    let (colliding, drawn) = held_out(context, extent, go_on)?;
    let (_, others) = colliding.split_at(colliding.len().min(extent.queries * nq));
    let (starts, checks) = calibrate(context, others, extent, go_on);
    Some((starts, drawn + checks))
}

/// Whether at least 95 % of held-out queries have an excess of at most `target`, and the checks that it took to tell; `None` where
/// `go_on` said no. Not where fewer than `extent.queries` collide among what is drawn.
pub fn is_within(
    context: &Context,
    target: f64,
    extent: &Extent,
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

/// Distance of every configuration to the boundary sample that is its `count`-th nearest: where they are samples themselves, each is its own first.
fn nearest_others(context: &Context, configs: &[f64], count: usize, wanted: Wanted) -> Vec<f64> {
    let nearest = |(anchor, scratch, found): &mut (Anchor, BoundaryScratch, Vec<(u32, f64)>), q: &[f64]| {
        context.metric.anchor(q, anchor);
        // Of two samples at one place either may come first.
        context.samples().nearest(wanted, context.metric, anchor, count, scratch, found);
        found.last().map(|(_, distance)| *distance)
    };
    let nq = context.checker.scene().space.nq();
    configs.par_chunks_exact(nq).map_init(Default::default, nearest).flatten().collect()
}

/// How much farther than a longer search refined queries end and their gaps, and the checks of both. `go_on` sees what was found so far and
/// may end it. Where time runs out, what it
/// may have cut short is left out.
fn compare(
    context: &Context,
    asked: &[f64],
    extent: &Extent,
    go_on: &mut dyn FnMut(&[[f64; 2]]) -> bool,
) -> (Vec<[f64; 2]>, usize) {
    let space = &context.checker.scene().space;
    let (mut found, mut checks, mut asked) = (Vec::new(), 0, asked);
    // Few at first: how many checks one takes differs by a hundred times from scene to scene.
    let mut size = 1;
    while !asked.is_empty() && checks < extent.checks {
        let (block, rest) = asked.split_at(asked.len().min(size * space.nq()));
        (asked, size) = (rest, ASKED_AT_ONCE.min(2 * size));
        let left = extent.until.map(|until| until.saturating_duration_since(Instant::now()));
        if left == Some(Duration::ZERO) || !go_on(&found) {
            break;
        }
        let budget = QueryBudget { checks: Some(LONG_CHECKS), seconds: left.map(|left| left.as_secs_f64()) };
        let rows: Vec<(Option<[f64; 2]>, usize)> = block
            .par_chunks_exact(space.nq())
            .with_max_len(1)
            .map_init(QueryScratch::default, |scratch, q| {
                // A configuration that was drawn keeps the limits but for rounding, which this mends.
                space.config(q).map_or((None, 0), |q| compare_one(context, &q, budget, scratch))
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
    budget: QueryBudget,
    scratch: &mut QueryScratch,
) -> (Option<[f64; 2]>, usize) {
    let refined = QueryOptions { budget, ..QueryOptions::default() };
    let longer = QueryOptions { effort: Effort::Exhaustive, starts: Some(LONG_STARTS), budget, ..refined.clone() };
    let answers = [refined, longer].map(|options| query(context, q, &options, scratch));
    let [Some(refined), Some(longer)] = answers else { return (None, 0) };
    let checks = refined.checks + longer.checks;
    // Of a free one there is nothing to compare.
    let figures = || [refined.depth / refined.depth.min(longer.depth) - 1.0, refined.gap];
    ((longer.depth > 0.0).then(figures), checks)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::boundary::Among;
    use crate::collision::Checker;
    use crate::learning::LearnOptions;
    use crate::metric::Metric;
    use crate::model::{Model, Statistics};
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn learned(labels: usize) -> Model {
        let options = LearnOptions { labels, seconds: None, seed: 2, ..LearnOptions::default() };
        Model::learn(builtin::scene("planar-arm").unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    /// Uniform colliding configurations that nothing else uses.
    pub fn colliding(model: &Model, count: usize) -> Vec<Config> {
        let space = &model.scene().space;
        let (mut rng, mut q) = (ChaCha8Rng::seed_from_u64(4711), vec![0.0; space.nq()]);
        let all = std::iter::repeat_with(|| {
            uniform(space, &mut rng, &mut q);
            space.config(&q).unwrap()
        });
        all.filter(|q| model.checker().label(q, &mut Default::default()) == Label::Colliding).take(count).collect()
    }

    #[test]
    fn figures_hold_for_configurations_that_were_not_measured() {
        let model = learned(60_000);
        let found = model.statistics();
        let (density, excess) = (found.density.unwrap(), found.excess.unwrap());
        let options = QueryOptions { effort: Effort::Nearest, ..QueryOptions::default() };
        let mut scratch = QueryScratch::default();
        let answers: Vec<_> =
            colliding(&model, 2000).iter().map(|q| model.query(q, &options, &mut scratch).unwrap()).collect();
        let share = |of: &dyn Fn(&crate::penetration::Answer) -> bool| {
            answers.iter().filter(|answer| of(answer)).count() as f64 / answers.len() as f64
        };
        for (reach, expected) in [(density.reach_median, 0.5), (density.reach_p95, 0.95)] {
            let nearer = share(&|answer| answer.depth <= reach);
            assert!((nearer - expected).abs() < 0.07, "{nearer} {expected}");
        }
        for level in [0.02, 0.1, 0.5] {
            let low = share(&|answer| answer.coverage.unwrap() <= level);
            assert!((low - level).abs() < 0.07, "{low} {level}");
        }
        assert!(share(&|answer| answer.is_far()) < 0.03);
        assert!(0.0 < density.spacing_median && density.spacing_median <= density.spacing_p95);
        assert!(excess.queries >= 8 && 0.0 <= excess.median && excess.median <= excess.p95, "{excess:?}");
        assert!(excess.within_5pct > 0.8, "{excess:?}");
        let gap = found.gap.unwrap();
        assert!(gap.queries == excess.queries && 0.0 < gap.median && gap.median <= gap.p95 && gap.p95 < 1.0, "{gap:?}");
        let [low, high] = found.accuracy_free_interval.unwrap();
        assert!(low < found.accuracy_free.unwrap() && found.accuracy_free.unwrap() < high && high - low < 0.1);
        assert!(found.measuring_checks > 1000 && found.measuring_checks < 60_000, "{}", found.measuring_checks);
    }

    #[test]
    fn coverage_holds_for_queries_that_begin_at_exits() {
        let model = learned(700_000);
        assert_eq!(begins_with(&model.context()).among, Among::Exits, "{}", model.boundary().exits());
        let mut scratch = QueryScratch::default();
        let queries = colliding(&model, 2000);
        let coverages: Vec<f64> = queries
            .iter()
            .map(|q| model.query(q, &QueryOptions::default(), &mut scratch).unwrap().coverage.unwrap())
            .collect();
        for level in [0.02, 0.1, 0.5] {
            let low = coverages.iter().filter(|coverage| **coverage <= level).count() as f64 / 2000.0;
            assert!((low - level).abs() < 0.05, "{low} {level}");
        }
    }

    #[test]
    fn what_was_not_learned_is_called_far() {
        let model = learned(40_000);
        let nq = model.scene().space.nq();
        // Where the first joint points away from the first cylinder there are no samples any more.
        let seen = |q: &[f64]| q[0].abs() < 1.5;
        let rows = model.boundary().configs().chunks_exact(nq).filter(|q| seen(q)).flatten().copied().collect();
        let scene = model.checker().scene_arc().clone();
        let (coverage, statistics) = (model.coverage().clone(), Statistics { exits: 0, ..model.statistics().clone() });
        let holed =
            Model::from_parts(Checker::new(scene.clone()), Metric::new(scene), rows, None, coverage, statistics);
        let (mut scratch, mut far, mut all) = (QueryScratch::default(), [0; 2], [0; 2]);
        for q in colliding(&model, 400).iter().filter(|q| !(1.0..2.5).contains(&q[0].abs())) {
            let side = usize::from(seen(q));
            all[side] += 1;
            far[side] += usize::from(holed.query(q, &QueryOptions::default(), &mut scratch).unwrap().is_far());
        }
        assert!(far[0] * 10 > all[0] * 9 && far[1] * 20 < all[1], "{far:?} of {all:?}");
    }

    #[test]
    fn a_caller_that_says_no_gets_nothing() {
        let model = learned(12_000);
        for most in [0, 1, 3, 9] {
            let mut asked = 0;
            let mut go_on = || {
                asked += 1;
                asked <= most
            };
            assert!(measure(&model.context(), &Extent::in_full(1), &mut go_on).is_none(), "{most}");
        }
        let over = Extent { until: Some(Instant::now()), ..Extent::in_full(1) };
        let found = measure(&model.context(), &over, &mut || true).unwrap();
        assert_eq!((found.density, found.excess, found.gap, found.checks), (None, None, None, 0));
    }
}

//! Solving: the nearest exits of colliding configurations, found while learning and kept as starts.
//!
//! Descents from where others ended end at the nearest exit more often than those from where the
//! boundary was met by chance: half as many starts are enough. While exits are few, the other exits
//! that descents met are kept too: they cost two labels each instead of some dozens, and lead out
//! of other configurations.

pub mod near_miss;
pub mod policy;
pub mod recombine;

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evaluate::calibrate::unmeasured;
use crate::collision::Checker;
use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Label};
use crate::learning::exploration::{BATCH, Exploration};
use crate::learning::{Budget, LabelBatch};
use crate::metric::Metric;
use crate::query::bound::inner_spheres::InnerBalls;
use crate::query::report::coverage::Coverage;
use crate::query::{Context, Learned, QueryOptions, QueryScratch, Termination, index_samples, nearest_exit};
use crate::samples::SampleSet;
use policy::{LEAST_CHECKS, Solving};

/// What solving stands on.
pub struct SolveGround<'a> {
    /// Of the scene.
    pub checker: &'a Checker,
    /// Of the scene.
    pub metric: &'a Metric,
    /// Of the scene; proves nothing here.
    pub balls: &'a InnerBalls,
    /// Of nothing: what is solved needs none.
    pub no_coverage: &'a Coverage,
    /// Where configurations come from.
    pub halton: &'a Halton,
    /// Every exit gets a colliding configuration within this distance (metric units).
    pub gap: f64,
    /// For the index.
    pub seed: u64,
    /// How.
    pub solving: Solving,
}

/// How far solving has come.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SolvePlace {
    /// Colliding configurations solved, or given up.
    pub seeds_used: usize,
    /// Exits found: the last of the samples.
    pub exits: usize,
    /// The first so many of them were starts of the last pass.
    pub indexed: usize,
}

/// Configurations solved in the first pass; each later one takes twice as many, up to [`MOST`].
const FIRST: usize = 64;
/// Most in one pass: a few seconds where queries are slow.
const MOST: usize = 1024;
/// Solved between two reports.
const BETWEEN_REPORTS: usize = 64;
/// Solved by one thread at a time: few, so that none is left with the last, and enough to fill its
/// memory for.
const SOLVED_A_TASK: usize = 4;
/// Checks kept from a query: what tells whether its exits are free and beside a collision, and what
/// it may overdraw.
const CHECKS_AFTER: usize = 12;
/// While so many exits are known, other exits become exits too. With fewer, a model that is about
/// to rely on exits would do so with half as many nearest ones; with more, they change nothing.
const KEEPS_OTHERS: std::ops::Range<usize> = 256..16_384;

/// Starts of a query that solves sparingly: three to four times as many exits for as many labels.
const SPARING_STARTS: usize = 6;

/// How many configurations the next pass solves, where so many are known.
fn wanted(place: &SolvePlace) -> usize {
    place.seeds_used.clamp(FIRST, MOST)
}

impl SolveGround<'_> {
    /// A pass, from colliding configurations of `known` and, where those run out, further ones.
    /// `samples` are traced ones, then exits as `place` counts them, to which new ones are
    /// appended; `indexed` is kept between passes. Whether another pass could be paid for.
    pub fn pass(
        &self,
        known: &mut Exploration,
        samples: &mut Vec<f64>,
        place: &mut SolvePlace,
        indexed: &mut Option<SampleSet>,
        label: &LabelBatch,
        budget: &mut Budget,
    ) -> bool {
        let space = &self.checker.scene().space;
        let nq = space.nq();
        let missing = (place.seeds_used + wanted(place)).saturating_sub(known.colliding.len() / nq);
        if missing > 0 {
            let (free, more) = (known.free.len(), missing.max(BATCH).min(budget.left() / 4));
            known.extend(space, self.halton, more, label, budget);
            known.free.truncate(free);
        }
        // Told by the counts alone, so that a resumed run does the same. The look at all of them
        // has to leave something for solving.
        if 2 * place.indexed <= place.exits && 2 * place.exits <= budget.left() {
            place.indexed = place.exits;
            *indexed = None;
            // A look at the contacts of each.
            budget.spend(place.indexed);
        }
        // The traced samples, and the first exits.
        let rows = samples.len() / nq - place.exits + place.indexed;
        let boundary = indexed.get_or_insert_with(|| {
            index_samples(self.checker, self.metric, samples[..rows * nq].to_vec(), place.indexed, self.seed)
        });
        let learned = Learned { boundary, coverage: self.no_coverage, starts: unmeasured() };
        let ground = Context::new((self.checker, self.metric, self.balls), learned, None);
        let before = place.seeds_used;
        solve_next(&ground, (self.gap, self.solving), known, samples, place, budget) && place.seeds_used > before
    }
}

/// Solves the next colliding configurations of `known`, and appends the exits that are new to
/// `samples`; whether another pass could be paid for.
///
/// `ground` holds the samples as they were indexed. A query takes the checks that it needs, but not
/// more than leave the others of its batch with as many.
///
/// # Guarantee
/// Every exit was labelled free, and the configuration within `gap` of it toward the one that was
/// solved was labelled colliding.
fn solve_next(
    ground: &Context,
    (gap, solving): (f64, Solving),
    known: &Exploration,
    samples: &mut Vec<f64>,
    place: &mut SolvePlace,
    budget: &mut Budget,
) -> bool {
    let nq = ground.checker.scene().space.nq();
    let until = (place.seeds_used + wanted(place)).min(known.colliding.len() / nq);
    let exits = samples[samples.len() - place.exits * nq..].chunks_exact(nq);
    let mut kept: HashSet<u64> = exits.map(fingerprint).collect();
    while place.seeds_used < until && budget.end().is_none() {
        let rows = (until - place.seeds_used).min(BETWEEN_REPORTS).min(budget.left() / LEAST_CHECKS);
        if rows == 0 {
            return false;
        }
        let checks = budget.left() / rows - CHECKS_AFTER;
        let seeds = &known.colliding[place.seeds_used * nq..(place.seeds_used + rows) * nq];
        let keeps_others = match solving {
            Solving::Thorough => KEEPS_OTHERS.contains(&place.exits),
            Solving::Sparing => true,
        };
        let starts = Some(if solving == Solving::Sparing { SPARING_STARTS } else { ground.checker.scene().space.nv() });
        let task = Task { ground, gap, checks, until: budget.until(), keeps_others, starts };
        let found: Vec<(Vec<f64>, usize)> = seeds
            .par_chunks_exact(nq)
            .with_max_len(SOLVED_A_TASK)
            .map_init(QueryScratch::default, |scratch, seed| task.solve(seed, scratch))
            .collect();
        for exit in found.iter().flat_map(|(exits, _)| exits.chunks_exact(nq)) {
            if kept.insert(fingerprint(exit)) {
                samples.extend_from_slice(exit);
                place.exits += 1;
            }
        }
        place.seeds_used += rows;
        budget.note(samples.len() / nq, None);
        budget.spend(found.iter().map(|(_, checks)| checks).sum());
    }
    budget.left() >= LEAST_CHECKS
}

/// Tells equal exits: where limits and obstacles leave a corner, the exits of many configurations
/// end in it.
fn fingerprint(exit: &[f64]) -> u64 {
    let mut hasher = DefaultHasher::new();
    exit.iter().for_each(|x| hasher.write_u64(x.to_bits()));
    hasher.finish()
}

/// What is done with every configuration of a batch.
struct Task<'a> {
    ground: &'a Context<'a>,
    gap: f64,
    /// Most checks of one.
    checks: usize,
    /// Where the time of the run ends: a query along dense meshes may take seconds.
    until: Option<Instant>,
    /// Whether other exits than the nearest are kept.
    keeps_others: bool,
    /// Of each query, where not as many as it takes.
    starts: Option<usize>,
}

impl Task<'_> {
    /// The exits of one configuration, row major, nearest first, and the checks that they took;
    /// none of a query that time cut short.
    fn solve(&self, seed: &[f64], scratch: &mut QueryScratch) -> (Vec<f64>, usize) {
        let space = &self.ground.checker.scene().space;
        let left = || self.until.map(|until| until.saturating_duration_since(Instant::now()).as_secs_f64());
        let Some(q) = space.config(seed).ok().filter(|_| left() != Some(0.0)) else { return (Vec::new(), 0) };
        let termination = Termination { max_checks: Some(self.checks), max_seconds: left(), stop: None };
        let options = QueryOptions { termination, starts: self.starts, ..QueryOptions::default() };
        let answer = nearest_exit(self.ground, &q, &options, scratch).filter(|_| left() != Some(0.0));
        let Some(answer) = answer else { return (Vec::new(), scratch.checks()) };
        let mut exits = Vec::new();
        if answer.verified && self.is_beside_collision(&answer.witness, answer.depth, &q, scratch) {
            exits.extend_from_slice(&answer.witness);
        }
        if self.keeps_others {
            for (depth, other) in scratch.other_exits(space, &answer) {
                let is_free = scratch.label(self.ground, &other) == Label::Free;
                if is_free && self.is_beside_collision(&other, depth, &q, scratch) {
                    exits.extend_from_slice(&other);
                }
            }
        }
        (exits, scratch.checks())
    }

    /// Whether the configuration within the gap of an exit, toward `q` at its depth, collides.
    fn is_beside_collision(&self, exit: &[f64], depth: f64, q: &Config, scratch: &mut QueryScratch) -> bool {
        let space = &self.ground.checker.scene().space;
        let mut beyond = vec![0.0; space.nq()];
        space.interpolate(exit, q, (0.9 * self.gap / depth).min(1.0), &mut beyond);
        depth > 0.0 && scratch.label(self.ground, &beyond) == Label::Colliding
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::collision::{Checker, ContactQuery, ContactSearch};
    use crate::learning::LearnOptions;
    use crate::metric::Anchor;
    use crate::model::evaluate::tests::colliding;
    use crate::model::{Model, Statistics};
    use crate::samples::{BoundaryScratch, SampleKind, SampleQuery};
    use crate::scene::builtin;

    /// Enough for twice the exits that queries rely on.
    const LABELS: usize = 150_000;

    /// Of convex bodies and distances of joints, where exits replace other starts.
    fn learned() -> Model {
        let options = LearnOptions { labels: LABELS, seconds: None, seed: 5, ..LearnOptions::default() };
        Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap()
    }

    /// The model as it is put together again from what is stored of it, with other statistics.
    fn stored(model: &Model, statistics: Statistics) -> Model {
        let scene = model.checker().scene_arc().clone();
        let (coverage, rows) = (model.coverage().clone(), model.boundary().configs().to_vec());
        Model::from_parts(Checker::new(scene.clone()), Metric::new(scene), rows, None, coverage, statistics)
    }

    #[test]
    fn a_stored_model_answers_as_the_learned_one() {
        let learned = learned();
        let stored = stored(&learned, learned.statistics().clone());
        for q in colliding(&learned, 100) {
            let [a, b] = [&learned, &stored].map(|model| {
                model.view().query_with(&q, &QueryOptions::default(), &mut QueryScratch::default()).unwrap()
            });
            assert_eq!((a.witness, a.lower_bound, a.checks), (b.witness, b.lower_bound, b.checks));
        }
    }

    #[test]
    fn exits_are_free_beside_a_collision_and_the_nearest_are_found() {
        let model = learned();
        let (set, nq) = (model.boundary(), model.scene().space.nq());
        assert!(set.solved() > 50 && set.solved() == model.statistics().solved_samples, "{}", set.solved());
        assert!(model.statistics().labels <= LABELS);
        let gap = model.statistics().boundary_gap.unwrap();
        let first = set.len() - set.solved();
        for exit in set.configs()[first * nq..].chunks_exact(nq) {
            assert_eq!(model.checker().label(exit, &mut Default::default()), Label::Free);
            // Some direction within the gap collides: that toward what was solved, which is not
            // kept.
            let (mut scratch, mut contacts) = (Default::default(), Vec::new());
            let margin = model.metric().lever() * gap;
            let query = ContactQuery { margin, search: ContactSearch::Exact };
            model.checker().contacts(exit, query, &mut scratch, &mut contacts);
            assert!(!contacts.is_empty());
        }
        let (mut scratch, mut found, mut anchor) = (BoundaryScratch::default(), Vec::new(), Anchor::default());
        for q in set.configs().chunks_exact(nq).step_by(97).take(40) {
            model.metric().anchor(q, &mut anchor);
            set.nearest(
                SampleQuery { among: SampleKind::Solved, ..SampleQuery::NEAREST },
                model.metric(),
                &anchor,
                5,
                &mut scratch,
                &mut found,
            );
            let mut all: Vec<f64> =
                set.configs()[first * nq..].chunks_exact(nq).map(|e| model.metric().distance(q, e)).collect();
            all.sort_by(f64::total_cmp);
            assert!(found.iter().zip(&all).all(|((id, d), e)| (d - e).abs() < 1e-9 && *id as usize >= first));
            assert_eq!(found.len(), 5);
        }
    }

    #[test]
    fn other_ways_out_are_exits_too_while_they_are_few() {
        let model = learned();
        let ground = model.context();
        let gap = model.statistics().boundary_gap.unwrap();
        let [nearest, all] = [false, true].map(|keeps_others| Task {
            ground: &ground,
            gap,
            checks: usize::MAX,
            until: None,
            keeps_others,
            starts: None,
        });
        let (mut scratch, mut others) = (QueryScratch::default(), 0);
        for q in colliding(&model, 100) {
            let nq = q.len();
            let (one, few) = nearest.solve(&q, &mut scratch);
            let (several, more) = all.solve(&q, &mut scratch);
            assert!(several.starts_with(&one) && one.len() <= nq && several.len() <= one.len() + 4 * nq);
            assert!(more <= few + 8);
            let depth = |exit: &[f64]| model.metric().distance(&q, exit);
            for exit in several[one.len()..].chunks_exact(nq) {
                others += 1;
                assert_eq!(model.checker().label(exit, &mut Default::default()), Label::Free);
                assert!(one.is_empty() || depth(exit) > 0.999 * depth(&one), "{} {}", depth(exit), depth(&one));
                assert!(one.is_empty() || model.metric().distance(&one, exit) > 0.2 * depth(&one));
            }
        }
        assert!(others > 10, "{others}");
        // Where time is over, nothing is begun.
        let over = Task { until: Some(Instant::now()), ..all };
        assert_eq!(over.solve(&colliding(&model, 1)[0], &mut scratch), (Vec::new(), 0));
    }

    #[test]
    fn exits_make_queries_shorter_and_their_answers_no_worse() {
        // Without exits they take two thirds of the checks that they took before they began with
        // separating directions.
        assert_shorter(&learned(), 0.75);
    }

    /// A floating box, whose metric is the object norm: it takes more labels until there are exits
    /// to rely on.
    #[test]
    fn exits_make_queries_under_the_object_norm_shorter_too() {
        let options = LearnOptions { labels: 4 * LABELS, seconds: None, seed: 5, ..LearnOptions::default() };
        let scene = builtin::scene("free-box").unwrap();
        let model = Model::learn(scene, &options).unwrap();
        assert!(model.statistics().solved_samples > 256, "{}", model.statistics().solved_samples);
        // As above: without exits they take a ninth of the checks that they once took.
        assert_shorter(&model, 0.9);
    }

    /// With exits queries take so large a share of the checks at most, and find as much.
    fn assert_shorter(model: &Model, share: f64) {
        let without = stored(model, Statistics { solved_samples: 0, ..model.statistics().clone() });
        let (mut scratch, mut checks, mut beyond) = (QueryScratch::default(), [0; 2], [0; 2]);
        let queries = colliding(model, 200);
        for q in &queries {
            let [a, b] = [model, &without]
                .map(|model| model.view().query_with(q, &QueryOptions::default(), &mut scratch).unwrap());
            checks = [checks[0] + a.checks, checks[1] + b.checks];
            let least = a.depth.min(b.depth);
            beyond = [beyond[0] + usize::from(a.depth > 1.01 * least), beyond[1] + usize::from(b.depth > 1.01 * least)];
        }
        println!("checks {checks:?}, more than 1 % beyond the other {beyond:?} of {}", queries.len());
        assert!((checks[0] as f64) < share * checks[1] as f64, "{checks:?}");
        assert!(beyond[0] <= beyond[1] + 4, "{beyond:?}");
    }
}

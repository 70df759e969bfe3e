//! Solving: finds exits of colliding configurations during learning. They are stored with their
//! contact planes, as starts of queries.
//!
//! Descents from earlier exits reach the nearest exit more often than descents from traced samples.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::time::Instant;

use rayon::prelude::*;

use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Label};
use crate::learning::Budget;
use crate::learning::exploration::{BATCH, Exploration};
use crate::query::prepared::Prepared;
use crate::query::{Context, Effort, QueryOptions, QueryScratch, Termination, nearest_exit_under};

/// A query does not begin with fewer checks than this, since it could not finish.
const MIN_QUERY_CHECKS: usize = 200;
const CONFIGS_PER_REPORT: usize = 64;
/// Configurations that one parallel task solves: few, so that no thread is left alone with the last
/// task, but enough to pay for filling its memory.
const CONFIGS_PER_TASK: usize = 4;
/// Checks withheld from a query: for the test beside its exit, and for what it may overdraw.
const RESERVED_CHECKS: usize = 12;

/// Solves the colliding configurations of `known` in their order, then further ones that `halton`
/// draws, until the budget ends. Appends the exits to `samples` and returns their number.
///
/// A query takes the checks that it needs, at most an equal share of what its batch has left.
///
/// # Guarantee
/// Every exit was labelled free. The configuration within `gap` of it, toward the one that was
/// solved, was labelled colliding.
pub fn solve(
    prepared: &Prepared,
    gap: f64,
    halton: &Halton,
    known: &mut Exploration,
    samples: &mut Vec<f64>,
    budget: &mut Budget,
) -> usize {
    let (space, context) = (&prepared.scene().space, prepared.context());
    let (nq, before) = (space.nq(), samples.len());
    let label = |configs: &[f64]| {
        let mut labels = vec![Label::Free; configs.len() / nq];
        prepared.checker().label_batch(configs, &mut labels);
        labels
    };
    let (mut kept, mut solved) = (HashSet::new(), 0);
    if budget.end().is_none() {
        budget.stage("solving");
    }
    while budget.end().is_none() {
        let seeds = &known.colliding[solved * nq..];
        if seeds.is_empty() {
            let free = known.free.len();
            known.extend(space, halton, BATCH, &label, budget);
            known.free.truncate(free);
            continue;
        }
        let rows = (seeds.len() / nq).min(CONFIGS_PER_REPORT).min(budget.left() / MIN_QUERY_CHECKS);
        if rows == 0 {
            break;
        }
        let task =
            Task { context: &context, gap, checks: budget.left() / rows - RESERVED_CHECKS, until: budget.until() };
        let found: Vec<(Option<Vec<f64>>, usize)> = seeds[..rows * nq]
            .par_chunks_exact(nq)
            .with_max_len(CONFIGS_PER_TASK)
            .map_init(QueryScratch::default, |scratch, seed| task.solve(seed, scratch))
            .collect();
        for exit in found.iter().filter_map(|(exit, _)| exit.as_ref()) {
            if kept.insert(fingerprint(exit)) {
                samples.extend_from_slice(exit);
            }
        }
        solved += rows;
        budget.note(samples.len() / nq, None);
        budget.spend(found.iter().map(|(_, checks)| checks).sum());
    }
    (samples.len() - before) / nq
}

/// Identifies equal exits: many configurations end in the same corner of limits and obstacles.
fn fingerprint(exit: &[f64]) -> u64 {
    let mut hasher = DefaultHasher::new();
    exit.iter().for_each(|x| hasher.write_u64(x.to_bits()));
    hasher.finish()
}

/// The inputs that all queries of a batch share.
struct Task<'a> {
    context: &'a Context<'a>,
    gap: f64,
    /// Most checks of one query.
    checks: usize,
    /// End of the time for learning: a query along dense meshes may take seconds.
    until: Option<Instant>,
}

impl Task<'_> {
    /// Returns the exit of one configuration and the checks that it took. The exit is `None` if
    /// time cut the query short, or if nothing collides right beside it.
    fn solve(&self, seed: &[f64], scratch: &mut QueryScratch) -> (Option<Vec<f64>>, usize) {
        let space = &self.context.checker.scene().space;
        let left = || self.until.map(|until| until.saturating_duration_since(Instant::now()).as_secs_f64());
        let Some(q) = space.config(seed).ok().filter(|_| left() != Some(0.0)) else { return (None, 0) };
        let termination = Termination { max_checks: Some(self.checks), max_seconds: left(), stop: None };
        let options = QueryOptions { effort: Effort::Quick, termination, ..QueryOptions::default() };
        let answer = nearest_exit_under(self.context, &q, &options, true, scratch);
        let answer = answer.filter(|answer| answer.depth > 0.0 && left() != Some(0.0));
        let Some(answer) = answer else { return (None, scratch.checks()) };
        let is_exit = answer.verified && self.is_beside_collision(&answer.witness, answer.depth, &q, scratch);
        (is_exit.then(|| answer.witness.into()), scratch.checks())
    }

    /// Whether the configuration within the gap of an exit, toward `q` at distance `depth`,
    /// collides.
    fn is_beside_collision(&self, exit: &[f64], depth: f64, q: &Config, scratch: &mut QueryScratch) -> bool {
        let space = &self.context.checker.scene().space;
        let mut beyond = vec![0.0; space.nq()];
        space.interpolate(exit, q, (0.9 * self.gap / depth).min(1.0), &mut beyond);
        depth > 0.0 && scratch.label(self.context, &beyond) == Label::Colliding
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{Checker, ContactQuery, ContactSearch};
    use crate::learning::LearnOptions;
    use crate::metric::{Anchor, Metric};
    use crate::model::evaluate::tests::of_model;
    use crate::model::{Model, Statistics};
    use crate::query::prepared::tests::colliding;
    use crate::query::query;
    use crate::samples::{BoundaryScratch, SampleKind, SampleQuery};
    use crate::scene::builtin;

    /// Enough for twice the solved samples that queries require.
    const LABELS: usize = 150_000;

    /// Learns a model of convex bodies under the joint metric.
    fn learned() -> Model {
        let options = LearnOptions { labels: LABELS, seconds: None, seed: 5, ..LearnOptions::default() };
        Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap()
    }

    /// Builds the model again from its stored samples, with other statistics.
    fn stored(model: &Model, statistics: Statistics) -> Model {
        let scene = model.scene().clone();
        let rows = model.boundary().configs().to_vec();
        Model::from_parts(Checker::new(scene.clone()), Metric::new(scene), rows, None, statistics)
    }

    #[test]
    fn a_stored_model_answers_as_the_learned_one() {
        let learned = learned();
        let stored = stored(&learned, learned.statistics().clone());
        for q in colliding(learned.prepared(), 100) {
            let [a, b] = [&learned, &stored].map(|model| {
                query(&of_model(model), &q, &QueryOptions::default(), &mut QueryScratch::default()).unwrap()
            });
            assert_eq!((a.witness, a.lower_bound, a.checks), (b.witness, b.lower_bound, b.checks));
        }
    }

    #[test]
    fn exits_are_free_beside_a_collision_and_the_nearest_are_found() {
        let model = learned();
        let (set, nq) = (model.boundary(), model.scene().space.nq());
        let (checker, metric) = (model.prepared().checker(), model.prepared().metric());
        assert!(set.solved() > 50 && set.solved() == model.statistics().solved_samples, "{}", set.solved());
        assert!(model.statistics().labels <= LABELS);
        let gap = model.statistics().boundary_gap.unwrap();
        let first = set.len() - set.solved();
        for exit in set.configs()[first * nq..].chunks_exact(nq) {
            assert_eq!(checker.label(exit, &mut Default::default()), Label::Free);
            // Within the gap, the direction toward the solved configuration collides. That
            // direction is not stored, so the test requires only some contact.
            let (mut scratch, mut contacts) = (Default::default(), Vec::new());
            let margin = metric.lever() * gap;
            let query = ContactQuery { margin, search: ContactSearch::Exact };
            checker.contacts(exit, query, &mut scratch, &mut contacts);
            assert!(!contacts.is_empty());
        }
        let (mut scratch, mut found, mut anchor) = (BoundaryScratch::default(), Vec::new(), Anchor::default());
        for q in set.configs().chunks_exact(nq).step_by(97).take(40) {
            metric.anchor(q, &mut anchor);
            set.nearest(
                SampleQuery { among: SampleKind::Solved, ..SampleQuery::NEAREST },
                metric,
                &anchor,
                5,
                &mut scratch,
                &mut found,
            );
            let mut all: Vec<f64> =
                set.configs()[first * nq..].chunks_exact(nq).map(|e| metric.distance(q, e)).collect();
            all.sort_by(f64::total_cmp);
            assert!(found.iter().zip(&all).all(|((id, d), e)| (d - e).abs() < 1e-9 && *id as usize >= first));
            assert_eq!(found.len(), 5);
        }
    }

    #[test]
    fn nothing_is_begun_after_the_time_is_over() {
        let prepared = Prepared::new(builtin::scene("planar-arm").unwrap());
        let (context, space) = (prepared.context(), &prepared.scene().space);
        let halton = Halton::new(space.nv(), 7);
        let mut configs = vec![0.0; 20 * space.nq()];
        configs.chunks_exact_mut(space.nq()).enumerate().for_each(|(at, q)| halton.config(space, at as u64, q));
        let found = |until| {
            let task = Task { context: &context, gap: 1e-3, checks: usize::MAX, until };
            let solved = configs.chunks_exact(space.nq()).map(|q| task.solve(q, &mut QueryScratch::default()));
            solved.fold((0, 0), |(exits, checks), (exit, spent)| (exits + usize::from(exit.is_some()), checks + spent))
        };
        assert!(found(None).0 > 2);
        assert_eq!(found(Some(Instant::now())), (0, 0));
    }

    /// A model only adds a few starts. Hardly any answer is farther than without it, as another
    /// start along the same contacts may end first, and few checks are added.
    #[test]
    fn a_model_makes_no_answer_farther() {
        for name in ["planar-arm", "shelf-arm", "free-box", "four-legs"] {
            let options = LearnOptions { labels: LABELS, seconds: None, seed: 5, ..LearnOptions::default() };
            let model = Model::learn(builtin::scene(name).unwrap(), &options).unwrap();
            let (mut scratch, mut checks, mut farther) = (QueryScratch::default(), [0; 2], 0);
            let (contexts, queries) =
                ([of_model(&model), model.prepared().context()], colliding(model.prepared(), 200));
            for q in &queries {
                let [with, without] =
                    [0, 1].map(|which| query(&contexts[which], q, &QueryOptions::default(), &mut scratch).unwrap());
                assert!(with.depth <= 1.05 * without.depth, "{name}: {} {}", with.depth, without.depth);
                farther += usize::from(with.depth > 1.01 * without.depth);
                checks = [checks[0] + with.checks, checks[1] + without.checks];
            }
            println!("{name}: {checks:?} checks of {} queries, {farther} farther", queries.len());
            assert!(farther <= 1, "{name}: {farther}");
            assert!(10 * checks[0] < 11 * checks[1] + 20 * queries.len(), "{name}: {checks:?}");
        }
    }
}

//! Measures a model for its report: colliding queries with one budget after another, and the pairs
//! that touch at boundary samples.

use std::collections::BTreeMap;
use std::sync::Arc;

use extricate::{Answer, CheckScratch, Effort, Model, PairId, QueryOptions, Solver, TOUCHING};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::termination;
use crate::commands::draw_colliding;
use crate::progress::busy;
use crate::report::quantile;

/// Budgets of the queries, in checks.
const CHECK_BUDGETS: [usize; 8] = [12, 25, 50, 100, 200, 400, 800, 1600];
/// Largest number of boundary samples at which touching pairs are determined.
const MAX_SAMPLES: usize = 2000;
/// Largest ratio of a near answer's depth to the best depth.
const NEAR_RATIO: f64 = 1.05;
/// Changes the seed, so that no query is a configuration that the model was learned from.
const QUERY_SEED_MASK: u64 = 0x72_65_70_6f_72_74;

#[derive(Debug, Serialize)]
pub struct Measured {
    /// Number of queries: random configurations in collision.
    pub queries: usize,
    /// Quality with each budget, the smallest first.
    pub budgets: Vec<Quality>,
    /// Quality without a budget.
    pub refined: Quality,
    /// Depths of refined answers, in the metric.
    pub depths: Vec<f64>,
    /// Proved share of each depth.
    pub proved: Vec<f64>,
    /// Pairs, and the number of boundary samples at which each touches, the most frequent first.
    pub touching: Vec<([String; 2], usize)>,
    /// Number of boundary samples that `touching` is based on.
    pub samples: usize,
}

/// Comparison of answers with the best that any search found.
#[derive(Debug, Serialize)]
pub struct Quality {
    /// Median number of checks per query.
    pub checks: f64,
    /// Share of answers within 5 % of the best.
    pub within_5pct: f64,
    /// 95th percentile of `depth / depth of the best - 1`.
    pub excess_p95: f64,
}

/// Measures `count` queries of a model.
///
/// # Errors
/// Fails if no configuration in collision is found.
pub fn measure(model: &Arc<Model>, count: usize, seed: u64) -> anyhow::Result<Measured> {
    let solver = Solver::of_model(Arc::clone(model));
    let queries = draw_colliding(&solver, count, seed ^ QUERY_SEED_MASK)?;
    let ask = |effort, max_checks| -> extricate::Result<Vec<Option<Answer>>> {
        let options = QueryOptions::default().effort(effort).termination(termination(max_checks, None));
        let solver = solver.clone().options(options)?;
        Ok(queries.par_iter().map(|q| solver.query(q)).collect())
    };
    let (refined, limited, exhaustive) = busy("asking the model", || {
        let limited = CHECK_BUDGETS.iter().map(|checks| ask(Effort::Refined, Some(*checks)));
        let limited = limited.collect::<extricate::Result<Vec<_>>>()?;
        extricate::Result::Ok((ask(Effort::Refined, None)?, limited, ask(Effort::Exhaustive, None)?))
    })?;
    let best: Vec<f64> = (0..queries.len())
        .map(|at| {
            limited
                .iter()
                .chain([&refined, &exhaustive])
                .map(|answers| depth(&answers[at]))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let (touching, samples) = busy("looking where samples touch", || touching(&solver, model));
    let found = || refined.iter().flatten();
    Ok(Measured {
        queries: queries.len(),
        budgets: limited.iter().map(|answers| quality(answers, &best)).collect(),
        depths: found().map(|answer| answer.depth).collect(),
        proved: found().map(|answer| answer.lower_bound / answer.depth).collect(),
        refined: quality(&refined, &best),
        touching,
        samples,
    })
}

fn depth(answer: &Option<Answer>) -> f64 {
    answer.as_ref().map_or(f64::INFINITY, |answer| answer.depth)
}

fn quality(answers: &[Option<Answer>], best: &[f64]) -> Quality {
    let near = answers.iter().zip(best).filter(|(answer, best)| depth(answer) <= NEAR_RATIO * *best).count();
    let mut checks: Vec<f64> = answers.iter().flatten().map(|answer| answer.checks as f64).collect();
    let mut excess: Vec<f64> = answers.iter().zip(best).map(|(answer, best)| depth(answer) / best - 1.0).collect();
    Quality {
        checks: quantile(&mut checks, 0.5),
        within_5pct: near as f64 / answers.len().max(1) as f64,
        excess_p95: quantile(&mut excess, 0.95),
    }
}

/// Counts the pairs that touch at boundary samples, which are spread evenly over all samples.
fn touching(solver: &Solver, model: &Model) -> (Vec<([String; 2], usize)>, usize) {
    let (checker, scene, samples) = (solver.checker(), solver.scene(), model.boundary());
    let step = samples.len().div_ceil(MAX_SAMPLES).max(1);
    let configs: Vec<&[f64]> = samples.configs().chunks_exact(scene.space().nq()).step_by(step).collect();
    let of = |scratch: &mut CheckScratch, q: &&[f64]| {
        let mut contacts = Vec::new();
        checker.contacts_within(q, scene.clearance() + TOUCHING, scratch, &mut contacts);
        let mut pairs: Vec<usize> = contacts.iter().map(|contact| contact.pair.index()).collect();
        pairs.dedup();
        pairs
    };
    let found: Vec<Vec<usize>> = configs.par_iter().map_init(CheckScratch::default, of).collect();
    let mut counts = BTreeMap::new();
    found.iter().flatten().for_each(|pair| *counts.entry(*pair).or_insert(0) += 1);
    let named = |(pair, count): (usize, usize)| (scene.pair_names(PairId::new(pair)).map(String::from), count);
    let mut named: Vec<_> = counts.into_iter().map(named).collect();
    named.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    (named, configs.len())
}

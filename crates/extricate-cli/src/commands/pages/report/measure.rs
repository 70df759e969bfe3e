//! What a report measures: queries of random configurations in collision, with one budget after
//! the other, and where boundary samples touch.

use std::collections::BTreeMap;
use std::sync::Arc;

use extricate::{Answer, CheckScratch, Effort, Model, PairId, QueryOptions, Solver, TOUCHING};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::termination;
use crate::commands::draw_colliding;
use crate::progress::busy;
use crate::report::quantile;

/// Budgets that are tried, in checks.
const BUDGETS: [usize; 8] = [12, 25, 50, 100, 200, 400, 800, 1600];
/// Boundary samples of which it is told where they touch, most.
const MOST_SAMPLES: usize = 2000;
/// An answer is near that is farther than the best by at most this share.
const NEAR: f64 = 1.05;
/// Turns the seed into another one, so that no query is a configuration that was learned from.
const QUERY_STREAM: u64 = 0x72_65_70_6f_72_74;

/// Figures of a report.
#[derive(Debug, Serialize)]
pub struct Measured {
    /// Random configurations in collision that were asked.
    pub queries: usize,
    /// The quality with each budget, the least first.
    pub budgets: Vec<Quality>,
    /// The quality without a budget.
    pub refined: Quality,
    /// The depths of refined answers, in the metric.
    pub depths: Vec<f64>,
    /// The share of each depth that is proved.
    pub proved: Vec<f64>,
    /// How many boundary samples touch with a pair, the most frequent first.
    pub touching: Vec<([String; 2], usize)>,
    /// Boundary samples that were tried for it.
    pub samples: usize,
}

/// How near answers are to the best that was found.
#[derive(Debug, Serialize)]
pub struct Quality {
    /// Median of the checks of a query.
    pub checks: f64,
    /// Share of answers within 5 % of the best.
    pub within_5pct: f64,
    /// 95th percentile of `depth / depth of the best - 1`.
    pub excess_p95: f64,
}

/// Measures `count` queries of a model.
///
/// # Errors
/// Where no configuration in collision is found.
pub fn measure(model: &Arc<Model>, count: usize, seed: u64) -> anyhow::Result<Measured> {
    let solver = Solver::of_model(Arc::clone(model));
    let queries = draw_colliding(&solver, count, seed ^ QUERY_STREAM)?;
    let ask = |effort, max_checks| -> extricate::Result<Vec<Option<Answer>>> {
        let options = QueryOptions::default().effort(effort).termination(termination(max_checks, None));
        let solver = solver.clone().options(options)?;
        Ok(queries.par_iter().map(|q| solver.query(q)).collect())
    };
    let (refined, limited, exhaustive) = busy("asking the model", || {
        let limited = BUDGETS.iter().map(|checks| ask(Effort::Refined, Some(*checks)));
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
    let near = answers.iter().zip(best).filter(|(answer, best)| depth(answer) <= NEAR * *best).count();
    let mut checks: Vec<f64> = answers.iter().flatten().map(|answer| answer.checks as f64).collect();
    let mut excess: Vec<f64> = answers.iter().zip(best).map(|(answer, best)| depth(answer) / best - 1.0).collect();
    Quality {
        checks: quantile(&mut checks, 0.5),
        within_5pct: near as f64 / answers.len().max(1) as f64,
        excess_p95: quantile(&mut excess, 0.95),
    }
}

/// Pairs that touch at boundary samples, spread evenly over all of them.
fn touching(solver: &Solver, model: &Model) -> (Vec<([String; 2], usize)>, usize) {
    let (checker, scene, samples) = (solver.checker(), solver.scene(), model.boundary());
    let step = samples.len().div_ceil(MOST_SAMPLES).max(1);
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

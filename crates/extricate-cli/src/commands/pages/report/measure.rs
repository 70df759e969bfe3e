//! What a report measures: queries of random configurations in collision, with one budget after
//! the other, and where boundary samples touch.

use std::collections::BTreeMap;

use extricate::internals::collision::contacts_within;
use extricate::internals::query::answer::TOUCHING;
use extricate::{Answer, CheckScratch, Config, Effort, Model, QueryOptions, QueryScratch, Termination};
use rayon::prelude::*;
use serde::Serialize;

use crate::commands::sample::CollidingSampler;
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
    /// By budget, the least first.
    pub budgets: Vec<Quality>,
    /// Without a budget.
    pub refined: Quality,
    /// Of refined answers, in the metric.
    pub depths: Vec<f64>,
    /// Of each, the share of the depth that is proved.
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
pub fn measure(model: &Model, count: usize, seed: u64) -> anyhow::Result<Measured> {
    let space = &model.scene().space;
    let mut sampler = CollidingSampler::new(model.checker(), seed ^ QUERY_STREAM);
    let mut q = vec![0.0; space.nq()];
    let mut next = |_| {
        sampler.next(&mut q, |_, _| {})?;
        Ok(space.config(&q)?)
    };
    let queries =
        busy("drawing configurations", || (0..count).map(&mut next).collect::<anyhow::Result<Vec<Config>>>())?;
    let ask = |effort, max_checks| -> Vec<Option<Answer>> {
        let termination = Termination { max_checks, ..Termination::default() };
        let options = QueryOptions { effort, termination, ..QueryOptions::default() };
        let one = |scratch: &mut QueryScratch, q: &Config| model.view().query_with(q, &options, scratch);
        queries.par_iter().map_init(QueryScratch::default, one).collect()
    };
    let (refined, limited, exhaustive) = busy("asking the model", || {
        let limited: Vec<_> = BUDGETS.iter().map(|checks| ask(Effort::Refined, Some(*checks))).collect();
        (ask(Effort::Refined, None), limited, ask(Effort::Exhaustive, None))
    });
    let best: Vec<f64> = (0..queries.len())
        .map(|at| {
            limited
                .iter()
                .chain([&refined, &exhaustive])
                .map(|answers| depth(&answers[at]))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let (touching, samples) = busy("looking where samples touch", || touching(model));
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
fn touching(model: &Model) -> (Vec<([String; 2], usize)>, usize) {
    let (checker, scene, samples) = (model.checker(), model.scene(), model.boundary());
    let step = samples.len().div_ceil(MOST_SAMPLES).max(1);
    let configs: Vec<&[f64]> = samples.configs().chunks_exact(scene.space.nq()).step_by(step).collect();
    let of = |scratch: &mut CheckScratch, q: &&[f64]| {
        let mut contacts = Vec::new();
        contacts_within(checker, q, scene.clearance + TOUCHING, scratch, &mut contacts);
        let mut pairs: Vec<usize> = contacts.iter().map(|contact| contact.pair.index()).collect();
        pairs.dedup();
        pairs
    };
    let found: Vec<Vec<usize>> = configs.par_iter().map_init(CheckScratch::default, of).collect();
    let mut counts = BTreeMap::new();
    found.iter().flatten().for_each(|pair| *counts.entry(*pair).or_insert(0) += 1);
    let named =
        |(pair, count): (usize, usize)| (scene.pair_names(extricate::PairId::new(pair)).map(String::from), count);
    let mut named: Vec<_> = counts.into_iter().map(named).collect();
    named.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    (named, configs.len())
}

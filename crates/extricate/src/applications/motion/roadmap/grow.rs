//! Grows a roadmap in batches: draws and joins configurations on all threads, with a result that
//! does not depend on their number.

use rayon::prelude::*;

use super::grower::{Grower, NEIGHBOURS};
use super::islands::{Trees, grow_trees, islands, take_trees};
use super::samplers::{Drawn, draw};
use super::yields::{SAMPLERS, Sampler, shares};
use crate::applications::motion::prover::Prover;
use crate::query::QueryScratch;

/// Maximum configurations of one sampler in a batch: only the next batch knows what it found.
const MAX_DRAWS_PER_SAMPLER: usize = 2048;

/// Jobs that run in parallel before the rest of the budget is counted again.
const PARALLEL_JOBS: usize = 64;
/// Checks that drawing a configuration takes at most, about; no budget limits them. If little is
/// left, fewer jobs run in parallel.
const CHECKS_PER_DRAW: usize = 100;

/// Result of one job of a batch.
enum JobResult {
    /// A drawn configuration, and the old nodes that it can be joined to.
    Node(Drawn, Vec<usize>),
    /// Trees between an island and its surroundings.
    Trees(Option<Trees>),
}

/// Grows by one batch of about `checks` checks, and no more than are left. If the caller or a time
/// limit stops it early, less is drawn, and the result depends on when.
pub fn grow(grower: &mut Grower, checks: usize) {
    let islands = islands(grower);
    let jobs = jobs(grower, checks, !islands.is_empty());
    let until = grower.left.saturating_sub(checks);
    let mut found: Vec<(JobResult, usize)> = Vec::with_capacity(jobs.len());
    while found.len() < jobs.len() && grower.left > until && !grower.is_spent() {
        let most = PARALLEL_JOBS.min(1 + grower.left / CHECKS_PER_DRAW);
        let some = &jobs[found.len()..][..most.min(jobs.len() - found.len())];
        let (this, first) = (&*grower, grower.roadmap.drawn);
        // Each job has a share of its own, so that the result does not depend on the others.
        let share = this.left.div_ceil(some.len());
        let find = |(memory, prover): &mut (QueryScratch, Prover), (at, sampler): (usize, &usize)| {
            let (limited, before) = (prover.limited(share), prover.checks);
            let (sampler, index) = (SAMPLERS[*sampler], first + at as u64);
            let (found, drawn) = find(this, (sampler, index), &islands, memory, prover);
            prover.unlimit(limited);
            (found, drawn + prover.checks - before)
        };
        let scratch = || (QueryScratch::default(), this.job_prover());
        let more: Vec<(JobResult, usize)> = some.par_iter().enumerate().map_init(scratch, find).collect();
        grower.roadmap.drawn += some.len() as u64;
        grower.spend(more.iter().map(|(_, checks)| checks).sum());
        found.extend(more);
    }
    take(grower, &jobs, found);
}

/// Runs one job; returns its result and the checks that drawing took.
fn find(
    grower: &Grower,
    (sampler, index): (Sampler, u64),
    islands: &[Vec<usize>],
    memory: &mut QueryScratch,
    prover: &mut Prover,
) -> (JobResult, usize) {
    if prover.is_spent() {
        return (JobResult::Trees(None), 0);
    }
    if sampler == Sampler::Trees {
        return (JobResult::Trees(grow_trees(grower, islands, index, prover)), 0);
    }
    let drawn = draw(sampler, index, grower.roadmap, &grower.context, memory);
    let old = |q: &Vec<f64>| grower.joinable(q, &grower.nodes.near(q, NEIGHBOURS), prover);
    let neighbours = drawn.config.as_ref().map_or(Vec::new(), old);
    let checks = drawn.checks;
    (JobResult::Node(drawn, neighbours), checks)
}

/// Returns the samplers of a batch of `checks` checks, by index. Draws of each are spread evenly
/// over the batch, so that one that ends early has drawn from all.
fn jobs(grower: &Grower, checks: usize, has_islands: bool) -> Vec<usize> {
    let has_samples = grower.context.query.stored.is_some();
    let is_of_use = |sampler: Sampler| match sampler {
        Sampler::Stored => has_samples,
        Sampler::Around => !grower.roadmap.narrow.is_empty(),
        Sampler::Trees => has_islands,
        _ => true,
    };
    let yields = &grower.roadmap.yields;
    let counts = shares(yields, is_of_use).into_iter().zip(yields).map(|(share, of)| {
        let count = (share * checks as f64 / of.cost()).ceil() as usize;
        count.min(MAX_DRAWS_PER_SAMPLER)
    });
    let place = |at: usize, count: usize| (at as f64 + 0.5) / count as f64;
    let placed = counts.enumerate().flat_map(|(sampler, n)| (0..n).map(move |at| (place(at, n), sampler)));
    let mut placed: Vec<(f64, usize)> = placed.collect();
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    placed.into_iter().map(|(_, sampler)| sampler).collect()
}

/// Adds the results of a batch. Nodes that join no old one are tried with the other new ones.
fn take(grower: &mut Grower, jobs: &[usize], found: Vec<(JobResult, usize)>) {
    let old = grower.nodes.len();
    let mut new = Vec::new();
    for (sampler, (found, checks)) in jobs.iter().zip(found) {
        let of = &mut grower.roadmap.yields[*sampler];
        (of.drawn, of.checks) = (of.drawn + 1, of.checks + checks as u64);
        match found {
            JobResult::Node(Drawn { config: Some(q), .. }, neighbours) => {
                new.push((*sampler, grower.push(&q), neighbours));
            }
            JobResult::Trees(Some(trees)) => {
                let is_useful = take_trees(grower, trees);
                grower.roadmap.yields[*sampler].useful += u64::from(is_useful);
            }
            JobResult::Node(..) | JobResult::Trees(None) => {}
        }
    }
    let this = &*grower;
    let share = this.left.div_ceil(new.len().max(1));
    let among_new = |prover: &mut Prover, (_, node, neighbours): &(usize, usize, Vec<usize>)| {
        if !neighbours.is_empty() {
            return (Vec::new(), 0);
        }
        let limited = prover.limited(share);
        let (q, before) = (this.nodes.config(*node), prover.checks);
        let near = this.nodes.near(q, NEIGHBOURS);
        let near: Vec<usize> = near.into_iter().filter(|other| *other >= old && other != node).collect();
        let joinable = this.joinable(q, &near, prover);
        prover.unlimit(limited);
        (joinable, prover.checks - before)
    };
    let more: Vec<(Vec<usize>, usize)> = new.par_iter().map_init(|| this.job_prover(), among_new).collect();
    for ((sampler, node, neighbours), (others, checks)) in new.into_iter().zip(more) {
        grower.spend(checks);
        grower.roadmap.yields[sampler].checks += checks as u64;
        let joins = grower.join(node, &neighbours) + grower.join(node, &others);
        if joins != 1 {
            grower.roadmap.yields[sampler].useful += 1;
            grower.roadmap.narrow.push(node as u32);
        }
    }
}

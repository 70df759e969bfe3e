//! Batches: configurations are drawn and joined on all threads, in an order that does not depend on
//! them.

use rayon::prelude::*;

use super::grower::{Grower, NEIGHBOURS};
use super::islands::{Trees, grow_trees, islands, take_trees};
use super::samplers::{Drawn, draw};
use super::yields::{SAMPLERS, Sampler, shares};
use crate::applications::motion::prover::Prover;
use crate::query::QueryScratch;

/// Most configurations of one sampler in a batch: what a batch finds is known to the next one only.
const MOST: usize = 2048;

/// Jobs that run side by side before what is left is counted again.
const TOGETHER: usize = 64;
/// Checks that drawing a configuration takes at most, about, which nothing limits: fewer run side
/// by side if little is left.
const CHECKS_OF_A_DRAW: usize = 100;

/// What one job of a batch found.
enum Found {
    /// A configuration, and the old nodes that it can be joined to.
    Node(Drawn, Vec<usize>),
    /// Trees between an island and others.
    Trees(Option<Trees>),
}

/// One batch of about so many checks, and of no more than are left. Ends early where the caller
/// stops it, or time does: then less is drawn, and what is drawn depends on when.
pub fn grow(grower: &mut Grower, checks: usize) {
    let islands = islands(grower);
    let jobs = jobs(grower, checks, !islands.is_empty());
    let until = grower.left.saturating_sub(checks);
    let mut found: Vec<(Found, usize)> = Vec::with_capacity(jobs.len());
    while found.len() < jobs.len() && grower.left > until && !grower.is_spent() {
        let most = TOGETHER.min(1 + grower.left / CHECKS_OF_A_DRAW);
        let some = &jobs[found.len()..][..most.min(jobs.len() - found.len())];
        let (this, first) = (&*grower, grower.roadmap.drawn);
        // What each may spend does not depend on what the others do at the same time.
        let share = this.left.div_ceil(some.len());
        let find = |(memory, prover): &mut (QueryScratch, Prover), (at, sampler): (usize, &usize)| {
            let (limited, before) = (prover.limited(share), prover.checks);
            let (sampler, index) = (SAMPLERS[*sampler], first + at as u64);
            let (found, drawn) = find(this, (sampler, index), &islands, memory, prover);
            prover.unlimit(limited);
            (found, drawn + prover.checks - before)
        };
        let scratch = || (QueryScratch::default(), this.job_prover());
        let more: Vec<(Found, usize)> = some.par_iter().enumerate().map_init(scratch, find).collect();
        grower.roadmap.drawn += some.len() as u64;
        grower.spend(more.iter().map(|(_, checks)| checks).sum());
        found.extend(more);
    }
    take(grower, &jobs, found);
}

/// What one job finds, and the checks that drawing took.
fn find(
    grower: &Grower,
    (sampler, index): (Sampler, u64),
    islands: &[Vec<usize>],
    memory: &mut QueryScratch,
    prover: &mut Prover,
) -> (Found, usize) {
    if prover.is_spent() {
        return (Found::Trees(None), 0);
    }
    if sampler == Sampler::Trees {
        return (Found::Trees(grow_trees(grower, islands, index, prover)), 0);
    }
    let drawn = draw(sampler, index, grower.roadmap, &grower.context, memory);
    let old = |q: &Vec<f64>| grower.joinable(q, &grower.nodes.near(q, NEIGHBOURS), prover);
    let neighbours = drawn.config.as_ref().map_or(Vec::new(), old);
    let checks = drawn.checks;
    (Found::Node(drawn, neighbours), checks)
}

/// Samplers of a batch of so many checks, by index; those of each are spread evenly over it, so
/// that a batch that ends early has drawn of all.
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
        count.min(MOST)
    });
    let place = |at: usize, count: usize| (at as f64 + 0.5) / count as f64;
    let placed = counts.enumerate().flat_map(|(sampler, n)| (0..n).map(move |at| (place(at, n), sampler)));
    let mut placed: Vec<(f64, usize)> = placed.collect();
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    placed.into_iter().map(|(_, sampler)| sampler).collect()
}

/// Adds what a batch found. What cannot be joined to what was there is tried with what else is
/// new.
fn take(grower: &mut Grower, jobs: &[usize], found: Vec<(Found, usize)>) {
    let old = grower.nodes.len();
    let mut new = Vec::new();
    for (sampler, (found, checks)) in jobs.iter().zip(found) {
        let of = &mut grower.roadmap.yields[*sampler];
        (of.drawn, of.checks) = (of.drawn + 1, of.checks + checks as u64);
        match found {
            Found::Node(Drawn { config: Some(q), .. }, neighbours) => {
                new.push((*sampler, grower.push(&q), neighbours));
            }
            Found::Trees(Some(trees)) => {
                let is_useful = take_trees(grower, trees);
                grower.roadmap.yields[*sampler].useful += u64::from(is_useful);
            }
            Found::Node(..) | Found::Trees(None) => {}
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

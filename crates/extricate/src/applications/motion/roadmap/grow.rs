//! Batches: configurations are drawn and joined on all threads, in an order that does not depend on
//! them.

use rayon::prelude::*;

use super::grower::{Grower, NEIGHBOURS};
use super::islands::{Trees, grow_trees, islands, take_trees};
use super::samplers::{Drawn, draw};
use super::yields::{SAMPLERS, Sampler, shares};
use crate::applications::motion::prover::Prover;
use crate::query::{Deadline, QueryScratch};

/// Most configurations of one sampler in a batch: what a batch finds is known to the next one only.
const MOST: usize = 2048;

/// What one job of a batch found.
enum Found {
    /// A configuration, and the old nodes that it can be joined to.
    Node(Drawn, Vec<usize>),
    /// Trees between an island and others.
    Trees(Option<Trees>),
}

/// One batch of about so many checks. Ends early where the caller stops it, or time does: then
/// less is drawn, and what is drawn depends on when.
pub fn grow(grower: &mut Grower, checks: usize, limit: &Deadline) {
    let islands = islands(grower);
    let jobs = jobs(grower, checks, !islands.is_empty());
    let first = grower.roadmap.drawn;
    grower.roadmap.drawn += jobs.len() as u64;
    let this = &*grower;
    let find = |(memory, prover): &mut (QueryScratch, Prover), (at, sampler): (usize, &usize)| {
        let (sampler, index, before) = (SAMPLERS[*sampler], first + at as u64, prover.checks);
        if limit.is_reached(0) {
            return (Found::Trees(None), 0);
        }
        if sampler == Sampler::Trees {
            let trees = grow_trees(this, &islands, index, prover);
            return (Found::Trees(trees), prover.checks - before);
        }
        let drawn = draw(sampler, index, this.roadmap, &this.context, memory);
        let old = |q: &Vec<f64>| this.joinable(q, &this.nodes.near(q, NEIGHBOURS), prover);
        let neighbours = drawn.config.as_ref().map_or(Vec::new(), old);
        let checks = drawn.checks + prover.checks - before;
        (Found::Node(drawn, neighbours), checks)
    };
    let scratch = || (QueryScratch::default(), this.prover());
    let found: Vec<(Found, usize)> = jobs.par_iter().enumerate().map_init(scratch, find).collect();
    take(grower, &jobs, found);
}

/// Samplers of a batch of so many checks, by index.
fn jobs(grower: &Grower, checks: usize, has_islands: bool) -> Vec<usize> {
    let has_samples = !grower.context.query.samples().is_empty();
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
    counts.enumerate().flat_map(|(sampler, count)| std::iter::repeat_n(sampler, count)).collect()
}

/// Adds what a batch found. What cannot be joined to what was there is tried with what else is
/// new.
fn take(grower: &mut Grower, jobs: &[usize], found: Vec<(Found, usize)>) {
    let old = grower.nodes.len();
    let mut new = Vec::new();
    for (sampler, (found, checks)) in jobs.iter().zip(found) {
        let of = &mut grower.roadmap.yields[*sampler];
        (of.drawn, of.checks) = (of.drawn + 1, of.checks + checks as u64);
        grower.roadmap.checks += checks;
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
    let among_new = |prover: &mut Prover, (_, node, neighbours): &(usize, usize, Vec<usize>)| {
        if !neighbours.is_empty() {
            return (Vec::new(), 0);
        }
        let (q, before) = (this.nodes.config(*node), prover.checks);
        let near = this.nodes.near(q, NEIGHBOURS);
        let near: Vec<usize> = near.into_iter().filter(|other| *other >= old && other != node).collect();
        (this.joinable(q, &near, prover), prover.checks - before)
    };
    let more: Vec<(Vec<usize>, usize)> = new.par_iter().map_init(|| this.prover(), among_new).collect();
    for ((sampler, node, neighbours), (others, checks)) in new.into_iter().zip(more) {
        grower.roadmap.checks += checks;
        grower.roadmap.yields[sampler].checks += checks as u64;
        let joins = grower.join(node, &neighbours) + grower.join(node, &others);
        if joins != 1 {
            grower.roadmap.yields[sampler].useful += 1;
            grower.roadmap.narrow.push(node as u32);
        }
    }
}

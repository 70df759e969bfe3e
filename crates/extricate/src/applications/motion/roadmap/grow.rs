//! Batches: configurations are drawn and joined on all threads, in an order that does not depend on
//! them.

use rayon::prelude::*;

use super::components::Components;
use super::context::RoadmapContext;
use super::kept::Roadmap;
use super::samplers::{Drawn, draw};
use super::yields::{SAMPLERS, Sampler, Yield, shares};
use crate::applications::motion::nodes::Nodes;
use crate::applications::motion::prover::Prover;
use crate::query::{Deadline, QueryScratch};

/// Neighbours that a new node is tried to be joined to. Of `frame-1.5` (`bench/applications plan`,
/// three seeds) the median took 240,000 checks with these, 450,000 with 12, over 1,000,000 with 6.
pub const NEIGHBOURS: usize = 24;
/// Most configurations of one sampler in a batch: what a batch finds is known to the next one only.
const MOST: usize = 2048;

/// A roadmap while it grows.
pub struct Grower<'a, 'b> {
    pub context: RoadmapContext<'a>,
    pub roadmap: &'b mut Roadmap,
    pub nodes: Nodes<'a>,
    pub components: Components,
}

/// A configuration that was drawn, and the old nodes that it can be joined to.
struct Found {
    drawn: Drawn,
    neighbours: Vec<usize>,
    checks: usize,
}

impl<'a, 'b> Grower<'a, 'b> {
    /// Goes on with a roadmap.
    pub fn new(context: RoadmapContext<'a>, roadmap: &'b mut Roadmap) -> Self {
        let mut nodes = Nodes::new(context.query.metric);
        roadmap.configs.chunks_exact(roadmap.nq).for_each(|q| {
            nodes.push(q);
        });
        roadmap.yields.resize(SAMPLERS.len(), Yield::default());
        let components = Components::new(roadmap.len(), &roadmap.edges);
        Self { context, roadmap, nodes, components }
    }

    /// One batch of about so many checks. Ends early where the caller stops it, or time does: then
    /// less is drawn, and what is drawn depends on when.
    pub fn grow(&mut self, checks: usize, limit: &Deadline) {
        let jobs = self.jobs(checks);
        let first = self.roadmap.drawn;
        self.roadmap.drawn += jobs.len() as u64;
        let this = &*self;
        let find = |(memory, prover): &mut (QueryScratch, Prover), (at, sampler): (usize, &usize)| {
            if limit.is_reached(0) {
                return Found { drawn: Drawn { config: None, checks: 0 }, neighbours: Vec::new(), checks: 0 };
            }
            let drawn = draw(SAMPLERS[*sampler], first + at as u64, this.roadmap, &this.context, memory);
            let before = prover.checks;
            let old = |q: &Vec<f64>| this.joinable(q, &this.nodes.near(q, NEIGHBOURS), prover);
            let neighbours = drawn.config.as_ref().map_or(Vec::new(), old);
            Found { checks: drawn.checks + prover.checks - before, drawn, neighbours }
        };
        let scratch = || (QueryScratch::default(), this.prover());
        let found: Vec<Found> = jobs.par_iter().enumerate().map_init(scratch, find).collect();
        self.take(&jobs, found);
    }

    /// Adds a free configuration and joins it to what it can be joined to; its node.
    pub fn add(&mut self, q: &[f64]) -> usize {
        let mut prover = self.prover();
        let neighbours = self.joinable(q, &self.nodes.near(q, NEIGHBOURS), &mut prover);
        self.roadmap.checks += prover.checks;
        let node = self.push(q);
        self.join(node, &neighbours);
        self.roadmap.narrow.push(node as u32);
        node
    }

    /// Adds a path that was proved elsewhere.
    pub fn keep(&mut self, path: &[Vec<f64>]) {
        let Some((first, others)) = path.split_first() else { return };
        let mut last = self.add(first);
        for q in others {
            let node = self.push(q);
            self.join(node, &[last]);
            last = node;
        }
    }

    /// Samplers of a batch of so many checks, by index.
    fn jobs(&self, checks: usize) -> Vec<usize> {
        let has_samples = !self.context.query.samples().is_empty();
        let is_of_use = |sampler: Sampler| match sampler {
            Sampler::Stored => has_samples,
            Sampler::Around => !self.roadmap.narrow.is_empty(),
            _ => true,
        };
        let yields = &self.roadmap.yields;
        let counts = shares(yields, is_of_use).into_iter().zip(yields).map(|(share, of)| {
            let count = (share * checks as f64 / of.cost()).ceil() as usize;
            count.min(MOST)
        });
        counts.enumerate().flat_map(|(sampler, count)| std::iter::repeat_n(sampler, count)).collect()
    }

    pub(super) fn prover(&self) -> Prover<'a> {
        Prover::new(self.context.query.checker, self.context.resolution, Deadline::default())
    }

    /// Which of `near`, no two of them joined, proved edges lead to from a free configuration.
    pub(super) fn joinable(&self, q: &[f64], near: &[usize], prover: &mut Prover) -> Vec<usize> {
        let (mut joined, mut roots) = (Vec::new(), Vec::new());
        for node in near {
            let root = self.components.root(*node);
            if !roots.contains(&root) && prover.proves(q, self.nodes.config(*node)) {
                roots.push(root);
                joined.push(*node);
            }
        }
        joined
    }

    /// Adds what a batch found. What cannot be joined to what was there is tried with what else is
    /// new.
    fn take(&mut self, jobs: &[usize], found: Vec<Found>) {
        let old = self.nodes.len();
        let mut new = Vec::new();
        for (sampler, Found { drawn, neighbours, checks }) in jobs.iter().zip(found) {
            let of = &mut self.roadmap.yields[*sampler];
            (of.drawn, of.checks) = (of.drawn + 1, of.checks + checks as u64);
            self.roadmap.checks += checks;
            if let Some(q) = drawn.config {
                new.push((*sampler, self.push(&q), neighbours));
            }
        }
        let this = &*self;
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
            self.roadmap.checks += checks;
            self.roadmap.yields[sampler].checks += checks as u64;
            let joins = self.join(node, &neighbours) + self.join(node, &others);
            if joins != 1 {
                self.roadmap.yields[sampler].useful += 1;
                self.roadmap.narrow.push(node as u32);
            }
        }
    }

    fn push(&mut self, q: &[f64]) -> usize {
        self.roadmap.configs.extend_from_slice(q);
        self.components.push();
        self.nodes.push(q)
    }

    /// Joins a node to others; how many of them it was apart from.
    pub(super) fn join(&mut self, node: usize, others: &[usize]) -> usize {
        let mut joins = 0;
        for other in others {
            if self.components.join(node, *other) {
                self.roadmap.edges.push([*other as u32, node as u32]);
                joins += 1;
            }
        }
        joins
    }
}

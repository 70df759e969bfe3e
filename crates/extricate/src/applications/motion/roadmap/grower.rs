//! A roadmap while it grows: its nodes, indexed for nearest neighbours, and its components.

use super::components::Components;
use super::context::RoadmapContext;
use super::kept::Roadmap;
use super::yields::{SAMPLERS, Yield};
use crate::applications::motion::nodes::Nodes;
use crate::applications::motion::prover::Prover;
use crate::query::Deadline;

/// Neighbours that a new node is tried to be joined to. For `frame-1.5` (`bench/applications plan`,
/// three seeds) the median took 240,000 checks with 24, 450,000 with 12, over 1,000,000 with 6.
pub const NEIGHBOURS: usize = 24;

pub struct Grower<'a, 'b> {
    pub context: RoadmapContext<'a>,
    /// Limits in time and by the caller; `left` limits the checks.
    limit: Deadline,
    pub left: usize,
    pub roadmap: &'b mut Roadmap,
    pub nodes: Nodes<'a>,
    pub components: Components,
}

impl<'a, 'b> Grower<'a, 'b> {
    /// Continues a roadmap, and spends at most `left` checks.
    pub fn new(context: RoadmapContext<'a>, roadmap: &'b mut Roadmap, limit: &Deadline, left: usize) -> Self {
        let mut nodes = Nodes::new(context.query.metric);
        roadmap.configs.chunks_exact(roadmap.nq).for_each(|q| {
            nodes.push(q);
        });
        roadmap.yields.resize(SAMPLERS.len(), Yield::default());
        let components = Components::new(roadmap.len(), &roadmap.edges);
        Self { context, limit: limit.clone(), left, roadmap, nodes, components }
    }

    pub fn is_spent(&self) -> bool {
        self.left == 0 || self.limit.is_reached(0)
    }

    pub(super) fn spend(&mut self, checks: usize) {
        self.roadmap.checks += checks;
        self.left = self.left.saturating_sub(checks);
    }

    /// Adds a free configuration, joins it to what it can be joined to, and returns its node.
    pub fn add(&mut self, q: &[f64]) -> usize {
        let mut prover = self.prover();
        let neighbours = self.joinable(q, &self.nodes.near(q, NEIGHBOURS), &mut prover);
        self.spend(prover.checks);
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

    /// Returns a prover that may spend all that is left.
    pub(super) fn prover(&self) -> Prover<'a> {
        let mut prover = self.job_prover();
        prover.limited(self.left);
        prover
    }

    /// Returns a prover for parallel jobs, each of which limits its own checks: those of other jobs
    /// on the same thread do not count.
    pub(super) fn job_prover(&self) -> Prover<'a> {
        let limit = Deadline { checks: None, ..self.limit.clone() };
        Prover::new(self.context.query.checker, self.context.resolution, limit)
    }

    /// Returns those of `near` that proved edges lead to from the free `q`, at most one in a
    /// component, until the prover's budget is spent.
    pub(super) fn joinable(&self, q: &[f64], near: &[usize], prover: &mut Prover) -> Vec<usize> {
        let (mut joined, mut roots) = (Vec::new(), Vec::new());
        for node in near {
            if prover.is_spent() {
                break;
            }
            let root = self.components.root(*node);
            if !roots.contains(&root) && prover.proves(q, self.nodes.config(*node)) {
                roots.push(root);
                joined.push(*node);
            }
        }
        joined
    }

    pub(super) fn push(&mut self, q: &[f64]) -> usize {
        self.roadmap.configs.extend_from_slice(q);
        self.components.push();
        self.nodes.push(q)
    }

    /// Joins a node to others; returns how many of them were in another component.
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

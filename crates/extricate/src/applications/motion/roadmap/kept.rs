//! The roadmap itself: what is kept from one plan to the next.

use serde::{Deserialize, Serialize};

use super::yields::{MOST_COUNTED, Yield, check};
use crate::cspace::ConfigSpace;

/// Free configurations and proved edges between them: a forest, since only edges are kept that join
/// what was apart.
///
/// It belongs to the scene in which it grew. In another one of the same coordinates it is a guess
/// that saves checks: no path is returned whose edges were not proved in the scene that it is for.
#[derive(Debug, Clone, PartialEq)]
pub struct Roadmap {
    pub(super) nq: usize,
    /// The configurations, row after row.
    pub(super) configs: Vec<f64>,
    pub(super) edges: Vec<[u32; 2]>,
    /// Nodes that were useful: where it is narrow.
    pub(super) narrow: Vec<u32>,
    /// Of all random numbers.
    pub(super) seed: u64,
    /// Configurations drawn so far.
    pub(super) drawn: u64,
    /// What each sampler has yielded.
    pub(super) yields: Vec<Yield>,
    /// Configurations that were evaluated for it.
    pub(super) checks: usize,
}

/// What a file holds of a roadmap.
pub struct RoadmapParts {
    /// Coordinates of a configuration.
    pub nq: usize,
    /// The configurations, row after row.
    pub configs: Vec<f64>,
    /// Pairs of nodes.
    pub edges: Vec<[u32; 2]>,
    /// Nodes where it is narrow.
    pub narrow: Vec<u32>,
    /// The rest.
    pub rest: Rest,
}

/// What a roadmap says of itself beside its nodes and edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    seed: u64,
    drawn: u64,
    yields: Vec<Yield>,
    checks: usize,
}

impl Roadmap {
    /// Empty.
    pub fn new(space: &ConfigSpace, seed: u64) -> Self {
        let nq = space.nq();
        let (configs, edges, narrow) = (Vec::new(), Vec::new(), Vec::new());
        Self { nq, configs, edges, narrow, seed, drawn: 0, yields: Vec::new(), checks: 0 }
    }

    /// Number of configurations.
    pub fn len(&self) -> usize {
        self.configs.len() / self.nq
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.configs.is_empty()
    }

    /// Number of edges.
    pub fn edges(&self) -> usize {
        self.edges.len()
    }

    /// Configurations that the exact checker evaluated to make it.
    pub fn checks(&self) -> usize {
        self.checks
    }

    /// What a file holds of it.
    pub(crate) fn parts(&self) -> RoadmapParts {
        let Self { nq, configs, edges, narrow, seed, drawn, yields, checks } = self.clone();
        RoadmapParts { nq, configs, edges, narrow, rest: Rest { seed, drawn, yields, checks } }
    }

    /// The roadmap of these parts.
    ///
    /// # Errors
    /// As [`Roadmap::check`].
    pub(crate) fn of_parts(parts: RoadmapParts, space: &ConfigSpace) -> Result<Self, String> {
        let RoadmapParts { nq, configs, edges, narrow, rest: Rest { seed, drawn, yields, checks } } = parts;
        let roadmap = Self { nq, configs, edges, narrow, seed, drawn, yields, checks };
        roadmap.check(space)?;
        Ok(roadmap)
    }

    /// Whether it is one of `space` that this program could have made.
    ///
    /// # Errors
    /// The field, its value, and what was expected.
    pub(crate) fn check(&self, space: &ConfigSpace) -> Result<(), String> {
        if self.nq != space.nq() {
            return Err(format!("nq: got {}, expected that of the scene, {}", self.nq, space.nq()));
        }
        space.check_rows(&self.configs).map_err(|problem| format!("configurations: {problem}"))?;
        let nodes = self.len();
        let is_node = |node: &u32| (*node as usize) < nodes;
        if let Some(at) = self.edges.iter().position(|[a, b]| !is_node(a) || !is_node(b) || a == b) {
            return Err(format!("edges: row {at}: got {:?}, expected two of {nodes} nodes", self.edges[at]));
        }
        if self.edges.len() >= nodes.max(1) {
            return Err(format!("edges: got {}, expected fewer than the {nodes} nodes", self.edges.len()));
        }
        if let Some(node) = self.narrow.iter().find(|node| !is_node(node)) {
            return Err(format!("narrow: got {node}, expected one of {nodes} nodes"));
        }
        let most = [self.drawn, self.checks as u64].into_iter().fold(0, u64::max);
        if most > MOST_COUNTED {
            return Err(format!("counts: got {most}, expected at most {MOST_COUNTED}"));
        }
        check(&self.yields)
    }

    /// A node.
    pub(super) fn config(&self, node: usize) -> &[f64] {
        &self.configs[node * self.nq..][..self.nq]
    }
}

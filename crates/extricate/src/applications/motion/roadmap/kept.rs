//! The roadmap itself, as it is kept from one plan to the next.

use serde::{Deserialize, Serialize};

use super::yields::{MAX_COUNT, Yield, check};
use crate::cspace::ConfigSpace;

/// Free configurations and proved edges between them. They form a forest: only edges that join two
/// components are kept.
///
/// It belongs to the scene in which it grew. In another scene of the same coordinates it is a guess
/// that saves checks: a path is returned only if its edges are proved there.
#[derive(Debug, Clone, PartialEq)]
pub struct Roadmap {
    pub(super) nq: usize,
    pub(super) configs: Vec<f64>,
    pub(super) edges: Vec<[u32; 2]>,
    /// Nodes that were useful, as those in narrow places are.
    pub(super) narrow: Vec<u32>,
    pub(super) seed: u64,
    pub(super) drawn: u64,
    pub(super) yields: Vec<Yield>,
    pub(super) checks: usize,
}

/// Contents of a roadmap file.
pub struct RoadmapParts {
    /// Number of coordinates of a configuration.
    pub nq: usize,
    /// The configurations, row after row.
    pub configs: Vec<f64>,
    /// Pairs of joined nodes, by index.
    pub edges: Vec<[u32; 2]>,
    /// Indices of nodes in narrow places.
    pub narrow: Vec<u32>,
    /// Seed, counts and yields.
    pub rest: Rest,
}

/// Seed, counts and yields of a roadmap, as its file keeps them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    seed: u64,
    drawn: u64,
    yields: Vec<Yield>,
    checks: usize,
}

impl Roadmap {
    /// Makes an empty roadmap, with the seed of all its random numbers.
    pub fn new(space: &ConfigSpace, seed: u64) -> Self {
        let nq = space.nq();
        let (configs, edges, narrow) = (Vec::new(), Vec::new(), Vec::new());
        Self { nq, configs, edges, narrow, seed, drawn: 0, yields: Vec::new(), checks: 0 }
    }

    /// Returns the number of configurations.
    pub fn len(&self) -> usize {
        self.configs.len() / self.nq
    }

    /// Whether it has no configurations.
    pub fn is_empty(&self) -> bool {
        self.configs.is_empty()
    }

    /// Returns the number of edges.
    pub fn edges(&self) -> usize {
        self.edges.len()
    }

    /// Number of configurations that the exact checker evaluated to make it.
    pub fn checks(&self) -> usize {
        self.checks
    }

    /// Returns the contents of its file.
    pub(crate) fn parts(&self) -> RoadmapParts {
        let Self { nq, configs, edges, narrow, seed, drawn, yields, checks } = self.clone();
        RoadmapParts { nq, configs, edges, narrow, rest: Rest { seed, drawn, yields, checks } }
    }

    /// Makes the roadmap of a file's contents.
    ///
    /// # Errors
    /// As [`Roadmap::check`].
    pub(crate) fn of_parts(parts: RoadmapParts, space: &ConfigSpace) -> Result<Self, String> {
        let RoadmapParts { nq, configs, edges, narrow, rest: Rest { seed, drawn, yields, checks } } = parts;
        let roadmap = Self { nq, configs, edges, narrow, seed, drawn, yields, checks };
        roadmap.check(space)?;
        Ok(roadmap)
    }

    /// Checks that it is one of `space` that this program could have made.
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
        if most > MAX_COUNT {
            return Err(format!("counts: got {most}, expected at most {MAX_COUNT}"));
        }
        check(&self.yields)
    }

    pub(super) fn config(&self, node: usize) -> &[f64] {
        &self.configs[node * self.nq..][..self.nq]
    }
}

//! A roadmap: free configurations, most of them from where it is narrow, and proved edges.
//!
//! Read in this order: `mod` (what is kept), `components`, `samplers` (where configurations come
//! from), `grow` (batches: draw, join, measure what each sampler yields), `solve` (a path).
//!
//! Free configurations drawn uniformly hardly ever lie in a narrow passage; the nearest free ones
//! to colliding ones do, but cost more checks each. Which is worth its checks depends on the scene,
//! so it is measured: a sampler's share of the next batch is its share of what was *useful* for
//! each check, a node that nothing known can be joined to, or one that joins what was apart.
//!
//! # Source
//! The measure of use is that of T. Simeon, J.-P. Laumond and C. Nissoux, "Visibility-based
//! probabilistic roadmaps for motion planning", Advanced Robotics 14(6), 2000,
//! doi:10.1163/156855300741960; but useless nodes are kept too. Retraction: L. Zhang and D. Manocha,
//! "An efficient retraction-based RRT planner", ICRA 2008, doi:10.1109/ROBOT.2008.4543785. Bridges:
//! D. Hsu, T. Jiang, J. Reif and Z. Sun, "The bridge test for sampling narrow passages with
//! probabilistic roadmap planners", ICRA 2003, doi:10.1109/ROBOT.2003.1241662.

mod components;
mod grow;
mod samplers;
mod solve;

pub(super) use grow::Grower;
use samplers::Yield;

use serde::{Deserialize, Serialize};

use crate::cspace::ConfigSpace;
use crate::query::Context;

/// Free configurations and proved edges between them: a forest, since only edges are kept that join
/// what was apart.
///
/// It belongs to the scene in which it grew. In another one of the same coordinates it is a guess
/// that saves checks: no path is returned whose edges were not proved in the scene that it is for.
#[derive(Debug, Clone, PartialEq)]
pub struct Roadmap {
    nq: usize,
    /// The configurations, row after row.
    configs: Vec<f64>,
    edges: Vec<[u32; 2]>,
    /// Nodes that were useful: where it is narrow.
    narrow: Vec<u32>,
    /// Of all random numbers.
    seed: u64,
    /// Configurations drawn so far.
    drawn: u64,
    /// What each sampler has yielded.
    yields: Vec<Yield>,
    /// Configurations that were evaluated for it.
    checks: usize,
}

/// Most that a count may say \[1\]: more takes longer than anyone has, and sums would overflow.
const MOST_COUNTED: u64 = 1 << 48;

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
        samplers::check(&self.yields)
    }

    fn config(&self, node: usize) -> &[f64] {
        &self.configs[node * self.nq..][..self.nq]
    }
}

/// What a roadmap grows in.
#[derive(Clone, Copy)]
pub struct RoadmapContext<'a> {
    /// What queries stand on.
    pub query: Context<'a>,
    /// Of the smallest moving body \[m\]: what lengths are shares of.
    pub radius: f64,
    /// Of the proofs of edges \[m\].
    pub resolution: f64,
}

impl<'a> RoadmapContext<'a> {
    /// Of a scene.
    pub fn new(query: &Context<'a>, resolution: f64) -> Self {
        Self { query: *query, radius: query.checker.moving_radius(), resolution }
    }
}

//! Options and result of a plan.

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::interface::{setters, words};
use crate::query::Termination;

/// Options of a plan.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PlanOptions {
    /// How finely edges are proved \[m\], see [`crate::SegmentOptions::resolution`]. Edges that
    /// pass a body at less than about this are not found.
    pub resolution: f64,
    /// Whether to remove points that are not needed.
    pub shortcut: bool,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Threads that grow the roadmap, 0 for one a core. The path does not depend on them.
    pub threads: usize,
    /// When to give up.
    pub termination: Termination,
}

setters! {
    PlanOptions {
        resolution: f64,
        shortcut: bool,
        seed: u64,
        threads: usize,
        termination: Termination,
    }
}

impl Default for PlanOptions {
    /// Proves edges to 0.1 mm, and ends after a million checks.
    fn default() -> Self {
        let termination = Termination::after_checks(1_000_000);
        Self { resolution: 1e-4, shortcut: true, seed: 0, threads: 0, termination }
    }
}

impl PlanOptions {
    pub(super) fn check(&self) -> Result<()> {
        if (0.0..=1e9).contains(&self.resolution) {
            return Ok(());
        }
        let value = self.resolution.to_string();
        Err(Error::Option { name: "resolution", value, expected: "a length in metres, 0 to 1e9".into() })
    }

    pub(super) fn pool(&self) -> Result<ThreadPool> {
        let refused = |_| Error::Option {
            name: "threads",
            value: self.threads.to_string(),
            expected: "a number that the system can start".into(),
        };
        ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(refused)
    }
}

/// The step that found the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PlanMethod {
    /// The straight edge between the ends.
    Straight,
    /// Trees from both ends (RRT-Connect).
    Trees,
    /// A path through the roadmap.
    Roadmap,
}

words! { PlanMethod as "method" { Straight = "straight", Trees = "trees", Roadmap = "roadmap" } }

/// A path between two free configurations, see [`crate::Solver::plan`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Plan {
    /// Configurations from one end to the other, joined by geodesics; empty if no path was found.
    pub points: Vec<Vec<f64>>,
    /// The step that found the path; `None` if none did.
    pub method: Option<PlanMethod>,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: usize,
    /// Number of configurations in the roadmap.
    pub nodes: usize,
}

impl Plan {
    /// Whether a path was found.
    pub fn is_found(&self) -> bool {
        self.method.is_some()
    }

    pub(super) fn none(checks: usize, nodes: usize) -> Self {
        Self { points: Vec::new(), method: None, length: 0.0, checks, nodes }
    }
}

//! Options and result of a plan.

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use crate::applications::motion::escape::Escape;
use crate::error::{Error, Result};
use crate::interface::{setters, words};
use crate::query::{KeptLink, Termination};

/// Options of a plan.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PlanOptions {
    /// Resolution \[m\] at which edges are proved, see [`crate::SegmentOptions::resolution`]. Edges
    /// that pass a body at less than about this distance are not found.
    pub resolution: f64,
    /// Depth \[m\] by which a pair that collides at an end may get deeper on the path, see
    /// [`crate::EscapeOptions::tolerance`].
    pub tolerance: f64,
    /// Links that keep their places at the start, or at given poses, all along the path.
    pub keep: Vec<KeptLink>,
    /// Clearance \[m\] to which the points of the free path are pushed off, for pairs without one
    /// of their own; or as much of it as they can keep nearby. `None` leaves the path short, and is
    /// the only value with [`PlanOptions::keep`].
    pub clearance: Option<f64>,
    /// Whether to shorten the path.
    pub shortcut: bool,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Number of threads that grow the roadmap, 0 for one per core. The path does not depend on it.
    pub threads: usize,
    /// When to give up.
    pub termination: Termination,
}

setters! {
    PlanOptions {
        resolution: f64,
        tolerance: f64,
        keep: Vec<KeptLink>,
        clearance: f64 = Some,
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
        Self {
            resolution: 1e-4,
            tolerance: 1e-3,
            keep: Vec::new(),
            clearance: None,
            shortcut: true,
            seed: 0,
            threads: 0,
            termination,
        }
    }
}

impl PlanOptions {
    pub(super) fn check(&self) -> Result<()> {
        let lengths = [
            ("resolution", self.resolution),
            ("tolerance", self.tolerance),
            ("clearance", self.clearance.unwrap_or(0.0)),
        ];
        if let Some(clearance) = self.clearance.filter(|_| !self.keep.is_empty()) {
            let expected = "none with `keep`: points that are pushed off mostly lose the links".into();
            return Err(Error::Option { name: "clearance", value: clearance.to_string(), expected });
        }
        match lengths.into_iter().find(|(_, length)| !(0.0..=1e9).contains(length)) {
            Some((name, length)) => {
                Err(Error::Option { name, value: length.to_string(), expected: "a length in metres, 0 to 1e9".into() })
            }
            None => Ok(()),
        }
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
    /// The straight edge between the ends, bent if links are kept.
    Straight,
    /// Trees from both ends (RRT-Connect).
    Trees,
    /// A path through the roadmap.
    Roadmap,
}

words! { PlanMethod as "method" { Straight = "straight", Trees = "trees", Roadmap = "roadmap" } }

/// A path between two configurations, see [`crate::Solver::plan`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Plan {
    /// Configurations from one end to the other, joined by geodesics; empty if no path was found.
    pub points: Vec<Vec<f64>>,
    /// Index into `points` from which on the path is proved free: 0 if it begins at a free
    /// configuration.
    pub free_from: usize,
    /// Index into `points` up to which the path is proved free: the last one if it ends at a free
    /// configuration.
    pub free_to: usize,
    /// Path from a colliding start to the free part; `None` if the start is free. If no such path
    /// was found, the plan has none either, and the escape says why.
    pub start_escape: Option<Escape>,
    /// The same from a colliding goal, which the plan takes in reverse.
    pub goal_escape: Option<Escape>,
    /// The step that found the free part; `None` if none did.
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

    pub(super) fn none([start_escape, goal_escape]: [Option<Escape>; 2], checks: usize, nodes: usize) -> Self {
        let points = Vec::new();
        Self { points, free_from: 0, free_to: 0, start_escape, goal_escape, method: None, length: 0.0, checks, nodes }
    }
}

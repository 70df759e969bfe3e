//! Options and result of an escape.

use serde::Serialize;

use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::interface::{setters, words};
use crate::query::options::MAX_EXITS;
use crate::query::{KeptLink, Termination};
use crate::scene::PairId;

/// Margin \[m\] that the end of a path keeps beyond the scene's clearance if no aim is given. It is
/// ten times the resolution of proofs, so that the last edge is proved and another can begin there.
pub const AIM_MARGIN_M: f64 = 1e-3;

/// Options of an escape.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EscapeOptions {
    /// Clearance \[m\] for the end of the path, for pairs without one of their own. A near end with
    /// less clearance, at least the scene's, is preferred to a far one. `None` is the scene's
    /// clearance plus 1 mm.
    pub aim: Option<f64>,
    /// Depth \[m\] by which a pair that collides at the query may get deeper on the path.
    pub tolerance: f64,
    /// Links that keep their places at the query, or at given poses, all along the path.
    pub keep: Vec<KeptLink>,
    /// Goal of a later motion: of exits that are about as near, the one nearest to it is preferred.
    pub toward: Option<Config>,
    /// Number of exits to which straight edges are tried, the nearest first.
    pub exits: usize,
    /// Resolution \[m\] at which edges are proved, see [`crate::SegmentOptions::resolution`].
    pub resolution: f64,
    /// Largest number of checks of the trees, which grow only if nothing simpler leads out of
    /// collision.
    pub tree_checks: usize,
    /// The seed of all random numbers.
    pub seed: u64,
    /// When to give up.
    pub termination: Termination,
}

setters! {
    EscapeOptions {
        aim: f64 = Some,
        tolerance: f64,
        keep: Vec<KeptLink>,
        toward: Config = Some,
        exits: usize,
        resolution: f64,
        tree_checks: usize,
        seed: u64,
        termination: Termination,
    }
}

impl Default for EscapeOptions {
    /// Allows 1 mm of tolerance, six exits, and trees of 20,000 checks.
    fn default() -> Self {
        Self {
            aim: None,
            tolerance: 1e-3,
            keep: Vec::new(),
            toward: None,
            exits: 6,
            resolution: 1e-4,
            tree_checks: 20_000,
            seed: 0,
            termination: Termination::default(),
        }
    }
}

impl EscapeOptions {
    /// Checks that the lengths and the number of exits are allowed.
    ///
    /// # Errors
    /// [`Error::Option`], which names the option.
    pub(super) fn check(&self) -> Result<()> {
        let is_length = |length: f64| (0.0..=1e9).contains(&length);
        let lengths =
            [("aim", self.aim.unwrap_or(0.0)), ("tolerance", self.tolerance), ("resolution", self.resolution)];
        if self.exits > MAX_EXITS {
            return Err(Error::Option {
                name: "exits",
                value: self.exits.to_string(),
                expected: "at most 100000".into(),
            });
        }
        match lengths.into_iter().find(|(_, length)| !is_length(*length)) {
            Some((name, length)) => {
                Err(Error::Option { name, value: length.to_string(), expected: "a length in metres, 0 to 1e9".into() })
            }
            None => Ok(()),
        }
    }
}

/// The step that found the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum EscapeMethod {
    /// The query is free.
    Free,
    /// A straight edge to the nearest exit, bent if links are kept.
    Nearest,
    /// The same to another exit.
    Exit,
    /// The colliding pairs were separated step by step.
    Pushed,
    /// Trees that grew toward each other.
    Grown,
}

words! {
    EscapeMethod as "method" {
        Free = "free",
        Nearest = "nearest",
        Exit = "exit",
        Pushed = "pushed",
        Grown = "grown",
    }
}

/// A path out of collision, see [`crate::Solver::escape`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Escape {
    /// Configurations of the path, the query first, joined by geodesics; empty if no path was
    /// found.
    pub points: Vec<Vec<f64>>,
    /// Index into `points` from which on the path is proved free.
    pub free_from: usize,
    /// The step that found the path; `None` if none did.
    pub method: Option<EscapeMethod>,
    /// Pairs that collide at the query, and their signed distances \[m\] there.
    pub colliding: Vec<(PairId, f64)>,
    /// Most \[m\] that any pair of `colliding` was measured deeper than at the query, at the points
    /// and between them, or 0. It is proved to be at most the tolerance.
    pub deepening: f64,
    /// Least of 1, 2, 5 and 10 mm with which, as a larger tolerance, a path is found, in units of
    /// metres. `None` if a path was found, or if none is found with these either.
    pub needed_tolerance: Option<f64>,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Largest displacement \[m\] of any point of the moving geometry from the query to `points`.
    pub max_displacement: f64,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: usize,
}

impl Escape {
    /// Whether a path was found.
    pub fn is_found(&self) -> bool {
        self.method.is_some()
    }
}

/// Returns the result for a free query.
pub fn is_free_already(q: &Config) -> Escape {
    let points = vec![q.to_vec()];
    Escape { points, method: Some(EscapeMethod::Free), ..found_nothing(&[], 1) }
}

pub fn found_nothing(colliding: &[(PairId, f64)], checks: usize) -> Escape {
    Escape {
        points: Vec::new(),
        free_from: 0,
        method: None,
        colliding: colliding.to_vec(),
        deepening: 0.0,
        needed_tolerance: None,
        length: 0.0,
        max_displacement: 0.0,
        checks,
    }
}

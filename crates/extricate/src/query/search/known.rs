//! State of a query: exits, starts and bounds so far, and memory for them.

use super::directions::displacement_tree::Directions;
use super::stored::StoredStarts;
use crate::metric::Anchor;
use crate::query::bound::proof::Proof;
use crate::query::context::Context;
use crate::query::exits::Exits;
use crate::query::local_metric::LocalMetric;
use crate::scene::PairId;

/// State of a query and of the group that is searched.
#[derive(Default)]
pub struct Known {
    /// The query, with its poses.
    pub anchor: Anchor,
    /// The query moved onto the joint limits; joints that are held still stay there.
    pub rest: Vec<f64>,
    pub local: LocalMetric,
    /// Number of exits to search for.
    pub wanted: usize,
    /// A configuration that may be free, which each group checks first; empty if there is none.
    pub hint: Vec<f64>,
    /// Whether a search that finds nothing takes a stored sample or any free configuration.
    pub looks_anywhere: bool,
    /// Whether a stored sample can be the answer. A spent budget then also ends a search without an
    /// exit.
    pub may_fall_back: bool,
    /// Whether an earlier search of the same query found an exit.
    pub has_earlier: bool,
    /// See [`super::Search::believes`], which a group's search takes over.
    pub believes: bool,
    pub exits: Exits,
    pub directions: Directions,
    pub stored: StoredStarts,
    /// Starts that keep the links, with their distances from the query, nearest first.
    pub kept: Vec<(f64, Vec<f64>)>,
    pub proof: Proof,
    /// Starts that the group tried, including those that were pruned without a check.
    pub tried: usize,
    /// Starts of the group whose descents ended in collision.
    pub stuck: usize,
    /// Memory for the start of a descent.
    pub start: Vec<f64>,
    /// Memory for several starts, row major.
    pub starts: Vec<f64>,
    /// Memory for a displacement from the query.
    pub step: Vec<f64>,
}

impl Known {
    /// Begins a query for `wanted` exits at the anchor, which is set already.
    pub fn begin(&mut self, context: &Context, wanted: usize) {
        self.local.set(context, &self.anchor);
        self.rest.clone_from(&self.anchor.q);
        context.checker.scene().space.clamp(&mut self.rest);
        (self.wanted, self.looks_anywhere, self.has_earlier) = (wanted, true, false);
        self.hint.clear();
        self.begin_group(std::iter::empty());
    }

    /// Begins the search of the group that has these colliding pairs.
    pub fn begin_group(&mut self, colliding: impl Iterator<Item = PairId>) {
        self.proof.begin_group(colliding);
        self.exits.clear();
        self.directions.reset();
        self.stored.reset();
        (self.tried, self.stuck) = (0, 0);
    }

    /// Returns the depth of the last wanted exit: only nearer ones are of use.
    pub fn ceiling(&self) -> f64 {
        self.exits.ceiling(self.wanted)
    }

    /// Estimates the share of starts that would lead to an exit that no descent has met.
    ///
    /// # Source
    /// C. G. E. Boender and A. H. G. Rinnooy Kan, "Bayesian stopping rules for multistart global
    /// optimization methods", Mathematical Programming 37, 1987, doi:10.1007/BF02591684: of n
    /// uniform starts that led to w distinct ends, w (w + 1) / (n (n - 1)). Deviations: starts are
    /// not uniform, and pruned ones count as led to a known end.
    pub fn unseen(&self) -> f64 {
        let (w, n) = (self.exits.last().count() as f64, self.tried as f64);
        if n < 2.0 { 1.0 } else { (w * (w + 1.0) / (n * (n - 1.0))).min(1.0) }
    }
}

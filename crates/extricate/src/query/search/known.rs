//! What a query has come to know, and memory for it.

use super::directions::tree::Directions;
use super::stored::StoredStarts;
use crate::metric::Anchor;
use crate::query::bound::proof::Proof;
use crate::query::context::Context;
use crate::query::exits::Exits;
use crate::query::local_metric::LocalMetric;
use crate::scene::PairId;

/// What a query has come to know, and memory for it.
#[derive(Default)]
pub struct Known {
    /// The query.
    pub anchor: Anchor,
    /// The query within the joint limits: joints that are held still are there.
    pub rest: Vec<f64>,
    /// The metric around it.
    pub local: LocalMetric,
    /// How many exits are wanted.
    pub wanted: usize,
    /// A configuration that may be free: each group looks at it first. Empty if there is none.
    pub hint: Vec<f64>,
    /// Whether a search that finds nothing looks for anything free.
    pub looks_anywhere: bool,
    /// Whether a stored sample is taken if the budget ends a search: it then ends before there is
    /// an exit too.
    pub may_fall_back: bool,
    /// Whether an earlier search of the same query has found an exit.
    pub has_earlier: bool,
    /// Whether descents along meshes are believed for what they see of the pieces around them.
    pub believes: bool,
    /// Where descents of the group ended.
    pub exits: Exits,
    /// Where its colliding bodies part.
    pub directions: Directions,
    /// Stored samples that it starts from.
    pub stored: StoredStarts,
    /// What is proved of it.
    pub proof: Proof,
    /// Starts of the group that were tried, those that cost no check among them.
    pub tried: usize,
    /// Those among them that ended in collision.
    pub stuck: usize,
    /// A configuration that a descent is to start from.
    pub start: Vec<f64>,
    /// Several of them, row major.
    pub starts: Vec<f64>,
    /// How far it is from the query.
    pub step: Vec<f64>,
}

impl Known {
    /// Begins a query for `wanted` exits from the anchor.
    pub fn begin(&mut self, context: &Context, wanted: usize) {
        self.local.set(context, &self.anchor);
        self.rest.clone_from(&self.anchor.q);
        context.checker.scene().space.clamp(&mut self.rest);
        (self.wanted, self.looks_anywhere, self.has_earlier) = (wanted, true, false);
        self.hint.clear();
        self.begin_group(std::iter::empty());
    }

    /// Begins the search of a group whose colliding pairs these are.
    pub fn begin_group(&mut self, colliding: impl Iterator<Item = PairId>) {
        self.proof.begin_group(colliding);
        self.exits.clear();
        self.directions.reset();
        self.stored.reset();
        (self.tried, self.stuck) = (0, 0);
    }

    /// What is not nearer than this is of no use.
    pub fn ceiling(&self) -> f64 {
        self.exits.ceiling(self.wanted)
    }

    /// Estimated share of starts that would lead to an exit that no descent has met.
    ///
    /// # Source
    /// C. G. E. Boender and A. H. G. Rinnooy Kan, "Bayesian stopping rules for multistart global
    /// optimization methods", Mathematical Programming 37, 1987, doi:10.1007/BF02591684: of n
    /// uniform starts that led to w distinct ends, w (w + 1) / (n (n - 1)). Starts here are not
    /// uniform, and those that were given up count as led to what is known.
    pub fn unseen(&self) -> f64 {
        let (w, n) = (self.exits.last().count() as f64, self.tried as f64);
        if n < 2.0 { 1.0 } else { (w * (w + 1.0) / (n * (n - 1.0))).min(1.0) }
    }
}

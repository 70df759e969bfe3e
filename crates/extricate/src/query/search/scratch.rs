//! Memory that queries reuse, and what can be asked of the last one.

use std::sync::Arc;

use super::known::Known;
use crate::cspace::{ConfigSpace, Label};
use crate::metric::Anchor;
use crate::metric::motion_bound::MotionPath;
use crate::metric::quadratic::Quadratic;
use crate::query::answer::Answer;
use crate::query::context::Context;
use crate::query::descent::DescentScratch;
use crate::query::evaluate::Evaluator;
use crate::query::groups::Groups;
use crate::samples::BoundaryScratch;
use crate::scene::PairId;

/// Memory that queries reuse; one per thread.
#[derive(Default)]
pub struct QueryScratch {
    pub(crate) evaluator: Evaluator,
    pub(crate) descent: DescentScratch,
    pub(crate) boundary: BoundaryScratch,
    pub(crate) known: Known,
    pub(crate) groups: Groups,
    pub(crate) report: ReportScratch,
    pub(crate) group_memory: GroupMemory,
    /// Stored samples and their distances.
    pub(crate) near: Vec<(u32, f64)>,
    /// Pairs that collide at the query moved onto the limits.
    pub(crate) at_rest: Vec<PairId>,
}

impl QueryScratch {
    /// An exact check, counted.
    pub(crate) fn label(&mut self, context: &Context, q: &[f64]) -> Label {
        self.evaluator.label(context, q)
    }

    /// Checks of the last query so far.
    pub(crate) fn checks(&self) -> usize {
        self.evaluator.checks
    }

    /// Up to `most` other exits with their depths, distinct from the answer and from each other,
    /// where descents of the last query ended besides: nearest first, not carried to the last digit
    /// and not checked.
    pub(crate) fn other_exits(&mut self, space: &ConfigSpace, answer: &Answer, most: usize) -> Vec<(f64, Vec<f64>)> {
        let Known { exits, local, .. } = &mut self.known;
        let others = exits.besides(space, local, (answer.depth, &answer.witness)).take(most);
        others.map(|end| (end.distance, end.config.clone())).collect()
    }
}

/// Memory that reports reuse.
#[derive(Default)]
pub struct ReportScratch {
    /// Paths that the free radius is proved by.
    pub motion: MotionPath,
    /// The witness, which the gradient is seen from.
    pub far_anchor: Anchor,
    /// The metric's model at the witness, for the gradient.
    pub quadratic: Quadratic,
    /// A configuration beside the query.
    pub moved: Vec<f64>,
    /// The step to it.
    pub step: Vec<f64>,
}

/// What the search of a group found.
#[derive(Default)]
pub struct Found {
    pub root: usize,
    /// Its exits, row major, nearest first; other joints are where the query has them.
    pub exits: Vec<f64>,
    /// What is proved of its depth, if anything is.
    pub bound: Option<f64>,
    /// The share of exits that may not have been met.
    pub unseen: f64,
}

/// Memory that searches of groups reuse.
#[derive(Default)]
pub struct GroupMemory {
    /// What the groups that were searched have found.
    pub found: Vec<Found>,
    pub spare: Vec<Found>,
    /// For every checked pair, whether the group alone moves it, and whether stored planes hold.
    pub judged: Option<Arc<Vec<bool>>>,
    pub holding: Vec<bool>,
    /// For every tangent coordinate, whether it stays.
    pub locked: Vec<bool>,
    /// Pairs that collide.
    pub own: Vec<PairId>,
    /// What the groups make together.
    pub best: Vec<f64>,
    pub config: Vec<f64>,
    pub bounds: Vec<f64>,
}

impl GroupMemory {
    /// Forgets what groups have found.
    pub fn forget_found(&mut self) {
        self.spare.append(&mut self.found);
    }

    /// Forgets what some groups have found.
    pub fn drop_found(&mut self, is_dropped: impl Fn(&Found) -> bool) {
        while let Some(at) = self.found.iter().position(&is_dropped) {
            self.spare.push(self.found.remove(at));
        }
    }
}

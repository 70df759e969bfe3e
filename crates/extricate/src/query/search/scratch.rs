//! Memory that queries reuse, and the other exits that the last one found.

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
    /// Stored samples with their distances from the query.
    pub(crate) near: Vec<(u32, f64)>,
    /// Pairs that collide at the query moved onto the limits.
    pub(crate) at_rest: Vec<PairId>,
}

impl QueryScratch {
    /// Checks a configuration exactly; the check counts.
    pub(crate) fn label(&mut self, context: &Context, q: &[f64]) -> Label {
        self.evaluator.label(context, q)
    }

    /// Returns the number of checks of the last query so far.
    pub(crate) fn checks(&self) -> usize {
        self.evaluator.checks
    }

    /// Returns up to `most` other exits of the last query with their depths, nearest first. They
    /// are distinct from the answer and from each other, but may be neither polished nor verified.
    pub(crate) fn other_exits(&mut self, space: &ConfigSpace, answer: &Answer, most: usize) -> Vec<(f64, Vec<f64>)> {
        let Known { exits, local, .. } = &mut self.known;
        let others = exits.besides(space, local, (answer.depth, &answer.witness)).take(most);
        others.map(|end| (end.distance, end.config.clone())).collect()
    }
}

/// Memory that reports reuse.
#[derive(Default)]
pub struct ReportScratch {
    /// Motion bound that proves the free radius.
    pub motion: MotionPath,
    /// The witness with its poses, for the gradient.
    pub far_anchor: Anchor,
    /// Model at the query of the distance from the witness, for the gradient.
    pub quadratic: Quadratic,
    /// The query displaced by `step`, for differences.
    pub moved: Vec<f64>,
    pub step: Vec<f64>,
}

/// Result of the search of a group.
#[derive(Default)]
pub struct GroupResult {
    pub root: usize,
    /// Its exits, row major, nearest first; other joints are where the query has them.
    pub exits: Vec<f64>,
    /// Proved lower bound on its depth, if one was computed.
    pub bound: Option<f64>,
    /// Estimate of [`Known::unseen`] for the group.
    pub unseen: f64,
}

/// Memory that searches of groups reuse.
#[derive(Default)]
pub struct GroupMemory {
    /// Results of the groups searched so far.
    pub found: Vec<GroupResult>,
    pub spare: Vec<GroupResult>,
    /// For every checked pair, whether the group alone moves it, and whether stored contact planes
    /// hold.
    pub judged: Option<Arc<Vec<bool>>>,
    pub holding: Vec<bool>,
    /// For every tangent coordinate, whether it stays where the query has it.
    pub locked: Vec<bool>,
    /// Colliding pairs of the group, or of the combined exit.
    pub own: Vec<PairId>,
    /// Combination of the nearest exits of all groups.
    pub best: Vec<f64>,
    pub config: Vec<f64>,
    pub bounds: Vec<f64>,
}

impl GroupMemory {
    pub fn forget_found(&mut self) {
        self.spare.append(&mut self.found);
    }

    pub fn drop_found(&mut self, is_dropped: impl Fn(&GroupResult) -> bool) {
        while let Some(at) = self.found.iter().position(&is_dropped) {
            self.spare.push(self.found.remove(at));
        }
    }
}

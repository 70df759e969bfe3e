//! The lower bound that is proved while a query is searched, and whether it suffices to stop.
//! Effort `proved` closes the remaining gap by `branch_and_bound`.

use super::branch_and_bound::Branches;
use super::combined::{BoundScratch, Splits, lower_bound};
use crate::collision::CheckScratch;
use crate::metric::Anchor;
use crate::query::context::Context;
use crate::query::options::Effort;
use crate::scene::{MetricKind, PairId};

/// The lower bound of a query, or of the group that is searched, and memory to compute it.
#[derive(Default)]
pub struct Proof {
    /// The search ends once at most this share of the depth is unproved; `None` if a bound never
    /// ends it.
    pub gap: Option<f64>,
    /// The pairs that have to part.
    pub colliding: Vec<PairId>,
    /// How finely directions are split; `None` if bounds use balls alone.
    splits: Option<Splits>,
    /// No free configuration is nearer than this (metric units).
    proved: f64,
    /// Depth at the last computation of `proved`; infinite if a computation is due.
    told_at: f64,
    scratch: BoundScratch,
    /// State of branch and bound.
    pub branches: Branches,
}

/// Recompute the bound once the depth falls below this share of the depth at the last computation:
/// curvature bounds tighten with the search radius.
const RECOMPUTE_DEPTH_SHARE: f64 = 0.8;

/// Pairs and cell splits of a bound.
const SPLITS: Splits = Splits { pairs: 2, each: 80 };
/// Pairs and cell splits of a bound in efforts `exhaustive` and `proved`.
const CLOSE_SPLITS: Splits = Splits { pairs: 8, each: 192 };

impl Proof {
    /// Begins a query whose search ends at `gap`, if one is given.
    pub fn begin(&mut self, effort: Effort, gap: Option<f64>) {
        self.gap = gap;
        self.splits = (effort != Effort::Nearest).then_some(SPLITS);
        self.begin_group(std::iter::empty());
    }

    /// Computes finer bounds from now on, and ends the search at another gap.
    pub fn look_closely(&mut self, gap: Option<f64>) {
        (self.gap, self.splits, self.told_at) = (gap, Some(CLOSE_SPLITS), f64::INFINITY);
    }

    /// Forgets the bound and begins a group in which the `colliding` pairs have to part.
    pub fn begin_group(&mut self, colliding: impl Iterator<Item = PairId>) {
        (self.proved, self.told_at) = (0.0, f64::INFINITY);
        self.set_colliding(colliding);
    }

    /// Replaces the pairs that have to part, and keeps the bound.
    pub fn set_colliding(&mut self, colliding: impl Iterator<Item = PairId>) {
        self.colliding.clear();
        self.colliding.extend(colliding);
    }

    /// Returns the bound, if one was computed.
    pub fn told(&self) -> Option<f64> {
        self.told_at.is_finite().then_some(self.proved)
    }

    /// Combines the bounds of all groups, computed at their common `depth`.
    pub fn take_groups(&mut self, kind: MetricKind, bounds: &[f64], depth: f64) {
        self.told_at = depth;
        self.proved = match kind {
            MetricKind::Joint => bounds.iter().map(|bound| bound * bound).sum::<f64>().sqrt(),
            _ => bounds.iter().copied().fold(0.0, f64::max),
        };
    }

    /// Raises the bound to one that was proved elsewhere.
    pub fn raise(&mut self, bound: f64) {
        self.proved = self.proved.max(bound);
    }

    /// Returns the bound at a depth, and at most that depth.
    pub fn bound(&mut self, context: &Context, anchor: &Anchor, depth: f64, check: &mut CheckScratch) -> f64 {
        if depth < RECOMPUTE_DEPTH_SHARE * self.told_at {
            let how = (self.splits, depth);
            let bound = lower_bound(context, anchor, &self.colliding, how, &mut self.scratch, check);
            (self.proved, self.told_at) = (self.proved.max(bound), depth);
        }
        self.proved.min(depth)
    }

    /// Whether the bound at a depth leaves no more than the requested gap.
    pub fn is_enough(&mut self, context: &Context, anchor: &Anchor, depth: f64, check: &mut CheckScratch) -> bool {
        let Some(gap) = self.gap else { return false };
        self.bound(context, anchor, depth, check) >= (1.0 - gap) * depth
    }
}

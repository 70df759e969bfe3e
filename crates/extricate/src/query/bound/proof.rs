//! What is proved of a query while it is searched, and whether that is enough to stop. Not the
//! search that closes the gap.

use super::branch_and_bound::Branches;
use super::combined::{BoundScratch, Splits, lower_bound};
use crate::collision::CheckScratch;
use crate::metric::Anchor;
use crate::query::context::Context;
use crate::query::options::Effort;
use crate::scene::{MetricKind, PairId};

/// What is proved of a query, or of the group that is searched, and memory for it.
#[derive(Default)]
pub struct Proof {
    /// Share of the depth that need not be proved, if that ends the search.
    pub gap: Option<f64>,
    /// The pairs that have to part.
    pub colliding: Vec<PairId>,
    /// How closely bounds look.
    splits: Option<Splits>,
    /// Nothing free is nearer.
    proved: f64,
    /// The depth when that was told.
    told_at: f64,
    scratch: BoundScratch,
    /// For branch and bound.
    pub branches: Branches,
}

/// A bound is told anew once an exit is nearer than this share: bounds on what bends are of all
/// that is as near as it.
const NEARER: f64 = 0.8;

/// How closely bounds look at directions.
const SPLITS: Splits = Splits { pairs: 2, each: 80 };
/// The same if searches are long.
const CLOSE_SPLITS: Splits = Splits { pairs: 8, each: 192 };

impl Proof {
    /// Begins a query; `gap` if that ends its search.
    pub fn begin(&mut self, effort: Effort, gap: Option<f64>) {
        self.gap = gap;
        self.splits = (effort != Effort::Nearest).then_some(SPLITS);
        self.begin_group(std::iter::empty());
    }

    /// Looks more closely from now on, and ends the search at another gap.
    pub fn look_closely(&mut self, gap: Option<f64>) {
        (self.gap, self.splits, self.told_at) = (gap, Some(CLOSE_SPLITS), f64::INFINITY);
    }

    /// Begins anew, with the pairs that have to part.
    pub fn begin_group(&mut self, colliding: impl Iterator<Item = PairId>) {
        (self.proved, self.told_at) = (0.0, f64::INFINITY);
        self.set_colliding(colliding);
    }

    /// Says which pairs have to part, of which something may have been proved.
    pub fn set_colliding(&mut self, colliding: impl Iterator<Item = PairId>) {
        self.colliding.clear();
        self.colliding.extend(colliding);
    }

    /// What was proved so far, if anything was.
    pub fn told(&self) -> Option<f64> {
        self.told_at.is_finite().then_some(self.proved)
    }

    /// Takes over what was proved of each group, at this depth of them all.
    pub fn take_groups(&mut self, kind: MetricKind, bounds: &[f64], depth: f64) {
        self.told_at = depth;
        self.proved = match kind {
            MetricKind::Joint => bounds.iter().map(|bound| bound * bound).sum::<f64>().sqrt(),
            _ => bounds.iter().copied().fold(0.0, f64::max),
        };
    }

    /// Takes over what something else proves.
    pub fn raise(&mut self, bound: f64) {
        self.proved = self.proved.max(bound);
    }

    /// What is proved at a depth, which is its most.
    pub fn bound(&mut self, context: &Context, anchor: &Anchor, depth: f64, check: &mut CheckScratch) -> f64 {
        if depth < NEARER * self.told_at {
            let how = (self.splits, depth);
            let bound = lower_bound(context, anchor, &self.colliding, how, &mut self.scratch, check);
            (self.proved, self.told_at) = (self.proved.max(bound), depth);
        }
        self.proved.min(depth)
    }

    /// Whether what is proved at a depth leaves no more than the gap that was requested.
    pub fn is_enough(&mut self, context: &Context, anchor: &Anchor, depth: f64, check: &mut CheckScratch) -> bool {
        let Some(gap) = self.gap else { return false };
        self.bound(context, anchor, depth, check) >= (1.0 - gap) * depth
    }
}

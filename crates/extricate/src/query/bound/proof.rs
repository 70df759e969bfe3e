//! What is proved of a query while it is searched, and whether that is enough to stop. Not the
//! search that closes the gap.

use super::branch_and_bound::Branches;
use super::combined::{BoundScratch, Splits, lower_bound};
use crate::collision::CheckScratch;
use crate::metric::Anchor;
use crate::query::context::Context;
use crate::query::options::Effort;
use crate::scene::PairId;

/// What is proved of a query while it is searched.
#[derive(Default)]
pub struct Proof {
    /// Share of the depth that need not be proved, where that ends the search.
    pub gap: Option<f64>,
    /// The pairs that collide at the query.
    pub colliding: Vec<PairId>,
    /// How closely bounds look.
    splits: Option<Splits>,
    /// Nothing free is nearer.
    pub proved: f64,
    /// The incumbent's depth when that was told.
    told_at: f64,
    scratch: BoundScratch,
    /// Of branch and bound.
    pub branches: Branches,
}

/// A bound is told anew once the incumbent is nearer than this share: bounds on what bends are of
/// all that is as near as it.
const NEARER: f64 = 0.8;

/// How closely bounds look at directions: where searches are long, much.
fn splits(effort: Effort) -> Option<Splits> {
    match effort {
        Effort::Nearest => None,
        Effort::Refined => Some(Splits { pairs: 2, each: 80 }),
        Effort::Exhaustive | Effort::Proved => Some(Splits { pairs: 8, each: 192 }),
    }
}

impl Proof {
    /// Begins a query at which the pairs collide; `gap` where that ends the search.
    pub fn begin(&mut self, effort: Effort, colliding: &[PairId], gap: Option<f64>) {
        (self.gap, self.splits) = (gap, splits(effort));
        (self.proved, self.told_at) = (0.0, f64::INFINITY);
        self.colliding.clear();
        self.colliding.extend_from_slice(colliding);
    }

    /// What is proved of an answer, its depth at most.
    pub fn bound(
        &mut self,
        context: &Context,
        anchor: &Anchor,
        (depth, colliding): (f64, &[PairId]),
        check: &mut CheckScratch,
    ) -> f64 {
        if depth < NEARER * self.told_at {
            let how = (self.splits, depth);
            let bound = lower_bound(context, anchor, colliding, how, &mut self.scratch, check);
            (self.proved, self.told_at) = (self.proved.max(bound), depth);
        }
        self.proved.min(depth)
    }

    /// Whether what is proved of an answer leaves no more than the gap that was requested.
    pub fn is_enough(&mut self, context: &Context, anchor: &Anchor, depth: f64, check: &mut CheckScratch) -> bool {
        let Some(gap) = self.gap else { return false };
        let colliding = std::mem::take(&mut self.colliding);
        let proved = self.bound(context, anchor, (depth, &colliding), check);
        self.colliding = colliding;
        proved >= (1.0 - gap) * depth
    }
}

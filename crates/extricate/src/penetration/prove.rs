//! Stopping because it is done: what is proved meanwhile, and branch and bound until the gap is
//! closed.

use super::certificate::bound::{BoundScratch, Splits, lower_bound};
use super::certificate::branches::{Branches, Step};
use super::certificate::groups::Groups;
use super::context::Context;
use super::descent::Start;
use super::options::Effort;
use super::search::Search;
use crate::collision::CheckScratch;
use crate::cspace::Label;
use crate::metric::Anchor;

/// What is proved of a query while it is searched.
#[derive(Default)]
pub struct Proof {
    /// Share of the depth that need not be proved, where that ends the search.
    gap: Option<f64>,
    /// The pairs that collide at the query.
    colliding: Vec<usize>,
    /// How closely bounds look.
    splits: Option<Splits>,
    /// Nothing free is nearer.
    proved: f64,
    /// The incumbent's depth when that was told.
    told_at: f64,
    scratch: BoundScratch,
    branches: Branches,
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
    pub fn begin(&mut self, effort: Effort, colliding: &[usize], gap: Option<f64>) {
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
        (depth, colliding): (f64, &[usize]),
        check: &mut CheckScratch,
    ) -> f64 {
        if depth < NEARER * self.told_at {
            let how = (self.splits, depth);
            let bound = lower_bound(context, anchor, colliding, how, &mut self.scratch, check);
            (self.proved, self.told_at) = (self.proved.max(bound), depth);
        }
        self.proved.min(depth)
    }
}

impl Search<'_> {
    /// Whether what is proved leaves no more than the gap that was asked for.
    pub fn is_proved(&mut self) -> bool {
        let Some(gap) = self.known.proof.gap.filter(|_| self.known.incumbent.verified) else { return false };
        let depth = self.known.incumbent.depth;
        let known = &mut *self.known;
        let colliding = std::mem::take(&mut known.proof.colliding);
        let proved = known.proof.bound(self.context, &known.anchor, (depth, &colliding), &mut self.evaluator.check);
        known.proof.colliding = colliding;
        proved >= (1.0 - gap) * depth
    }

    /// Branch and bound until the gap is closed, the budget is spent or nothing can be expanded.
    pub fn prove(&mut self) {
        if self.is_proved() || !Branches::can_search(self.context) || !self.known.incumbent.verified {
            return;
        }
        let Some(gap) = self.known.proof.gap else { return };
        let mut branches = std::mem::take(&mut self.known.proof.branches);
        let mut groups = Groups::default();
        groups.split(self.context, &self.known.proof.colliding);
        if groups.count() > 1 {
            self.prove_groups(&groups, gap, &mut branches);
        }
        if !self.is_proved() {
            let bound = self.branch(&mut branches, None, gap);
            self.known.proof.proved = self.known.proof.proved.max(bound);
        }
        self.known.proof.branches = branches;
    }

    /// Each group of pairs by itself, while the others stay where the incumbent has them: their
    /// squares add.
    fn prove_groups(&mut self, groups: &Groups, gap: f64, branches: &mut Branches) {
        let mut squared = 0.0;
        for group in 0..groups.count() {
            let holds: Vec<bool> =
                (0..self.context.checker.scene().space.nv()).map(|v| groups.holds(group, v)).collect();
            squared += self.branch(branches, Some(&holds), gap).powi(2);
        }
        self.known.proof.proved = self.known.proof.proved.max(f64::sqrt(squared));
    }

    /// Branch and bound over all coordinates, or some; what it proves.
    fn branch(&mut self, branches: &mut Branches, holds: Option<&[bool]>, gap: f64) -> f64 {
        let (context, q) = (self.context, self.known.anchor.q.clone());
        branches.begin(context, &q, holds, &self.known.incumbent.config);
        // Of the incumbent, what is of these coordinates.
        let mut depth = branches.length(context, &q, &self.known.incumbent.config);
        let mut next = 1;
        while !self.evaluator.is_spent() {
            self.evaluator.checks += 1;
            match branches.step(context, &q, (1.0 - gap) * depth, &mut self.evaluator.check) {
                Step::Closed | Step::Full => break,
                Step::Free(found) => {
                    depth = depth.min(found);
                    self.offer(branches.config());
                }
                // Near what is left there may be exits that no descent has found.
                Step::Open if branches.expanded() >= next => {
                    next *= 2;
                    let ceiling = self.known.incumbent.depth;
                    let config = branches.config().to_vec();
                    if let (Some(found), _) = self.descend_alone(Start::at(&config), ceiling, self.plan.polish) {
                        self.keep(found);
                        depth = depth.min(branches.length(context, &q, &self.known.incumbent.config));
                    }
                }
                Step::Open => {}
            }
        }
        branches.bound()
    }

    /// Makes a configuration the incumbent if it is free and nearer.
    fn offer(&mut self, config: &[f64]) {
        let depth = self.evaluator.distance(self.context, &self.known.anchor, config);
        if depth < self.known.incumbent.depth && self.evaluator.label(self.context, config) == Label::Free {
            self.known.take(depth, config, true);
        }
    }
}

//! The descents of a search, each of which has to beat the nearest exit so far. Where they start is
//! in `run`.

pub mod directions;
pub mod grouped;
pub mod known;
pub mod polish;
pub mod prove;
pub mod run;
pub mod scratch;
pub mod sources;
pub mod stored;

use super::context::Context;
use super::descent::prune::Pruning;
use super::descent::{DescentOptions, DescentScratch, Outcome, Start, descend};
use super::evaluate::Evaluator;
use super::plan::Plan;
use crate::cspace::Label;
use crate::samples::BoundaryScratch;
use known::Known;
use scratch::QueryScratch;

/// Which starts a frame of a stream tries, if the exit of the last frame led to one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turn {
    /// The one that is tried first; then that of the next frame.
    pub next: usize,
    /// How many may cost checks.
    pub left: usize,
}

/// What is known before a query.
#[derive(Default)]
pub struct Hint<'a> {
    /// A configuration that may be free; empty if there is none.
    pub config: &'a [f64],
    /// Whether a search whose descents find nothing does not look for anything free.
    pub looks_nowhere_else: bool,
    /// Whether only a witness is wanted: no default gap ends the search then, as what would have to
    /// be proved takes longer than it spares.
    pub is_unproved: bool,
    /// In a stream, which starts are tried beside where a descent from it leads; then those of the
    /// next frame.
    pub turn: Option<Turn>,
    /// Distance and end of that descent, if it came to an exit.
    pub followed: Option<(f64, Vec<f64>)>,
}

/// The search of one group: what it stands on, how far it goes, what it works with.
pub struct Search<'a> {
    pub context: &'a Context<'a>,
    pub plan: Plan,
    pub known: &'a mut Known,
    pub evaluator: &'a mut Evaluator,
    pub descent: &'a mut DescentScratch,
    pub boundary: &'a mut BoundaryScratch,
    /// Whether descents are believed for what they see of the pieces around meshes, until the last
    /// one.
    pub believes: bool,
    /// Set in a stream.
    pub turn: Option<Turn>,
}

impl<'a> Search<'a> {
    /// A search over all joints that are not locked.
    pub fn whole(context: &'a Context<'a>, plan: Plan, scratch: &'a mut QueryScratch) -> Self {
        let QueryScratch { evaluator, descent, boundary, known, .. } = scratch;
        Self { context, plan, known, evaluator, descent, boundary, believes: false, turn: None }
    }

    /// Whether nothing is left to look for: the budget is spent, or the depth is proved up to the
    /// gap.
    pub fn is_over(&mut self) -> bool {
        let has_exit = self.known.exits.len() > 0;
        self.evaluator.is_spent() || has_exit && (self.plan.takes_first || self.is_proved())
    }

    /// Whether what is proved of the group leaves no more than the gap.
    pub fn is_proved(&mut self) -> bool {
        let Known { proof, anchor, exits, .. } = &mut *self.known;
        proof.is_enough(self.context, anchor, exits.depth(), &mut self.evaluator.check)
    }

    /// Slides the exit of the last frame along: mostly it still is the nearest. It is the hint of
    /// all groups then, and others are given up early.
    pub fn follow(&mut self, exit: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut start = exit.to_vec();
        self.context.hold(&self.known.rest, &mut start);
        let depth = self.descend_alone(&start, f64::INFINITY, self.plan.descent)?;
        self.known.hint.extend_from_slice(&self.descent.best);
        Some((depth, self.descent.best.clone()))
    }

    /// A descent that has to beat the nearest exit, or the last of those that are wanted; how deep
    /// it came, if it found one.
    pub fn try_start(&mut self, start: Start) -> Option<f64> {
        self.known.tried += 1;
        let (checks, ceiling) = (self.evaluator.checks, self.known.ceiling());
        let pruning = Pruning { incumbent: ceiling, factor: self.plan.prune_factor, exits: Some(&self.known.exits) };
        let anchor = &self.known.anchor;
        let (found, outcome) =
            descend(self.context, anchor, start, pruning, &self.plan.descent, self.descent, self.evaluator);
        let has_ended = outcome == Outcome::Ended && self.evaluator.checks > checks;
        match found {
            Some(depth) => self.keep(depth, has_ended),
            None if has_ended => self.note_stuck(),
            None => {}
        }
        found
    }

    /// The same, whatever other descents led to.
    pub fn descend_alone(&mut self, start: &[f64], ceiling: f64, options: DescentOptions) -> Option<f64> {
        let pruning = Pruning { factor: self.plan.prune_factor, ..Pruning::alone(ceiling) };
        let anchor = &self.known.anchor;
        descend(self.context, anchor, Start::at(start), pruning, &options, self.descent, self.evaluator).0
    }

    /// Keeps what a descent found. The exact checker verifies what would be the nearest exit. Along
    /// meshes a descent is believed until the last one, which looks at the meshes themselves.
    pub fn keep(&mut self, depth: f64, is_last: bool) {
        let is_nearest = depth < self.known.exits.depth();
        let is_verified =
            is_nearest && !self.believes && self.evaluator.label(self.context, &self.descent.best) == Label::Free;
        if is_nearest && !self.believes && !is_verified {
            return;
        }
        let Known { exits, local, wanted, .. } = &mut *self.known;
        let space = &self.context.checker.scene().space;
        exits.offer((space, local), (depth, &self.descent.best), (is_verified, is_last));
        self.evaluator.note_exits(exits.len(), *wanted);
    }

    /// Notes where a descent ended that found no exit.
    fn note_stuck(&mut self) {
        let distance = self.evaluator.distance(self.context, &self.known.anchor, &self.descent.end);
        let Known { exits, local, stuck, .. } = &mut *self.known;
        *stuck += 1;
        exits.note_stuck((&self.context.checker.scene().space, local), (distance, &self.descent.end));
    }

    /// Takes in the query as it is within the limits, which is free.
    pub fn take_rest(&mut self) {
        let rest = self.known.rest.clone();
        self.offer_free(&rest);
    }

    /// Takes in a configuration that the exact checker just called free.
    pub fn offer_free(&mut self, config: &[f64]) {
        self.offer(config, true, false);
    }

    /// Takes in a configuration that is free as far as is known, said by the exact checker if it
    /// `is_verified`, the end of a descent if it `is_last`.
    pub fn offer(&mut self, config: &[f64], is_verified: bool, is_last: bool) {
        let depth = self.evaluator.distance(self.context, &self.known.anchor, config);
        let Known { exits, local, wanted, .. } = &mut *self.known;
        exits.offer((&self.context.checker.scene().space, local), (depth, config), (is_verified, is_last));
        self.evaluator.note_exits(exits.len(), *wanted);
    }
}

//! Descents of a search, each of which has to beat the nearest exit so far. `run` chooses their
//! starts.

pub mod directions;
pub mod grouped;
mod kept;
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

/// Starts that a frame of a stream tries once a descent from the last frame's exit has succeeded.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turn {
    /// Number of the first start; after the search, that of the next frame.
    pub next: usize,
    /// Number of starts that may still cost checks.
    pub left: usize,
}

/// Advance knowledge about a query, and requests of its caller.
#[derive(Default)]
pub struct Hint<'a> {
    /// A configuration that may be free; empty if there is none.
    pub config: &'a [f64],
    /// Whether a search gives up if its descents find nothing, instead of taking a stored sample or
    /// any free configuration.
    pub looks_nowhere_else: bool,
    /// Whether only a witness is wanted. No default gap then ends the search, since proving it
    /// takes longer than it saves.
    pub is_unproved: bool,
    /// In a stream, the starts of this frame besides `config`; after the search, those of the next
    /// frame.
    pub turn: Option<Turn>,
    /// In a stream, depth and configuration of the exit to which the descent from `config` led.
    pub followed: Option<(f64, Vec<f64>)>,
}

/// The search of one group: its context and plan, its state and its memory.
pub struct Search<'a> {
    pub context: &'a Context<'a>,
    pub plan: Plan,
    pub known: &'a mut Known,
    pub evaluator: &'a mut Evaluator,
    pub descent: &'a mut DescentScratch,
    pub boundary: &'a mut BoundaryScratch,
    /// Whether exits count as free by the convex pieces around meshes, without an exact check.
    /// Polishing ends this.
    pub believes: bool,
    pub turn: Option<Turn>,
}

impl<'a> Search<'a> {
    /// Prepares a search over all joints that are not locked.
    pub fn whole(context: &'a Context<'a>, plan: Plan, scratch: &'a mut QueryScratch) -> Self {
        let QueryScratch { evaluator, descent, boundary, known, .. } = scratch;
        Self { context, plan, known, evaluator, descent, boundary, believes: false, turn: None }
    }

    /// Returns whether the search may end: the budget is spent, the depth is proved up to the gap,
    /// or any exit is enough and one is known.
    pub fn is_over(&mut self) -> bool {
        let has_exit = self.known.exits.len() > 0;
        self.evaluator.is_spent() || has_exit && (self.plan.takes_first || self.is_proved())
    }

    /// Returns whether the depth of the group is proved up to the gap.
    pub fn is_proved(&mut self) -> bool {
        let Known { proof, anchor, exits, .. } = &mut *self.known;
        proof.is_enough(self.context, anchor, exits.depth(), &mut self.evaluator.check)
    }

    /// Descends from the last frame's exit. It usually stays the nearest; as the hint of every
    /// group it then prunes most other starts.
    pub fn follow(&mut self, exit: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut start = exit.to_vec();
        self.context.hold(&self.known.rest, &mut start);
        let depth = self.descend_alone(&start, f64::INFINITY, self.plan.descent)?;
        self.known.hint.extend_from_slice(&self.descent.best);
        Some((depth, self.descent.best.clone()))
    }

    /// Descends from a start that has to beat the nearest exit, or the last of those that are
    /// wanted. Returns the depth of the exit that it found.
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

    /// Descends from a start that only has to beat `ceiling`, even if it leads to a known end.
    pub fn descend_alone(&mut self, start: &[f64], ceiling: f64, options: DescentOptions) -> Option<f64> {
        let pruning = Pruning { factor: self.plan.prune_factor, ..Pruning::alone(ceiling) };
        let anchor = &self.known.anchor;
        descend(self.context, anchor, Start::at(start), pruning, &options, self.descent, self.evaluator).0
    }

    /// Keeps the exit that the last descent found. If it would be the nearest, the exact checker
    /// has to verify it, unless the search `believes`.
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

    /// Notes the end of a descent that found no exit.
    fn note_stuck(&mut self) {
        let distance = self.evaluator.distance(self.context, &self.known.anchor, &self.descent.end);
        let Known { exits, local, stuck, .. } = &mut *self.known;
        *stuck += 1;
        exits.note_stuck((&self.context.checker.scene().space, local), (distance, &self.descent.end));
    }

    /// Offers the query moved onto the limits, which is free.
    pub fn take_rest(&mut self) {
        let rest = self.known.rest.clone();
        self.offer_free(&rest);
    }

    /// Offers a configuration that the exact checker just called free.
    pub fn offer_free(&mut self, config: &[f64]) {
        self.offer(config, true, false);
    }

    /// Offers an exit. It `is_verified` if the exact checker called it free, and `is_last` if a
    /// descent ended there by itself.
    pub fn offer(&mut self, config: &[f64], is_verified: bool, is_last: bool) {
        let depth = self.evaluator.distance(self.context, &self.known.anchor, config);
        let Known { exits, local, wanted, .. } = &mut *self.known;
        exits.offer((&self.context.checker.scene().space, local), (depth, config), (is_verified, is_last));
        self.evaluator.note_exits(exits.len(), *wanted);
    }
}

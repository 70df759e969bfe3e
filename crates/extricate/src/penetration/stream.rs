//! Queries that come one after the other from nearly the same place, as from a simulation or a haptic device.

use super::answer::Answer;
use super::constraints::under;
use super::context::Context;
use super::descent::Start;
use super::exits::are_alike;
use super::options::{Effort, QueryOptions};
use super::plan::Plan;
use super::report::report;
use super::search::{Known, Search};
use super::{QueryScratch, find};
use crate::cspace::{Config, Label};

/// Options of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamOptions {
    /// Of each query; a stream gives one exit a frame, so `exits` is not looked at.
    pub query: QueryOptions,
    /// The exit of the last frame is kept until another one is nearer by more than this share of
    /// its depth, in `[0, 1)`: 0 always takes the nearest, 0.1 keeps directions from flipping
    /// between two exits that are about as near.
    pub hysteresis: f64,
    /// How many of the boundary samples that a single query would start from are looked at each frame, in turn; those that what is known of them
    /// rules out cost nothing and do not count.
    pub looks: usize,
}

impl Default for StreamOptions {
    /// No hysteresis, four looks.
    fn default() -> Self {
        Self { query: QueryOptions::default(), hysteresis: 0.0, looks: 4 }
    }
}

/// What is carried from one query to the next, and memory. It belongs to no model: asked of another one, it begins anew.
#[derive(Default)]
pub struct Stream {
    options: StreamOptions,
    scratch: QueryScratch,
    lead: Lead,
}

/// What a stream carries into a search.
#[derive(Debug, Clone, Default)]
pub struct Lead {
    /// The exit of the last frame; empty where there is none.
    exit: Vec<f64>,
    nq: usize,
    /// Where it has led in this frame, and how far that is.
    followed: Option<(f64, Vec<f64>)>,
    /// Of the stored samples.
    turn: Turn,
}

/// Which starts are tried in a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turn {
    /// The one that is tried first; then that of the next frame.
    pub next: usize,
    /// How many may cost checks.
    pub looks: usize,
}

impl Lead {
    /// Whether there is nothing to follow.
    pub fn is_empty(&self) -> bool {
        self.exit.is_empty()
    }

    /// Slides the exit of the last frame along: mostly it still is the nearest, and others are then
    /// given up early. The search goes on with as many other starts as may be looked at.
    pub fn follow(&mut self, search: &mut Search) {
        self.followed = None;
        if search.evaluator.is_spent() {
            return;
        }
        search.believes = !search.context.checker.all_convex();
        search.context.hold(&search.known.anchor.q, &mut self.exit);
        let start = Start::at(&self.exit);
        if let (Some(depth), _) = search.descend(start, f64::INFINITY, search.plan.descent) {
            self.followed = Some((depth, search.descent.best.clone()));
            search.known.ends.push(&search.descent.best);
            search.keep(depth);
        }
        search.turn = Some(self.turn);
    }

    /// Notes which start comes next.
    pub fn advance(&mut self, search: &Search) {
        self.turn.next = search.turn.map_or(0, |turn| turn.next);
    }
}

impl Stream {
    /// A stream that has seen nothing.
    pub fn new(options: StreamOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// Forgets the frames so far: the next one is answered as a query on its own.
    pub fn restart(&mut self) {
        self.lead.exit.clear();
        self.lead.turn.next = 0;
    }

    /// The answer for the next frame; `None` only where samples are stale and nothing free was found.
    ///
    /// # Guarantee
    /// That of [`super::query`]. While the query stands still, every start of a refined query is looked at within as many frames
    /// as `looks` goes into their number.
    pub(crate) fn query(&mut self, context: &Context, q: &Config) -> Option<Answer> {
        let options = QueryOptions { exits: 0, ..self.options.query.clone() };
        if self.lead.nq != q.len() {
            self.restart();
            self.lead.nq = q.len();
        }
        under(context, &options, |context| self.ask(context, q, &options))
    }

    fn ask(&mut self, context: &Context, q: &Config, options: &QueryOptions) -> Option<Answer> {
        self.lead.turn.looks = self.options.looks;
        self.lead.followed = None;
        let lead = (options.effort == Effort::Refined).then_some(&mut self.lead);
        let plan = Plan::of(options, context);
        let mut answer = find(context, q, (options, plan), lead, &mut self.scratch)?;
        if answer.is_free() {
            return Some(answer);
        }
        self.keep_to_last(context, options, &mut answer);
        self.lead.exit.clear();
        if answer.verified {
            self.lead.exit.extend_from_slice(&answer.witness);
        }
        report(context, options, &mut self.scratch, &mut answer);
        Some(answer)
    }

    /// Keeps to the exit of the last frame, unless another is nearer by more than the hysteresis.
    fn keep_to_last(&mut self, context: &Context, options: &QueryOptions, answer: &mut Answer) {
        let Self { scratch, lead, options: StreamOptions { hysteresis, .. } } = self;
        let QueryScratch { evaluator, descent, boundary, known, .. } = scratch;
        let space = &context.checker.scene().space;
        let Some((depth, witness)) = &lead.followed else { return };
        let hysteresis = *hysteresis;
        let is_nearer = |depth: f64| answer.depth < depth && answer.depth >= (1.0 - hysteresis) * depth;
        let found = (answer.depth, &answer.witness[..]);
        if !is_nearer(*depth) || are_alike(space, &mut known.local, (*depth, witness), found) {
            return;
        }
        let plan = Plan::of(options, context);
        let mut search =
            Search { context, plan, known, evaluator, descent, boundary, believes: false, part: None, turn: None };
        let (last, _) = search.descend_alone(Start::at(witness), f64::INFINITY, plan.polish);
        if let Some(last) = last.filter(|last| is_nearer(*last))
            && search.evaluator.label(context, &search.descent.best) == Label::Free
        {
            let Known { exits, local, .. } = search.known;
            exits.offer(space, local, answer.depth, &answer.witness);
            (answer.depth, answer.verified) = (last, true);
            answer.witness.copy_from_slice(&search.descent.best);
        }
    }
}

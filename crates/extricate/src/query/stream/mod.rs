//! Queries that come one after the other from nearly the same place, as from a simulation or a
//! haptic device.

mod proxy;

use super::answer::{Answer, TOUCHING};
use super::context::Context;
use super::descent::Start;
use super::find;
use super::options::{Effort, QueryOptions};
use super::plan::Plan;
use super::report::report;
use super::search::evaluate::Evaluator;
use super::search::exits::are_alike;
use super::search::lead::Lead;
use super::search::scratch::QueryScratch;
use super::search::{Known, Search};
use super::worlds::constraints::under;
use crate::cspace::{Config, Label};
use proxy::{Proxy, ROOM};

/// Options of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamOptions {
    /// Of each query; a stream gives one exit a frame, so `exits` has no effect.
    pub query: QueryOptions,
    /// The exit of the last frame is kept until another one is nearer by more than this share of
    /// its depth, in `[0, 1)`: 0 always takes the nearest, 0.1 keeps directions from flipping
    /// between two exits that are about as near.
    pub hysteresis: f64,
    /// How many descents start from stored samples each frame: those of a single query, in turn.
    /// Samples that their contact planes rule out cost nothing and do not count; those that are too
    /// far for a descent count.
    pub starts_per_frame: usize,
    /// Whether the witness is a proxy that never jumps: from frame to frame it only moves where
    /// every configuration on its way is proved free. It may then be held behind something while
    /// another exit is nearer ([`Answer::nearest`]), or while the query is free. It aims at
    /// the clearance of `query`, by default 0.5 mm more than the scene's, and `hysteresis` has no
    /// effect.
    pub continuous: bool,
}

impl Default for StreamOptions {
    /// No hysteresis, four starts a frame.
    fn default() -> Self {
        Self { query: QueryOptions::default(), hysteresis: 0.0, starts_per_frame: 4, continuous: false }
    }
}

/// Least room that a proxy aims at \[m\]: with less, its moves along contacts are not proved.
const LEAST_ROOM: f64 = 1e-4;

/// What is carried from one query to the next, and memory. It belongs to no model: used with
/// another one, it begins anew.
#[derive(Default)]
pub struct Stream {
    options: StreamOptions,
    scratch: QueryScratch,
    lead: Lead,
    proxy: Proxy,
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
        self.proxy.config.clear();
    }

    /// The answer for the next frame; `None` only where samples are stale and nothing free was
    /// found.
    ///
    /// # Guarantee
    /// That of [`super::query`]. While the query stands still, every start of a refined query is
    /// tried within as many frames as `starts_per_frame` goes into their number.
    pub(crate) fn query(&mut self, context: &Context, q: &Config) -> Option<Answer> {
        let options = QueryOptions { exits: 0, ..self.options.query.clone() };
        if self.lead.nq != q.len() {
            self.restart();
            self.lead.nq = q.len();
        }
        if self.options.continuous {
            return self.follow(context, q, &options);
        }
        under(context, &options, |context| {
            let mut answer = self.search(context, q, &options)?;
            if !answer.is_free() {
                report(context, &options, &mut self.scratch, &mut answer);
            }
            Some(answer)
        })
    }

    /// The exit of this frame, of which nothing is said yet.
    fn search(&mut self, context: &Context, q: &Config, options: &QueryOptions) -> Option<Answer> {
        self.lead.turn.starts_per_frame = self.options.starts_per_frame;
        self.lead.followed = None;
        let lead = (options.effort == Effort::Refined).then_some(&mut self.lead);
        let plan = Plan::of(options, context);
        let mut answer = find(context, q, (options, plan), lead, &mut self.scratch)?;
        if !answer.is_free() {
            self.keep_to_last(context, options, &mut answer);
            self.lead.exit.clear();
            if answer.verified {
                self.lead.exit.extend_from_slice(&answer.witness);
            }
        }
        Some(answer)
    }

    /// The nearest exit, and where the proxy goes.
    fn follow(&mut self, context: &Context, q: &Config, options: &QueryOptions) -> Option<Answer> {
        let aim = options.clearance.unwrap_or(context.clearance + ROOM).max(context.clearance + LEAST_ROOM);
        let own = QueryOptions { clearance: None, ..options.clone() };
        under(context, &own, |context| {
            let mut answer = self.search(context, q, &own)?;
            answer.nearest = Some(answer.depth);
            if self.proxy.config.is_empty() || !self.proxy_is_free(context) {
                self.proxy.config.clone_from(&answer.witness);
            }
            let Self { scratch, proxy, .. } = self;
            let QueryScratch { evaluator, known, .. } = scratch;
            context.metric.anchor(q, &mut known.anchor);
            let aimed_checker = context.checker.with_clearance(aim);
            let aimed = Context { checker: &aimed_checker, clearance: aim, ..*context };
            proxy.follow(context, &aimed, &known.anchor, evaluator);
            answer.witness.copy_from_slice(&proxy.config);
            answer.depth = evaluator.distance(context, &known.anchor, &answer.witness);
            answer.verified = evaluator.label(context, &answer.witness) == Label::Free;
            answer.checks = evaluator.checks;
            if answer.is_free() && answer.depth > 0.0 {
                let metric = &mut evaluator.metric;
                answer.max_displacement = context.metric.max_displacement_from(&known.anchor, &answer.witness, metric);
            } else if answer.depth > 0.0 {
                report(context, &own, scratch, &mut answer);
                // It stands off by what it aims at.
                touches(&aimed, &mut scratch.evaluator, &mut answer);
            }
            Some(answer)
        })
    }

    /// Whether the proxy keeps the clearance in this frame's scene, in which something may have
    /// moved onto it.
    fn proxy_is_free(&mut self, context: &Context) -> bool {
        self.scratch.evaluator.label(context, &self.proxy.config) == Label::Free
    }

    /// Keeps to the exit of the last frame, unless another is nearer by more than the hysteresis.
    fn keep_to_last(&mut self, context: &Context, options: &QueryOptions, answer: &mut Answer) {
        let Self { scratch, lead, options: StreamOptions { hysteresis, .. }, .. } = self;
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

/// Says what touches at the witness under the clearance of `aimed`.
fn touches(aimed: &Context, evaluator: &mut Evaluator, answer: &mut Answer) {
    answer.contacts.clear();
    answer.contacts.extend_from_slice(evaluator.touching(aimed, &answer.witness, aimed.clearance + TOUCHING));
    answer.contacts.iter_mut().for_each(|contact| contact.distance += aimed.checker.excess(contact.pair.index()));
    answer.touching.clear();
    answer.touching.extend(answer.contacts.iter().map(|contact| contact.pair));
    answer.touching.dedup();
}

//! Queries that follow each other closely, as those of a simulation or a haptic device.

use super::detour::Detour;
use super::proxy::{DEFAULT_MARGIN_M, Proxy, is_free};
use crate::cspace::{Config, Label};
use crate::error::{Error, Result};
use crate::interface::setters;
use crate::query::answer::TOUCHING;
use crate::query::constraints::{push_nearby, under};
use crate::query::evaluate::Evaluator;
use crate::query::exits::are_alike;
use crate::query::nearest_exit::find;
use crate::query::plan::Plan;
use crate::query::report::report;
use crate::query::search::{Hint, Search, Turn};
use crate::query::{Answer, Context, Effort, QueryOptions, QueryScratch, Termination, TouchingPairs};
use crate::scene::PairId;

/// Options of a stream.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamOptions {
    /// The exit of the last frame is kept until another one is nearer by more than this share of
    /// its depth, in `[0, 1)`. 0 always takes the nearest; 0.1 keeps directions from flipping
    /// between two exits that are about as near.
    pub hysteresis: f64,
    /// Number of starts that a frame tries besides the last exit. Frames go through the starts of a
    /// single query one after another: the stored samples, then those around the query. A start
    /// that its contact planes prune costs nothing and does not count; every other start counts.
    pub starts_per_frame: usize,
    /// Whether the witness is a proxy that never jumps: from frame to frame it only moves where
    /// every configuration on its way is proved free. It may then be held behind an obstacle while
    /// another exit is nearer ([`Answer::nearest`]), or while the query is free. If that lasts, it
    /// goes back along a path that is proved free ([`Answer::detour`]). If links are kept
    /// ([`QueryOptions::keep`]), it takes no detours. A frame in which it cannot keep them has no
    /// answer, and the next one begins anew. It aims at [`QueryOptions::clearance`], by default 0.5
    /// mm more than the scene's, and `hysteresis` has no effect.
    pub continuous: bool,
}

setters! {
    StreamOptions {
        hysteresis: f64,
        starts_per_frame: usize,
        continuous: bool,
    }
}

impl StreamOptions {
    /// Checks that every option has an allowed value.
    ///
    /// # Errors
    /// [`Error::Option`], which names the option, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        if (0.0..1.0).contains(&self.hysteresis) {
            return Ok(());
        }
        let (value, expected) = (self.hysteresis.to_string(), "0 or more and less than 1".into());
        Err(Error::Option { name: "hysteresis", value, expected })
    }
}

impl Default for StreamOptions {
    /// Returns options with no hysteresis, two starts a frame and no proxy.
    fn default() -> Self {
        Self { hysteresis: 0.0, starts_per_frame: 2, continuous: false }
    }
}

/// Least distance beyond the scene's clearance that a proxy aims at \[m\]: with less, its moves
/// along contacts are not proved.
const MIN_MARGIN_M: f64 = 1e-4;

/// State that is carried from one query to the next, and memory. It belongs to no scene: each frame
/// may be in another scene of the same joints.
#[derive(Default)]
pub struct Follower {
    options: StreamOptions,
    query: QueryOptions,
    scratch: QueryScratch,
    last: Last,
    proxy: Proxy,
    detour: Detour,
    /// Longest move of the proxy in a frame (metric units).
    max_move: Option<f64>,
    /// Pairs that the proxy keeps in touch, if it can.
    held: Vec<PairId>,
    /// Largest distance of a held pair beyond the clearance \[m\].
    touch: f64,
}

/// Results of a frame that the next one uses.
#[derive(Debug, Clone, Default)]
struct Last {
    /// Exit of the frame; empty if there is none.
    exit: Vec<f64>,
    /// Number of coordinates of a query.
    nq: usize,
    /// Number of the start that the next frame tries first.
    next: usize,
}

impl Last {
    /// Keeps the exit of a frame for the next one to follow.
    fn keep(&mut self, answer: &Answer) {
        if !answer.is_free() {
            self.exit.clear();
            if answer.verified {
                self.exit.extend_from_slice(&answer.witness);
            }
        }
    }
}

impl Follower {
    /// Creates a follower before its first frame. A frame has one answer: `exits` has no effect.
    pub fn new(options: StreamOptions, query: QueryOptions) -> Self {
        let query = QueryOptions { exits: 1, ..query };
        let hysteresis = if options.continuous { 0.0 } else { options.hysteresis };
        let options = StreamOptions { hysteresis, ..options };
        Self { options, query, ..Self::default() }
    }

    /// Forgets the frames so far: the next one is answered as a single query.
    pub fn restart(&mut self) {
        self.last.exit.clear();
        self.last.next = 0;
        self.proxy.config.clear();
        self.detour.restart();
    }

    /// Limits the budget of each of the next frames.
    pub fn limit(&mut self, termination: Termination) {
        self.query.termination = termination;
    }

    /// Limits how far the proxy moves in each of the next frames (metric units).
    pub fn limit_moves(&mut self, most: f64) {
        self.max_move = Some(most);
    }

    /// Makes the proxy keep these pairs within `touch` \[m\] beyond the clearance in the next
    /// frames, if it can.
    pub fn hold(&mut self, pairs: Vec<PairId>, touch: f64) {
        (self.held, self.touch) = (pairs, touch);
    }

    /// Returns the number of checks of the last frame.
    pub fn checks(&self) -> usize {
        self.scratch.checks()
    }

    /// Answers the next frame; returns `None` if [`super::query`] would, or if the proxy cannot
    /// keep the links.
    ///
    /// # Guarantee
    /// The guarantee of [`super::query`] holds. While the query stands still, successive frames try
    /// all its stored samples and starts around it, `starts_per_frame` at a time.
    pub fn query(&mut self, context: &Context, q: &Config) -> Option<Answer> {
        let options = self.query.clone();
        if self.last.nq != q.len() {
            self.restart();
            self.last.nq = q.len();
        }
        if self.options.continuous {
            return self.follow(context, q, &options);
        }
        let Self { options: own, scratch, last, .. } = self;
        let next = last.next;
        let mut answer = under(context, q, &options, scratch, |context, options, hint, scratch| {
            // A frame may be searched with several clearances; each search begins at the same
            // start.
            last.next = next;
            let mut answer = search(context, q, (own, options), last, hint, scratch)?;
            if !answer.is_free() {
                report(context, options, scratch, &mut answer);
            }
            Some(answer)
        })?;
        last.keep(&answer);
        answer.checks = scratch.checks();
        Some(answer)
    }

    /// Searches the nearest exit and moves the proxy, which is the witness of the answer.
    fn follow(&mut self, context: &Context, q: &Config, options: &QueryOptions) -> Option<Answer> {
        let aim =
            options.clearance.unwrap_or(context.clearance + DEFAULT_MARGIN_M).max(context.clearance + MIN_MARGIN_M);
        let asked = QueryOptions { clearance: None, ..options.clone() };
        let Self { options: own, scratch, last, proxy, detour, max_move, held, touch, .. } = self;
        under(context, q, &asked, scratch, |context, options, hint, scratch| {
            let mut answer = search(context, q, (own, options), last, hint, scratch)?;
            last.keep(&answer);
            answer.nearest = Some(answer.depth);
            context.metric.anchor(q, &mut scratch.known.anchor);
            // In this frame's scene something may have moved onto the proxy.
            if proxy.config.is_empty() || !is_free(context, &proxy.config, &mut scratch.evaluator) {
                proxy.config = kept_nearby(context, aim, &answer.witness, scratch);
                detour.restart();
            }
            let exit = answer.witness.to_vec();
            let before = proxy.config.clone();
            let QueryScratch { evaluator, known, .. } = scratch;
            let target = detour.next(context, &proxy.config, *max_move);
            let is_walked = target.is_some_and(|target| proxy.goes_some_way(context, aim, target, evaluator));
            let clearance = if is_walked {
                detour.pass(&proxy.config);
                aim
            } else {
                detour.drop_path();
                let most = context.clearance + *touch;
                let touching = TouchingPairs { pairs: held, most, aim: most, are_required: false };
                proxy.follow(&Context { touching, ..*context }, aim, &known.anchor, evaluator)
            };
            if let Some(most) = *max_move {
                proxy.move_at_most(context, &before, most, evaluator);
            }
            answer.witness.set(&proxy.config);
            answer.depth = evaluator.distance(context, &known.anchor, &answer.witness);
            let keeps_links = !context.kept.is_empty();
            if !keeps_links
                && detour.is_due(context, answer.depth, answer.nearest.unwrap_or(0.0))
                && !evaluator.is_spent()
            {
                let goal = kept_nearby(context, aim, &exit, scratch);
                let resolution = 0.5 * (aim - context.clearance);
                detour.search(context, [&proxy.config, &goal], resolution, &mut scratch.evaluator);
            }
            answer.detour = detour.is_walked();
            let QueryScratch { evaluator, known, .. } = scratch;
            answer.verified = evaluator.label(context, &answer.witness) == Label::Free;
            if answer.is_free() && answer.depth > 0.0 {
                let metric = &mut evaluator.metric;
                answer.max_displacement = context.metric.max_displacement_from(&known.anchor, &answer.witness, metric);
            } else if answer.depth > 0.0 {
                report(context, options, scratch, &mut answer);
                // The proxy keeps off by the clearance that it aims at, so contacts are those
                // within it.
                let aimed = context.checker.with_clearance(clearance);
                touches(&Context { checker: &aimed, clearance, ..*context }, &mut scratch.evaluator, &mut answer);
            }
            answer.clearance = kept(context, aim, &answer.witness, &mut scratch.evaluator);
            answer.checks = scratch.checks();
            // A proxy that has lost the links is no answer; the next frame begins anew.
            if keeps_links && !answer.verified {
                proxy.config.clear();
                return None;
            }
            Some(answer)
        })
    }
}

/// Searches the exit of a frame; the report is left to the caller.
fn search(
    context: &Context,
    q: &Config,
    (stream, options): (&StreamOptions, &QueryOptions),
    last: &mut Last,
    hint: Hint,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    let follows = matches!(options.effort, Effort::Quick | Effort::Refined) && !last.exit.is_empty();
    let turn = Turn { next: last.next, left: stream.starts_per_frame };
    let mut hint = match follows && hint.config.is_empty() {
        true => Hint { config: &last.exit, turn: Some(turn), ..hint },
        false => hint,
    };
    let mut answer = find(context, q, options, &mut hint, scratch)?;
    let Hint { turn, followed, .. } = hint;
    last.next = turn.map_or(0, |turn| turn.next);
    if let Some(followed) = followed.filter(|_| !answer.is_free()) {
        keep_to_last(context, (stream.hysteresis, options), &followed, scratch, &mut answer);
    }
    Some(answer)
}

/// Replaces the answer by the end of the descent from the last frame's exit, unless the answer is
/// nearer by more than the hysteresis.
fn keep_to_last(
    context: &Context,
    (hysteresis, options): (f64, &QueryOptions),
    (depth, witness): &(f64, Vec<f64>),
    scratch: &mut QueryScratch,
    answer: &mut Answer,
) {
    let space = &context.checker.scene().space;
    let is_nearer = |depth: f64| answer.depth < depth && answer.depth >= (1.0 - hysteresis) * depth;
    let found = (answer.depth, &answer.witness[..]);
    if !is_nearer(*depth) || are_alike(space, &mut scratch.known.local, (*depth, witness), found) {
        return;
    }
    let plan = Plan::of(options, context);
    let mut search = Search::whole(context, plan, scratch);
    let last = search.descend_alone(witness, f64::INFINITY, plan.polish);
    if let Some(last) = last.filter(|last| is_nearer(*last))
        && search.evaluator.label(context, &search.descent.best) == Label::Free
    {
        search.offer_free(&answer.witness);
        (answer.depth, answer.verified) = (last, true);
        answer.witness.set(&search.descent.best);
    }
}

/// Returns a configuration near the exit that keeps the clearance `aim` \[m\], or as much of it as
/// possible. A move that begins or ends on a contact cannot be proved.
fn kept_nearby(context: &Context, aim: f64, exit: &[f64], scratch: &mut QueryScratch) -> Vec<f64> {
    let anchor = std::mem::take(&mut scratch.known.anchor);
    let pushed = push_nearby(context, &anchor, exit, (aim, false), scratch);
    scratch.known.anchor = anchor;
    pushed.map_or_else(|| exit.to_vec(), |(_, config)| config)
}

/// Returns the clearance that a free witness keeps, at most `aim` \[m\].
fn kept(context: &Context, aim: f64, witness: &[f64], evaluator: &mut Evaluator) -> f64 {
    let checker = context.checker.with_clearance(aim);
    let aimed = Context { checker: &checker, clearance: aim, ..*context };
    if evaluator.label(&aimed, witness) == Label::Free {
        return aim;
    }
    let near = evaluator.touching(&aimed, witness, aim);
    near.iter().map(|contact| contact.distance).fold(aim, f64::min).max(context.clearance)
}

/// Reports the contacts that touch at the witness under the clearance of `aimed`.
fn touches(aimed: &Context, evaluator: &mut Evaluator, answer: &mut Answer) {
    answer.contacts.clear();
    answer.contacts.extend_from_slice(evaluator.touching(aimed, &answer.witness, aimed.clearance + TOUCHING));
    answer.contacts.iter_mut().for_each(|contact| contact.distance += aimed.checker.excess(contact.pair.index()));
    answer.touching.clear();
    answer.touching.extend(answer.contacts.iter().map(|contact| contact.pair));
    answer.touching.dedup();
}

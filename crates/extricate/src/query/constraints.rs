//! Queries with constraints of their own: a clearance, joints and links that stay, or pairs that
//! touch.

use std::time::Instant;

use crate::collision::Checker;
use crate::cspace::Label;
use crate::metric::Anchor;
use crate::query::answer::Answer;
use crate::query::context::{Context, TouchingPairs};
use crate::query::descent::prune::Pruning;
use crate::query::descent::{Start, descend};
use crate::query::keep::LinkConstraint;
use crate::query::options::{QueryOptions, TOUCH_M};
use crate::query::plan::Plan;
use crate::query::search::Hint;
use crate::query::search::scratch::QueryScratch;
use crate::query::termination::{Deadline, Termination};
use crate::scene::{PairId, Scene};

/// An exit at the wanted clearance is too far beyond this multiple of the sum of two distances: the
/// depth at the scene's clearance and the least motion for the difference. It then leaves a narrow
/// place by another way, which nobody wants for a little more clearance.
const MAX_DEPTH_FACTOR: f64 = 10.0;
/// Most halvings of the excess over the scene's clearance, until the rest of it is kept nearby.
pub const MAX_HALVINGS: i32 = 6;

/// Result of a search under constraints.
pub trait SearchResult {
    /// Returns the distance from the query, and the configuration.
    fn nearest(&self) -> (f64, &[f64]);

    /// Notes that a limit ended the search for a larger clearance.
    fn note_cut(&mut self) {}
}

impl SearchResult for Answer {
    fn nearest(&self) -> (f64, &[f64]) {
        (self.depth, &self.witness)
    }

    fn note_cut(&mut self) {
        self.cut_short = true;
    }
}

/// Searches under the constraints of the options. The result keeps the wanted clearance, unless
/// none is found that does, or only one that is too far (`MAX_DEPTH_FACTOR`). It then keeps as much
/// of it as halving finds nearby, at least the scene's. Once the budget is spent, no further search
/// begins. The evaluator then has the checks of all searches.
pub(crate) fn under<T: SearchResult>(
    context: &Context,
    q: &[f64],
    options: &QueryOptions,
    scratch: &mut QueryScratch,
    mut ask: impl FnMut(&Context, &QueryOptions, Hint, &mut QueryScratch) -> Option<T>,
) -> Option<T> {
    let plain = Constraints {
        kept: LinkConstraint::all(context.checker.scene(), &options.keep, q),
        touching: options.touch.clone(),
        ..Constraints::new(context, None, &options.locked)
    };
    let plain = plain.apply(context);
    let Some(aim) = options.clearance.filter(|aim| *aim != context.clearance) else {
        return ask(&plain, options, Hint::default(), scratch);
    };
    // Not every platform has a clock, so read it only for a limit on seconds.
    let began = options.termination.max_seconds.map(|_| Instant::now());
    let mut asking = Asking { context: &plain, options, scratch, ask: &mut ask, began, spent: 0 };
    // If descents find nothing, pushing the exit at the scene's clearance beats trying
    // configurations anywhere.
    let wanted = asking.at(aim, Hint { looks_nowhere_else: aim > context.clearance, ..Hint::default() });
    if wanted.as_ref().is_some_and(|found| aim < context.clearance || asking.is_near(q, found, aim)) {
        return wanted;
    }
    let was_found = wanted.is_some();
    let own = asking.at(context.clearance, Hint::default());
    let found = match (wanted, own) {
        (Some(wanted), Some(own)) if wanted.nearest().0 <= farthest(context, aim, own.nearest().0) => Some(wanted),
        (_, Some(own)) => Some(asking.pushed(q, own, (aim, was_found))),
        (wanted, None) => wanted,
    };
    scratch.evaluator.checks = asking.spent;
    found
}

/// Finds as much of a wanted clearance as is kept near an exit at the scene's clearance, and a
/// verified configuration that keeps it. This is the end of a descent from the exit, no farther
/// from there than `MAX_DEPTH_FACTOR` times the least motion for the difference. The wanted
/// clearance is tried whole, unless it `was_tried`, then with its excess halved again and again.
pub fn push_nearby(
    context: &Context,
    anchor: &Anchor,
    exit: &[f64],
    (wanted, was_tried): (f64, bool),
    scratch: &mut QueryScratch,
) -> Option<(f64, Vec<f64>)> {
    let QueryScratch { evaluator, descent, .. } = scratch;
    let options = Plan::of(&QueryOptions::default(), context).polish;
    for halvings in i32::from(was_tried)..=MAX_HALVINGS {
        let clearance = context.clearance + (wanted - context.clearance) * 0.5_f64.powi(halvings);
        let checker = context.checker.with_clearance(clearance);
        let aimed = Context { checker: &checker, clearance, ..*context };
        let (found, _) =
            descend(&aimed, anchor, Start::at(exit), Pruning::alone(f64::INFINITY), &options, descent, evaluator);
        let is_near =
            found.is_some() && context.metric.distance(exit, &descent.best) <= farthest(context, clearance, 0.0);
        if is_near && evaluator.label(&aimed, &descent.best) == Label::Free {
            return Some((clearance, descent.best.clone()));
        }
        if evaluator.is_spent() {
            break;
        }
    }
    None
}

/// Returns how far a configuration that keeps `aim` may be, if the nearest exit at the scene's
/// clearance is `own` away.
fn farthest(context: &Context, aim: f64, own: f64) -> f64 {
    MAX_DEPTH_FACTOR * (own + (aim - context.clearance) / context.metric.lever().max(1e-9))
}

/// A search that is repeated with several clearances.
struct Asking<'a, 'c, A> {
    /// Context with the scene's clearance.
    context: &'a Context<'c>,
    options: &'a QueryOptions,
    scratch: &'a mut QueryScratch,
    ask: A,
    /// Start of the query, if its seconds are limited.
    began: Option<Instant>,
    spent: usize,
}

impl<T: SearchResult, A: FnMut(&Context, &QueryOptions, Hint, &mut QueryScratch) -> Option<T>> Asking<'_, '_, A> {
    /// Searches for a result that keeps a clearance.
    fn at(&mut self, clearance: f64, hint: Hint) -> Option<T> {
        let aim = (clearance != self.context.clearance).then_some(clearance);
        let own = Constraints::new(self.context, aim, &[]);
        let options = QueryOptions { termination: self.left(), ..self.options.clone() };
        let found = (self.ask)(&own.apply(self.context), &options, hint, self.scratch);
        self.spent += self.scratch.evaluator.checks;
        found
    }

    /// Returns whether the result is near enough by a bound on the exits at the scene's clearance,
    /// without another search.
    fn is_near(&mut self, q: &[f64], found: &T, aim: f64) -> bool {
        let (context, QueryScratch { evaluator, known, .. }) = (self.context, &mut *self.scratch);
        let depth = found.nearest().0;
        if evaluator.is_spent() || depth <= farthest(context, aim, 0.0) {
            return true;
        }
        let mut colliding = Vec::new();
        context.checker.colliding_pairs(q, &mut evaluator.check, &mut colliding);
        context.metric.anchor(q, &mut known.anchor);
        known.proof.begin(self.options.effort, None);
        known.proof.set_colliding(colliding.into_iter());
        let proved = known.proof.bound(context, &known.anchor, depth, &mut evaluator.check);
        depth <= farthest(context, aim, proved)
    }

    /// Returns a result that keeps as much of a wanted clearance as is found near `own`, the exit
    /// at the scene's clearance, or `own` itself. The flag in `wanted` says that the whole
    /// clearance led too far, so that only its halves are tried.
    fn pushed(&mut self, q: &[f64], mut own: T, wanted: (f64, bool)) -> T {
        let (context, mut anchor) = (self.context, Anchor::default());
        context.metric.anchor(q, &mut anchor);
        self.scratch.evaluator.begin(Deadline::of(&self.left()));
        let pushed = push_nearby(context, &anchor, own.nearest().1, wanted, self.scratch);
        self.spent += self.scratch.evaluator.checks;
        if self.scratch.evaluator.is_cut() {
            own.note_cut();
        }
        let Some((clearance, config)) = pushed else { return own };
        let most = farthest(context, clearance, own.nearest().0);
        self.at(clearance, Hint { config: &config, ..Hint::default() })
            .filter(|found| found.nearest().0 <= most)
            .unwrap_or(own)
    }

    fn left(&self) -> Termination {
        let Termination { max_checks, max_seconds, stop } = self.options.termination.clone();
        Termination {
            max_checks: max_checks.map(|most| most.saturating_sub(self.spent)),
            max_seconds: max_seconds.zip(self.began).map(|(most, began)| most - began.elapsed().as_secs_f64()),
            stop,
        }
    }
}

/// Data of a query's own constraints, which its context borrows.
#[derive(Default)]
struct Constraints {
    checker: Option<Checker>,
    locked: Vec<bool>,
    kept: Vec<LinkConstraint>,
    touching: Vec<PairId>,
}

impl Constraints {
    /// Builds only what the constraints change: another clearance `aim` \[m\], and locked joints.
    fn new(context: &Context, aim: Option<f64>, joints: &[usize]) -> Self {
        let checker = aim.map(|aim| context.checker.with_clearance(aim));
        let locked = if joints.is_empty() { Vec::new() } else { locked(context.checker.scene(), joints) };
        Self { checker, locked, kept: Vec::new(), touching: Vec::new() }
    }

    fn apply<'a>(&'a self, context: &Context<'a>) -> Context<'a> {
        let checker = self.checker.as_ref().unwrap_or(context.checker);
        let locked = if self.locked.is_empty() { context.locked } else { &self.locked };
        let kept = if self.kept.is_empty() { context.kept } else { &self.kept };
        let clearance = checker.base_clearance();
        let touching = if self.touching.is_empty() {
            let TouchingPairs { most, aim, are_required, .. } = context.touching;
            let more = if are_required { clearance - context.clearance } else { 0.0 };
            TouchingPairs { most: most + more, aim: aim + more, ..context.touching }
        } else {
            // Descents end a little off what they aim at.
            let (most, aim) = (clearance + TOUCH_M, clearance + 0.5 * TOUCH_M);
            TouchingPairs { pairs: &self.touching, most, aim, are_required: true }
        };
        let own = Context { checker, clearance, locked, kept, touching, ..*context };
        // Stored samples were free at the scene's clearance, with all joints and links anywhere;
        // otherwise their contact planes do not hold.
        if self.checker.is_some() || own.is_constrained() { own.elsewhere() } else { own }
    }
}

/// Marks the tangent coordinates of the joints.
fn locked(scene: &Scene, joints: &[usize]) -> Vec<bool> {
    let mut locked = vec![false; scene.space.nv()];
    for factor in scene.space.factors() {
        let is_of = |joint: &usize| scene.joints.get(*joint).is_some_and(|joint| joint.q.contains(&factor.q));
        if joints.iter().any(is_of) {
            factor.tangents().for_each(|v| locked[v] = true);
        }
    }
    locked
}

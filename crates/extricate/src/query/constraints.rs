//! Queries with a clearance of their own, or with joints that stay: what they stand on.

use std::time::Instant;

use crate::collision::Checker;
use crate::cspace::Label;
use crate::metric::Anchor;
use crate::query::answer::Answer;
use crate::query::context::Context;
use crate::query::descent::prune::Pruning;
use crate::query::descent::{Start, descend};
use crate::query::options::QueryOptions;
use crate::query::plan::Plan;
use crate::query::search::Hint;
use crate::query::search::scratch::QueryScratch;
use crate::query::termination::{Deadline, Termination};
use crate::scene::Scene;

/// A configuration that keeps the wanted clearance is given up if it is farther than this times the
/// nearest exit at the scene's clearance and what the wider clearance moves at least: a narrow
/// place then is left by another way, which nobody means who asks for a little more room.
const FAR: f64 = 10.0;
/// How often what is wanted beyond the scene's clearance is halved, until it is kept nearby.
pub const HALVINGS: i32 = 6;

/// What is asked for under constraints.
pub trait Found {
    /// How far it is from the query, and the configuration.
    fn place(&self) -> (f64, &[f64]);

    /// Notes that a limit ended the search for more of the clearance.
    fn note_cut(&mut self) {}
}

impl Found for Answer {
    fn place(&self) -> (f64, &[f64]) {
        (self.depth, &self.witness)
    }

    fn note_cut(&mut self) {
        self.cut_short = true;
    }
}

/// Asks under the constraints of the options. What is given keeps the wanted clearance, unless
/// nothing is found that does, or that is too far (`FAR`): then it keeps as much of it as halving
/// finds nearby, at least the scene's. Once the budget is spent, nothing else is asked for.
/// The evaluator then has the checks of all of this.
pub(crate) fn under<T: Found>(
    context: &Context,
    q: &[f64],
    options: &QueryOptions,
    scratch: &mut QueryScratch,
    mut ask: impl FnMut(&Context, &QueryOptions, Hint, &mut QueryScratch) -> Option<T>,
) -> Option<T> {
    let plain = Constraints::new(context, None, &options.locked);
    let plain = plain.apply(context);
    let Some(aim) = options.clearance.filter(|aim| *aim != context.clearance) else {
        return ask(&plain, options, Hint::default(), scratch);
    };
    // Not every platform has a clock.
    let began = options.termination.max_seconds.map(|_| Instant::now());
    let mut asking = Asking { context: &plain, options, scratch, ask: &mut ask, began, spent: 0 };
    // If descents find nothing, what is known at the scene's clearance leads farther than luck.
    let wanted = asking.at(aim, Hint { looks_nowhere_else: aim > context.clearance, ..Hint::default() });
    if wanted.as_ref().is_some_and(|found| aim < context.clearance || asking.is_near(q, found, aim)) {
        return wanted;
    }
    let was_found = wanted.is_some();
    let own = asking.at(context.clearance, Hint::default());
    let found = match (wanted, own) {
        (Some(wanted), Some(own)) if wanted.place().0 <= farthest(context, aim, own.place().0) => Some(wanted),
        (_, Some(own)) => Some(asking.pushed(q, own, (aim, was_found))),
        (wanted, None) => wanted,
    };
    scratch.evaluator.checks = asking.spent;
    found
}

/// As much of a wanted clearance as is kept near an exit of the scene's, and the configuration that
/// keeps it: the end of a descent from the exit, verified, that is no farther from there than
/// `FAR` times what the wider clearance moves at least. It is tried whole or, if that
/// `was_tried`, halved, then halved again.
pub fn push_nearby(
    context: &Context,
    anchor: &Anchor,
    exit: &[f64],
    (wanted, was_tried): (f64, bool),
    scratch: &mut QueryScratch,
) -> Option<(f64, Vec<f64>)> {
    let QueryScratch { evaluator, descent, .. } = scratch;
    let options = Plan::of(&QueryOptions::default(), context).polish;
    for halvings in i32::from(was_tried)..=HALVINGS {
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

/// How far a configuration may be that keeps `aim`, if the nearest exit at the scene's clearance is
/// `own` away.
fn farthest(context: &Context, aim: f64, own: f64) -> f64 {
    FAR * (own + (aim - context.clearance) / context.metric.lever().max(1e-9))
}

/// What is asked again with another clearance.
struct Asking<'a, 'c, A> {
    /// With the clearance of the scene.
    context: &'a Context<'c>,
    options: &'a QueryOptions,
    scratch: &'a mut QueryScratch,
    ask: A,
    /// When seconds began to count, if there is a limit on them.
    began: Option<Instant>,
    /// Checks so far.
    spent: usize,
}

impl<T: Found, A: FnMut(&Context, &QueryOptions, Hint, &mut QueryScratch) -> Option<T>> Asking<'_, '_, A> {
    /// What is found that keeps a clearance.
    fn at(&mut self, clearance: f64, hint: Hint) -> Option<T> {
        let aim = (clearance != self.context.clearance).then_some(clearance);
        let own = Constraints::new(self.context, aim, &[]);
        let options = QueryOptions { termination: self.left(), ..self.options.clone() };
        let found = (self.ask)(&own.apply(self.context), &options, hint, self.scratch);
        self.spent += self.scratch.evaluator.checks;
        found
    }

    /// Whether what was found is known to be near enough without another search, by what is proved
    /// of the exits at the scene's clearance.
    fn is_near(&mut self, q: &[f64], found: &T, aim: f64) -> bool {
        let (context, QueryScratch { evaluator, known, .. }) = (self.context, &mut *self.scratch);
        let depth = found.place().0;
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

    /// What keeps as much of a wanted clearance as is found near an exit at the scene's clearance,
    /// or that exit. All of it is tried, unless what keeps it `was_found` to be too far.
    fn pushed(&mut self, q: &[f64], mut own: T, wanted: (f64, bool)) -> T {
        let (context, mut anchor) = (self.context, Anchor::default());
        context.metric.anchor(q, &mut anchor);
        self.scratch.evaluator.begin(Deadline::of(&self.left()));
        let pushed = push_nearby(context, &anchor, own.place().1, wanted, self.scratch);
        self.spent += self.scratch.evaluator.checks;
        if self.scratch.evaluator.is_cut() {
            own.note_cut();
        }
        let Some((clearance, config)) = pushed else { return own };
        let most = farthest(context, clearance, own.place().0);
        self.at(clearance, Hint { config: &config, ..Hint::default() })
            .filter(|found| found.place().0 <= most)
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

/// What a query's own constraints make of what it stands on; kept while it is asked.
#[derive(Default)]
struct Constraints {
    checker: Option<Checker>,
    locked: Vec<bool>,
}

impl Constraints {
    /// Another clearance \[m\], and further joints that stay; nothing is made if there are none.
    fn new(context: &Context, aim: Option<f64>, joints: &[usize]) -> Self {
        let checker = aim.map(|aim| context.checker.with_clearance(aim));
        let locked = if joints.is_empty() { Vec::new() } else { locked(context.checker.scene(), joints) };
        Self { checker, locked }
    }

    /// The context under them.
    fn apply<'a>(&'a self, context: &Context<'a>) -> Context<'a> {
        let checker = self.checker.as_ref().unwrap_or(context.checker);
        let locked = if self.locked.is_empty() { context.locked } else { &self.locked };
        let own = Context { checker, clearance: checker.base_clearance(), locked, ..*context };
        // Samples were free at the clearance of the scene, and as a whole: so their planes hold.
        if self.checker.is_some() || !self.locked.is_empty() { own.elsewhere() } else { own }
    }
}

/// Of every tangent coordinate, whether one of the joints has it.
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

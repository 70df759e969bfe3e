//! Sources of starts: directions in which bodies part, stored samples, configurations that keep
//! links, and configurations around the query. As a last resort, the nearest stored sample or
//! anything free is taken.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Search;
use super::directions::visit_next;
use super::kept::from_kept;
use super::known::Known;
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::math::elementary::{ln, sin_cos};
use crate::query::context::Context;
use crate::query::descent::Start;
use crate::query::local_metric::LocalMetric;
use crate::query::plan::Plan;

/// A source that proposes starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Displacements along which colliding bodies part, shortest first.
    Directions,
    /// Stored samples, nearest first.
    Stored,
    /// Configurations around the query.
    Around,
    /// Configurations that keep the links of the query, nearest first.
    Kept,
}

/// Configurations that are tried anywhere before a search gives up.
const MAX_ANYWHERE: u64 = 20_000;
/// The same if each has to be moved to where links are kept, which takes as long as a check.
const MAX_KEPT_ANYWHERE: u64 = 2_000;
/// Distances of starts around the query as shares of the depth, used one after another. Shares from
/// 0.2 to 0.8 find the same for a third more checks (lab L120). Everything nearer than the depth
/// collides, and descents out of an overlap often get stuck.
const RADIUS_SHARES: [f64; 4] = [0.8, 1.1, 1.4, 1.7];

impl Source {
    /// Returns the fewest and the most starts of a plan. Starts beyond the fewest follow a success,
    /// or replace starts that got stuck.
    pub fn starts(self, plan: &Plan) -> [usize; 2] {
        match self {
            Self::Directions => [plan.most_directions; 2],
            Self::Stored => [plan.stored; 2],
            Self::Around => [plan.around, plan.most_around],
            Self::Kept => [plan.kept_draws; 2],
        }
    }

    /// Descends from the start with this number; returns whether there was one.
    pub fn descend(self, search: &mut Search, number: usize) -> bool {
        match self {
            Self::Directions => visit_next(search),
            Self::Stored => from_stored(search, number),
            Self::Around => search.known.exits.len() > 0 && from_around(search, number),
            Self::Kept => from_kept(search, number),
        }
    }
}

fn from_stored(search: &mut Search, number: usize) -> bool {
    let (context, plan) = (search.context, search.plan);
    let mut stored = std::mem::take(&mut search.known.stored);
    if !stored.is_gathered {
        stored.gather(context, &plan, &search.known.anchor, search.boundary);
    }
    let Known { anchor, rest, local, .. } = &mut *search.known;
    while stored.chosen.len() <= number && stored.choose_next(context, &plan, (&anchor.q, rest), local) {}
    let chosen = stored.chosen.get(number).copied();
    search.known.stored = stored;
    let (Some(id), Some(from)) = (chosen, context.stored) else { return false };
    let mut config = std::mem::take(&mut search.known.start);
    config.clear();
    config.extend_from_slice(from.samples.config(id));
    context.hold(&search.known.rest, &mut config);
    search.try_start(Start::stored(&from, id, &config));
    search.known.start = config;
    true
}

/// Offers the nearest stored sample that is free, if it is nearer than every exit.
pub fn take_stored(search: &mut Search) {
    let Some(from) = search.context.stored else { return };
    let mut stored = std::mem::take(&mut search.known.stored);
    if !stored.is_gathered {
        stored.gather(search.context, &search.plan, &search.known.anchor, search.boundary);
    }
    for (id, _) in stored.near.iter().take_while(|(_, distance)| *distance < search.known.exits.depth()) {
        let config = from.samples.config(*id);
        if search.evaluator.label(search.context, config) == Label::Free {
            search.offer_free(config);
            break;
        }
    }
    search.known.stored = stored;
}

/// Offers the first free configuration of a low-discrepancy sequence, and descends from it.
pub fn take_anywhere(search: &mut Search) {
    let (context, space) = (search.context, &search.context.checker.scene().space);
    // If no draw could be moved to where links are kept, more will not be. None touches by chance.
    if !context.kept.is_empty() && search.known.kept.is_empty() || context.touching.are_required {
        return;
    }
    let halton = Halton::new(space.nv(), 0);
    let mut config = std::mem::take(&mut search.known.start);
    config.resize(space.nq(), 0.0);
    let most = if context.kept.is_empty() { MAX_ANYWHERE } else { MAX_KEPT_ANYWHERE };
    for index in 0..most {
        if search.evaluator.is_stopped() {
            break;
        }
        halton.config(space, index, &mut config);
        context.hold(&search.known.rest, &mut config);
        if search.evaluator.project(context, &mut config) && search.evaluator.label(context, &config) == Label::Free {
            search.offer_free(&config);
            search.try_start(Start::at(&config));
            break;
        }
    }
    search.known.start = config;
}

/// Descends from a configuration around the query, free or not, in a pseudo-random direction seeded
/// by `number`. This meets exits that are too near or too narrow for other sources.
fn from_around(search: &mut Search, number: usize) -> bool {
    let (context, space) = (search.context, &search.context.checker.scene().space);
    let mut start = std::mem::take(&mut search.known.start);
    let mut step = std::mem::take(&mut search.known.step);
    step.resize(space.nv(), 0.0);
    start.clone_from(&search.known.anchor.q);
    let radius = RADIUS_SHARES[number % RADIUS_SHARES.len()] * search.known.exits.depth();
    direction(context, &search.known.local, &mut ChaCha8Rng::seed_from_u64(number as u64), &mut step);
    // Two passes: lengths in the metric need not be proportional to the step.
    for _ in 0..2 {
        space.integrate(&search.known.anchor.q, &step, &mut start);
        let length = search.evaluator.distance(context, &search.known.anchor, &start);
        if length > 0.0 {
            step.iter_mut().for_each(|s| *s *= radius / length);
        }
    }
    space.integrate(&search.known.anchor.q, &step, &mut start);
    context.hold(&search.known.rest, &mut start);
    search.try_start(Start::at(&start));
    (search.known.start, search.known.step) = (start, step);
    true
}

/// Draws a direction of the joints that may move, uniform in the metric at the query.
fn direction(context: &Context, local: &LocalMetric, rng: &mut ChaCha8Rng, step: &mut [f64]) {
    step.iter_mut().for_each(|s| *s = normal(rng));
    local.spread(step);
    step.iter_mut().enumerate().filter(|(v, _)| context.is_locked(*v)).for_each(|(_, s)| *s = 0.0);
}

/// Draws a standard normal number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * ln(u)).sqrt() * sin_cos(std::f64::consts::TAU * v).1
}

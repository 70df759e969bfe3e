//! Descents from the query itself and from configurations around it, free or not: exits too near or
//! too narrow for any stored sample.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::math::elementary::{ln, sin_cos};
use crate::query::descent::Start;
use crate::query::search::Search;

/// Distances of the starts from the query, as shares of the incumbent's depth, in turns.
const RADII: [f64; 4] = [0.2, 0.4, 0.6, 0.8];

/// As many descents as the plan has, and more as long as they find something; in a stream they are
/// tried in turn with others.
pub fn look_around(search: &mut Search) {
    search.known.round.begin();
    if search.turn.is_some() {
        return;
    }
    for number in 0..search.plan.most_around {
        let is_over = search.known.round.is_over(search.plan.around, search.plan.patience);
        if is_over || search.evaluator.is_spent() || search.is_proved() {
            break;
        }
        try_around(search, number);
    }
}

/// A descent from the start of a number, whose direction is the same in every query.
pub fn try_around(search: &mut Search, number: usize) {
    let (context, space) = (search.context, &search.context.checker.scene().space);
    let mut start = std::mem::take(&mut search.known.composed);
    let mut step = std::mem::take(&mut search.known.step);
    step.resize(space.nv(), 0.0);
    start.clone_from(&search.known.anchor.q);
    let radius = RADII[number % RADII.len()] * search.known.incumbent.depth;
    direction(search, &mut ChaCha8Rng::seed_from_u64(number as u64), &mut step);
    // Twice: the first step measures how long it is in the metric.
    for _ in 0..2 {
        space.integrate(&search.known.anchor.q, &step, &mut start);
        let length = search.evaluator.distance(context, &search.known.anchor, &start);
        if length > 0.0 {
            step.iter_mut().for_each(|s| *s *= radius / length);
        }
    }
    space.integrate(&search.known.anchor.q, &step, &mut start);
    search.try_start(Start::at(&start));
    (search.known.composed, search.known.step) = (start, step);
}

/// A random direction, uniform as the metric at the query sees it; of a part, in its joints alone.
fn direction(search: &Search, rng: &mut ChaCha8Rng, step: &mut [f64]) {
    step.iter_mut().for_each(|s| *s = normal(rng));
    search.known.local.spread(step);
    let is_of_part =
        |v: usize| search.part.is_none_or(|part| part.factors().any(|factor| factor.tangents().contains(&v)));
    let stays = |v: usize| search.context.is_locked(v) || !is_of_part(v);
    step.iter_mut().enumerate().filter(|(v, _)| stays(*v)).for_each(|(_, s)| *s = 0.0);
}

/// A standard normal number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * ln(u)).sqrt() * sin_cos(std::f64::consts::TAU * v).1
}

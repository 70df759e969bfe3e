//! Finds the side of the object on which a finger first touches when it closes from open.
//!
//! A finger deep in the object does not show its side: the nearest exit may lie past the object.

use super::hand::Hand;
use crate::collision::CheckScratch;
use crate::cspace::Manifold;
use crate::query::Context;

/// Steps from the query to the open posture in which fingers are checked for collision.
const OPENING_STEPS: usize = 8;
/// Bisection steps after that: they find the first touch to about 1e-4 of the way to open.
const HALVINGS: usize = 10;

/// Returns the query with each finger opened to where it first touches the object when it closes
/// from open. A finger that never collides on the way, or that still collides when open, stays.
pub fn first_touch(
    hand: &Hand,
    context: &Context,
    q: &[f64],
    open: Option<&[f64]>,
    scratch: &mut CheckScratch,
) -> Vec<f64> {
    let posture = posture(hand, context, q, open);
    // For each finger, the widest opening known to collide, and the least free one beyond.
    let count = hand.fingers.len();
    let (mut colliding, mut free) = (vec![None; count], vec![None; count]);
    let (mut config, mut hits) = (q.to_vec(), vec![false; count]);
    for place in 0..=OPENING_STEPS {
        let share = place as f64 / OPENING_STEPS as f64;
        find_hits(hand, context, (q, &posture), &vec![share; count], (&mut config, scratch), &mut hits);
        for finger in 0..count {
            if hits[finger] {
                (colliding[finger], free[finger]) = (Some(share), None);
            } else if free[finger].is_none() {
                free[finger] = Some(share);
            }
        }
    }
    let was_moved: Vec<bool> = (0..count).map(|f| colliding[f].is_some() && free[f].is_some()).collect();
    let mut low: Vec<f64> = colliding.iter().map(|share| share.unwrap_or(0.0)).collect();
    let mut high: Vec<f64> = (0..count).map(|f| if was_moved[f] { free[f].unwrap_or(0.0) } else { 0.0 }).collect();
    for _ in 0..HALVINGS {
        let middle: Vec<f64> = (0..count).map(|f| if was_moved[f] { 0.5 * (low[f] + high[f]) } else { 0.0 }).collect();
        find_hits(hand, context, (q, &posture), &middle, (&mut config, scratch), &mut hits);
        for finger in (0..count).filter(|finger| was_moved[*finger]) {
            let side = if hits[finger] { &mut low } else { &mut high };
            side[finger] = middle[finger];
        }
    }
    compose(hand, context, (q, &posture), &high, &mut config);
    config
}

/// Sets in `hits` whether each finger collides with the object when it is opened by its share.
fn find_hits(
    hand: &Hand,
    context: &Context,
    between: (&[f64], &[f64]),
    shares: &[f64],
    (config, scratch): (&mut Vec<f64>, &mut CheckScratch),
    hits: &mut [bool],
) {
    compose(hand, context, between, shares, config);
    hits.fill(false);
    let links = || hand.links.iter().filter_map(|link| link.finger.map(|finger| (link.pair, finger)));
    let collide = context.checker.collide(config, links().map(|(pair, _)| pair), scratch);
    links().zip(collide).for_each(|((_, finger), collides)| hits[finger] |= collides);
}

/// Writes the query, with every finger opened by its share, into `config`.
fn compose(hand: &Hand, context: &Context, (q, open): (&[f64], &[f64]), shares: &[f64], config: &mut [f64]) {
    let factors = context.checker.scene().space.factors();
    config.copy_from_slice(q);
    for (finger, share) in hand.fingers.iter().zip(shares) {
        for factor in finger.factors.iter().map(|at| &factors[*at]).filter(|factor| factor.manifold.coordinates() == 1)
        {
            config[factor.q] = q[factor.q] + share * (open[factor.q] - q[factor.q]);
        }
    }
}

/// Returns the query with all fingers open, except for their locked coordinates.
fn posture(hand: &Hand, context: &Context, q: &[f64], open: Option<&[f64]>) -> Vec<f64> {
    let factors = context.checker.scene().space.factors();
    let mut posture = q.to_vec();
    for factor in hand.fingers.iter().flat_map(|finger| finger.factors.iter().map(|at| &factors[*at])) {
        if context.is_locked(factor.v) {
            continue;
        }
        let wanted = open.map_or(0.0, |open| open[factor.q]);
        match factor.manifold {
            Manifold::Interval { lower, upper } => posture[factor.q] = wanted.clamp(lower, upper),
            Manifold::Circle => posture[factor.q] = wanted,
            Manifold::Rotation => {}
        }
    }
    posture
}

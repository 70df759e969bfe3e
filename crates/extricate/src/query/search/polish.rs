//! How a search ends: the best exits carried to their ends, and an answer that was verified.

use super::{REMEMBERED, Search};
use crate::cspace::Label;
use crate::query::descent::Start;

/// An exit of pieces this much farther than the nearest one may turn out to be nearer out of the
/// meshes.
const AS_NEAR: f64 = 1.03;

/// Carries the incumbent to its end, or every exit where several are wanted, and verifies what is
/// left.
pub fn polish(search: &mut Search) {
    search.believes = false;
    let mut start = std::mem::take(&mut search.known.composed);
    if search.known.wanted > 1 {
        polish_several(search, &mut start);
    } else {
        polish_best(search, &mut start);
    }
    search.known.composed = start;
    verify(search);
    if search.known.wanted > 1 && search.known.incumbent.verified {
        let (space, known) = (&search.context.checker.scene().space, &mut *search.known);
        known.exits.offer(space, &mut known.local, known.incumbent.depth, &known.incumbent.config);
    }
}

/// With meshes, others that may be as near too: pieces stand out differently.
fn polish_best(search: &mut Search, start: &mut Vec<f64>) {
    let best = search.known.incumbent.depth;
    start.clone_from(&search.known.incumbent.config);
    polish_from(search, start);
    if search.context.checker.all_convex() {
        return;
    }
    for rank in 1..REMEMBERED {
        let Some((_, config)) = search.known.exits.iter().nth(rank).filter(|(depth, _)| *depth < AS_NEAR * best) else {
            break;
        };
        start.clear();
        start.extend_from_slice(config);
        polish_from(search, start);
    }
}

/// A last descent, from an exit toward its end.
fn polish_from(search: &mut Search, start: &[f64]) {
    if search.evaluator.is_spent() {
        return;
    }
    let ceiling = search.known.incumbent.depth;
    if let (Some(depth), _) = search.descend_alone(Start::at(start), ceiling, search.plan.polish) {
        search.keep(depth);
    }
}

/// Each of several exits; those that turn out to collide are none.
fn polish_several(search: &mut Search, rows: &mut Vec<f64>) {
    let space = &search.context.checker.scene().space;
    rows.clear();
    search.known.exits.iter().for_each(|(_, config)| rows.extend_from_slice(config));
    search.known.exits.reset(search.known.wanted, space.nq());
    for (left, start) in rows.chunks_exact(space.nq()).rev().enumerate().rev() {
        let found = if search.evaluator.is_spent() {
            None
        } else {
            search.descend_alone(Start::at(start), f64::INFINITY, search.plan.polish).0
        };
        let best = std::mem::take(&mut search.descent.best);
        let end = if found.is_some() { &best[..] } else { start };
        search.evaluator.reserved = left;
        if search.evaluator.label(search.context, end) == Label::Free {
            let depth = search.evaluator.distance(search.context, &search.known.anchor, end);
            let known = &mut *search.known;
            known.exits.offer(space, &mut known.local, depth, end);
            if depth <= known.incumbent.depth || !known.incumbent.verified {
                known.take(depth, end, true);
            }
        }
        search.descent.best = best;
    }
}

/// Checks an incumbent that no descent was verified for; where it collides, which only rounding
/// makes of what pieces keep clear, the sample that the search began with.
pub fn verify(search: &mut Search) {
    let (context, known) = (search.context, &mut *search.known);
    if !known.incumbent.verified {
        known.incumbent.verified = search.evaluator.label(context, &known.incumbent.config) == Label::Free;
    }
    if !known.incumbent.verified {
        let fallback = std::mem::take(&mut known.fallback);
        known.take(fallback.depth, &fallback.config, false);
        known.fallback = fallback;
        known.incumbent.verified = search.evaluator.label(context, &known.incumbent.config) == Label::Free;
    }
}

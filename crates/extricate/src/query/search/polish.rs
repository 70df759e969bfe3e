//! How a query ends: exits carried to their ends with exact contacts, and verified.

use super::Search;
use crate::cspace::Label;

/// An exit of pieces this much farther than the nearest one may turn out to be nearer out of the
/// meshes.
const AS_NEAR: f64 = 1.03;
/// Exits that are carried to their ends then, the nearest among them.
const MOST_AS_NEAR: usize = 4;

/// Carries the nearest exit to its end, or every exit if several are wanted, and verifies it;
/// whether one is free.
pub fn polish(search: &mut Search) -> bool {
    search.believes = false;
    if search.known.wanted > 1 {
        polish_several(search);
    } else if !search.plan.takes_first {
        polish_nearest(search);
    }
    // What collides in spite of its contacts, which only rounding makes, is no exit.
    while let Some(nearest) = search.known.exits.nearest().filter(|end| !end.is_verified) {
        let is_free = search.evaluator.label(search.context, &nearest.config) == Label::Free;
        search.known.exits.note_checked(is_free);
    }
    search.known.exits.len() > 0
}

/// Along meshes, others that may be as near too: pieces stand out differently.
fn polish_nearest(search: &mut Search) {
    let (best, all_convex) = (search.known.exits.depth(), search.context.checker.all_convex());
    let count = if all_convex { 1 } else { MOST_AS_NEAR };
    let mut starts = std::mem::take(&mut search.known.starts);
    starts.clear();
    let as_near = search.known.exits.iter().take(count).filter(|end| end.distance <= AS_NEAR * best);
    as_near.for_each(|end| starts.extend_from_slice(&end.config));
    for start in starts.chunks_exact(search.known.rest.len()) {
        if search.evaluator.is_spent() {
            break;
        }
        let ceiling = search.known.exits.depth();
        if let Some(depth) = search.descend_alone(start, ceiling, search.plan.polish) {
            search.keep(depth, false);
        }
    }
    search.known.starts = starts;
}

/// Each of the exits that are wanted; those that turn out to collide are none.
fn polish_several(search: &mut Search) {
    let (wanted, nq) = (search.known.wanted, search.known.rest.len());
    let mut starts = std::mem::take(&mut search.known.starts);
    starts.clear();
    search.known.exits.iter().take(wanted).for_each(|end| starts.extend_from_slice(&end.config));
    search.known.exits.clear();
    for (left, start) in starts.chunks_exact(nq).rev().enumerate().rev() {
        let found = match search.evaluator.is_spent() {
            true => None,
            false => search.descend_alone(start, f64::INFINITY, search.plan.polish),
        };
        let mut end = std::mem::take(&mut search.known.start);
        end.clear();
        end.extend_from_slice(if found.is_some() { &search.descent.best } else { start });
        if search.evaluator.label(search.context, &end) == Label::Free {
            search.offer_free(&end);
        }
        search.known.start = end;
        search.evaluator.reserved = left;
    }
    search.known.starts = starts;
}

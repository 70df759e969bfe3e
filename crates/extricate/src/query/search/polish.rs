//! The end of a search: exits are polished with exact contacts, and verified.

use super::Search;
use crate::cspace::Label;

/// Along meshes, exits up to this multiple of the nearest depth are polished too. Convex pieces
/// stand out of meshes by different amounts, so one of them may turn out nearer.
const POLISHED_DEPTH_FACTOR: f64 = 1.03;
/// Most exits that are polished along meshes, including the nearest.
const MAX_POLISHED: usize = 4;

/// Polishes and verifies the nearest exit, or all exits that are wanted. Returns whether one is
/// free.
pub fn polish(search: &mut Search) -> bool {
    search.believes = false;
    if search.known.wanted > 1 {
        polish_several(search);
    } else if !search.plan.takes_first {
        polish_nearest(search);
    }
    // An exit may collide though its contacts keep the clearance; the next one then takes its
    // place.
    while let Some(nearest) = search.known.exits.nearest().filter(|end| !end.is_verified) {
        let is_free = search.evaluator.label(search.context, &nearest.config) == Label::Free;
        search.known.exits.note_checked(is_free);
    }
    search.known.exits.len() > 0
}

/// Polishes the nearest exit; along meshes, also others that may turn out nearer.
fn polish_nearest(search: &mut Search) {
    let (best, all_convex) = (search.known.exits.depth(), search.context.checker.all_convex());
    let count = if all_convex { 1 } else { MAX_POLISHED };
    let mut starts = std::mem::take(&mut search.known.starts);
    starts.clear();
    let as_near = search.known.exits.iter().take(count).filter(|end| end.distance <= POLISHED_DEPTH_FACTOR * best);
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

/// Polishes each of the wanted exits, and drops those that collide.
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

//! The search of one group: from the hint, then from one source of starts after another.

use super::sources::{Source, take_anywhere, take_stored};
use super::{Search, Turn};
use crate::cspace::Label;
use crate::query::descent::Start;

/// A start succeeds if it brings the nearest exit below this share of its depth; a smaller gain is
/// the same exit again.
const SUCCESS_SHARE: f64 = 0.99;
/// A source continues up to this multiple of the starts until its last success. The rank of the
/// start that finds the nearest exit has a long tail: a late success makes others likely.
const PATIENCE_FACTOR: usize = 2;
/// Starts that get stuck reveal no exits and are replaced, by at most this many for each start of
/// the plan. A quarter fewer queries miss for a tenth more checks (lab L120).
const MAX_REPLACEMENTS: usize = 3;

/// Searches for exits from the hint, then from one source after another.
pub fn run(search: &mut Search) {
    let known = &search.known;
    search.evaluator.needs_exit = !known.may_fall_back && !known.has_earlier;
    if begin_at_hint(search)
        && let Some(turn) = search.turn
    {
        return try_next_starts(search, turn);
    }
    ask(search, Source::Directions);
    ask(search, Source::Stored);
    if search.context.is_held() {
        ask(search, Source::Kept);
    }
    if search.known.exits.len() == 0 && !search.evaluator.is_spent() {
        find_any(search);
    }
    ask(search, Source::Around);
}

/// Takes any exit, however far. The search may exceed the budget for it, since without an exit
/// there is no answer.
fn find_any(search: &mut Search) {
    if !search.context.is_constrained() && search.known.looks_anywhere {
        take_stored(search);
    }
    if search.known.exits.len() == 0 && search.known.looks_anywhere {
        search.evaluator.needs_exit = true;
        take_anywhere(search);
    }
}

/// Descents from the starts of one source.
fn ask(search: &mut Search, source: Source) {
    let [fewest, most] = source.starts(&search.plan);
    let (mut tried, mut last_success, stuck_before) = (0, 0, search.known.stuck);
    let more = |search: &Search| (search.known.stuck - stuck_before).min(MAX_REPLACEMENTS * fewest);
    while tried < (fewest + more(search)).max(PATIENCE_FACTOR * last_success).min(most) && !search.is_over() {
        let before = search.known.exits.depth();
        if !source.descend(search, tried) {
            break;
        }
        tried += 1;
        if search.known.exits.depth() < SUCCESS_SHARE * before {
            last_success = tried;
        }
    }
}

/// Offers the hint if it is free, and descends from it if it is not. Returns whether it is free.
fn begin_at_hint(search: &mut Search) -> bool {
    if search.known.hint.is_empty() {
        return false;
    }
    let mut config = std::mem::take(&mut search.known.start);
    config.clone_from(&search.known.hint);
    search.context.hold(&search.known.rest, &mut config);
    let is_free = search.evaluator.label(search.context, &config) == Label::Free;
    if is_free {
        // The hint of a stream is the end of a descent.
        search.offer(&config, true, search.turn.is_some());
    } else {
        search.try_start(Start::at(&config));
    }
    search.known.start = config;
    is_free
}

/// Descends from the stored samples and the starts around the query that are next in the stream.
fn try_next_starts(search: &mut Search, Turn { next, mut left }: Turn) {
    let all = search.plan.stored + search.plan.around;
    let mut tried = 0;
    while tried < all && left > 0 && !search.is_over() {
        let at = (next + tried) % all;
        let before = search.evaluator.checks;
        match at.checked_sub(search.plan.stored) {
            Some(number) => Source::Around.descend(search, number),
            None => Source::Stored.descend(search, at),
        };
        // A start that its contact planes prune costs no check.
        left -= usize::from(search.evaluator.checks > before);
        tried += 1;
    }
    search.turn = Some(Turn { next: (next + tried) % all.max(1), left });
}

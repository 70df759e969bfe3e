//! The search of one group: at the hint, then from one source after another.

use super::sources::{Source, take_anywhere, take_stored};
use super::{Search, Turn};
use crate::cspace::Label;
use crate::query::descent::Start;

/// An exit is nearer than another one if it is within this share of its distance.
const NEARER: f64 = 0.99;
/// A source is gone on with for this times the starts until its last success. How late the start
/// is that finds the nearest exit has a long tail: if one in so many has just succeeded, as many
/// more may well do so again.
const PATIENCE: usize = 2;
/// A start that gets stuck tells nothing of exits and is made up for, by at most this many for each
/// that the plan has.
const MADE_UP: usize = 3;

/// Looks for exits: at the hint, then from one source after another.
pub fn run(search: &mut Search) {
    let known = &search.known;
    search.evaluator.needs_exit = !known.may_fall_back && !known.has_earlier;
    if begin_at_hint(search)
        && let Some(turn) = search.turn
    {
        return take_turns(search, turn);
    }
    ask(search, Source::Directions);
    ask(search, Source::Stored);
    if search.known.exits.len() == 0 && !search.evaluator.is_spent() {
        find_any(search);
    }
    ask(search, Source::Around);
}

/// Finds any exit, whatever it costs: without one there is no answer.
fn find_any(search: &mut Search) {
    if search.context.locked.is_empty() && search.known.looks_anywhere {
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
    let more = |search: &Search| (search.known.stuck - stuck_before).min(MADE_UP * fewest);
    while tried < (fewest + more(search)).max(PATIENCE * last_success).min(most) && !search.is_over() {
        let before = search.known.exits.depth();
        if !source.descend(search, tried) {
            break;
        }
        tried += 1;
        if search.known.exits.depth() < NEARER * before {
            last_success = tried;
        }
    }
}

/// Looks at the configuration that may be free, and descends from it if it is not; whether it
/// is.
fn begin_at_hint(search: &mut Search) -> bool {
    if search.known.hint.is_empty() {
        return false;
    }
    let mut config = std::mem::take(&mut search.known.start);
    config.clone_from(&search.known.hint);
    search.context.hold(&search.known.rest, &mut config);
    let is_free = search.evaluator.label(search.context, &config) == Label::Free;
    if is_free {
        // A descent led to that of a stream.
        search.offer(&config, true, search.turn.is_some());
    } else {
        search.try_start(Start::at(&config));
    }
    search.known.start = config;
    is_free
}

/// Descents from the stored samples and around the query whose turn it is.
fn take_turns(search: &mut Search, Turn { next, mut left }: Turn) {
    let (mut at, all) = (next, search.plan.stored + search.plan.around);
    for rank in 0..all {
        at = (next + rank) % all;
        if left == 0 || search.is_over() {
            break;
        }
        let before = search.evaluator.checks;
        match at.checked_sub(search.plan.stored) {
            Some(number) => Source::Around.descend(search, number),
            None => Source::Stored.descend(search, at),
        };
        // What its planes gave up cost nothing.
        left -= usize::from(search.evaluator.checks > before);
    }
    search.turn = Some(Turn { next: at, left });
}

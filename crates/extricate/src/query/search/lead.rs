//! What a stream carries from one search into the next: the exit of the last frame, and which
//! starts come next.

use super::{Search, Turn};
use crate::query::answer::Answer;
use crate::query::descent::Start;

/// What a stream carries into a search.
#[derive(Debug, Clone, Default)]
pub struct Lead {
    /// The exit of the last frame; empty where there is none.
    pub exit: Vec<f64>,
    /// Coordinates of the query of the last frame.
    pub nq: usize,
    /// Where it has led in this frame, and how far that is.
    pub followed: Option<(f64, Vec<f64>)>,
    /// Of the stored samples.
    pub turn: Turn,
}

impl Lead {
    /// Whether there is nothing to follow.
    pub fn is_empty(&self) -> bool {
        self.exit.is_empty()
    }

    /// Slides the exit of the last frame along: mostly it still is the nearest, and others are then
    /// given up early. The search goes on with as many other starts as may be looked at.
    pub fn follow(&mut self, search: &mut Search) {
        self.followed = None;
        if search.evaluator.is_spent() {
            return;
        }
        search.believes = !search.context.checker.all_convex();
        search.context.hold(&search.known.anchor.q, &mut self.exit);
        let start = Start::at(&self.exit);
        if let (Some(depth), _) = search.descend(start, f64::INFINITY, search.plan.descent) {
            self.followed = Some((depth, search.descent.best.clone()));
            search.known.ends.push(&search.descent.best);
            search.keep(depth);
        }
        search.turn = Some(self.turn);
    }

    /// Notes the exit of this frame, which the next one follows.
    pub fn keep(&mut self, answer: &Answer) {
        if !answer.is_free() {
            self.exit.clear();
            if answer.verified {
                self.exit.extend_from_slice(&answer.witness);
            }
        }
    }

    /// Notes which start comes next.
    pub fn advance(&mut self, search: &Search) {
        self.turn.next = search.turn.map_or(0, |turn| turn.next);
    }
}

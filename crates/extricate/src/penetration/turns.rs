//! Descents in turn, each of which has to beat the best so far; a stream begins with the way out of its last frame.

use super::Ground;
use super::answer::Answer;
use super::refine::{RefineOptions, Start};
use super::search::QueryScratch;

/// What a stream carries into a search of descents in turn.
#[derive(Debug, Clone, Default)]
pub struct Lead {
    /// The way out of the last frame, from which the first descent starts, then where that ended; empty where there is none.
    pub config: Vec<f64>,
    /// How far that end is.
    pub depth: f64,
    /// Starts that may cost checks besides.
    pub looks: usize,
    /// The one that is tried first, in the order in which they were chosen; then the first of the next frame.
    pub next: usize,
}

impl QueryScratch {
    /// From each of the `chosen` samples: all of them, or where there is a lead, as many as it allows, the next ones in the next frame.
    pub(super) fn descend_in_turn(
        &mut self,
        ground: &Ground,
        options: &RefineOptions,
        chosen: &[u32],
        answer: &mut Answer,
    ) {
        let leads = !self.lead.config.is_empty();
        let (first, mut looks) = if leads { (self.lead.next, self.lead.looks) } else { (0, usize::MAX) };
        if leads {
            self.follow_lead(ground, options, answer);
        }
        for at in 0..chosen.len() {
            let place = (first + at) % chosen.len();
            if leads {
                self.lead.next = place;
            }
            if self.refine.is_spent() || looks == 0 {
                break;
            }
            let before = self.refine.checks;
            if let Some(depth) =
                self.refine_from(ground, options, Start::of(ground, chosen[place]), answer.depth, answer)
            {
                self.remember(ground, depth);
            }
            // What its planes gave up cost nothing.
            looks -= usize::from(self.refine.checks > before);
        }
    }

    /// Slides the way out of the last frame along: mostly it still is the nearest, and others are then given up early.
    fn follow_lead(&mut self, ground: &Ground, options: &RefineOptions, answer: &mut Answer) {
        self.lead.depth = f64::INFINITY;
        if self.refine.is_spent() {
            return;
        }
        let start = std::mem::take(&mut self.lead.config);
        if let Some(depth) = self.refine_from(ground, options, Start::at(&start), f64::INFINITY, answer) {
            self.remember(ground, depth);
            self.lead.depth = depth;
        }
        self.lead.config = start;
        self.lead.config.clone_from(&self.slid);
    }
}

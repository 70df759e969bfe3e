//! The first witness in a scene that is not the one that was learned: a sample that is free there, or what comes nearest to it.

use super::Ground;
use super::answer::Answer;
use super::limit::Limit;
use super::plan::Plan;
use super::refine::Start;
use super::search::QueryScratch;
use crate::boundary::{Among, Wanted};
use crate::cspace::Label;
use crate::cspace::sampling::Halton;

/// Nearest samples that are checked before descents from the nearest are tried: where so many collide, hardly any may be free, as where the
/// clearance is larger than it was; and a descent takes about as many checks.
const LOOKED_AT: usize = 16;
/// Times as many are looked at next.
const MORE: usize = 8;
/// The same for exits, which are farther from each other.
const EXITS_LOOKED_AT: usize = 4;
/// An exit that by its planes misses the clearance by more than this \[m\] collides: they are of single precision.
const SURE: f64 = 1e-6;
/// Descents that are tried then.
const LED_OUT: usize = 8;
/// Configurations that are tried where no stored one is free any more.
const LAST_RESORT: u64 = 20_000;

impl QueryScratch {
    /// Makes the nearest exit or sample that is free now the answer; where the nearest of them collide, what a descent from one of those leads to;
    /// or else any free configuration. Fills the pool of the plan. False where none was found, or looking for one was stopped; a budget does not
    /// end it, since without a witness there is no answer.
    pub(super) fn first_free(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) -> bool {
        if self.free_exit(ground, answer) || self.lead_out(ground, plan, Among::Exits, answer) {
            return true;
        }
        let (mut count, mut looked) = (plan.pool(), 0);
        loop {
            let wanted = Wanted { care: plan.care, ..Wanted::NEAREST };
            let Self { anchor, boundary, pool, .. } = self;
            ground.boundary.nearest(wanted, ground.metric, anchor, count, boundary, pool);
            for at in looked..self.pool.len() {
                if at == LOOKED_AT && self.lead_out(ground, plan, Among::Samples, answer) {
                    return true;
                }
                if self.refine.is_stopped() {
                    return false;
                }
                let (id, depth) = self.pool[at];
                if self.refine.label(ground, ground.boundary.config(id)) == Label::Free {
                    self.take_sample(ground, id, depth, true, answer);
                    return true;
                }
            }
            looked = self.pool.len();
            if looked < count {
                let is_tried = looked > LOOKED_AT;
                return (!is_tried && self.lead_out(ground, plan, Among::Samples, answer))
                    || self.any_free(ground, answer);
            }
            count = MORE * looked.max(LOOKED_AT / MORE);
        }
    }

    /// Makes the nearest of the exits that were found the answer that is free now.
    fn free_exit(&mut self, ground: &Ground, answer: &mut Answer) -> bool {
        let mut left = EXITS_LOOKED_AT;
        for at in 0..self.near_exits.len() {
            if left == 0 || self.refine.is_stopped() {
                return false;
            }
            let (id, depth) = self.near_exits[at];
            let planes = Start::of(ground, id).planes;
            if planes.is_some_and(|planes| planes.iter().any(|(room, _)| room < -SURE)) {
                continue;
            }
            left -= 1;
            if self.refine.label(ground, ground.boundary.config(id)) == Label::Free {
                self.take_sample(ground, id, depth, true, answer);
                return true;
            }
        }
        false
    }

    /// Makes the end of a descent from one of the nearest exits or samples that were found the answer.
    fn lead_out(&mut self, ground: &Ground, plan: &Plan, among: Among, answer: &mut Answer) -> bool {
        // Only who asked for the query may end it without a witness.
        let stop = self.refine.limit.stop.clone();
        let limit = std::mem::replace(&mut self.refine.limit, Limit { stop, ..Limit::default() });
        (answer.depth, answer.verified) = (f64::INFINITY, false);
        for at in 0..LED_OUT {
            let near = if among == Among::Exits { &self.near_exits } else { &self.pool };
            let Some(&(id, distance)) = near.get(at) else { break };
            let start = Start::at(ground.boundary.config(id));
            self.refine_from(ground, &plan.refine, start, f64::INFINITY, answer);
            if answer.verified {
                answer.coverage = ground.coverage.of(distance);
                break;
            }
        }
        self.refine.limit = limit;
        answer.verified
    }

    /// Makes the first free configuration of a low-discrepancy sequence the answer.
    fn any_free(&mut self, ground: &Ground, answer: &mut Answer) -> bool {
        let space = &ground.checker.scene().space;
        let halton = Halton::new(space.nv(), 0);
        for index in 0..LAST_RESORT {
            if self.refine.is_stopped() {
                return false;
            }
            halton.config(space, index, &mut answer.witness);
            if self.refine.label(ground, &answer.witness) == Label::Free {
                answer.verified = true;
                answer.depth = self.refine.distance(ground, &self.anchor, &answer.witness);
                answer.coverage = ground.coverage.of(f64::INFINITY);
                return true;
            }
        }
        false
    }
}

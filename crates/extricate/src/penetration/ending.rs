//! How a query ends: the best ways out carried to their ends, and an answer that was verified.

use super::Ground;
use super::answer::Answer;
use super::plan::Plan;
use super::refine::Start;
use super::search::{QueryScratch, REMEMBERED};
use crate::cspace::Label;

/// A way out of pieces this much farther than the nearest one may turn out to be nearer out of the meshes.
const AS_NEAR: f64 = 1.03;

impl QueryScratch {
    /// Carries the best way out to its end, and others that may be as near.
    pub(super) fn polish_all(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        let best = answer.depth;
        self.polish(ground, plan, answer);
        self.polish_others(ground, plan, AS_NEAR * best, answer);
    }

    /// Checks an answer that no descent was verified for; where it collides, which only rounding makes of what pieces keep clear, the one before.
    pub(super) fn settle(&mut self, ground: &Ground, answer: &mut Answer) {
        self.trusts_pieces = false;
        if answer.verified {
            return;
        }
        answer.verified = self.refine.label(ground, &answer.witness) == Label::Free;
        if !answer.verified {
            answer.depth = self.fallback.0;
            answer.witness.clone_from(&self.fallback.1);
            answer.verified = self.refine.label(ground, &answer.witness) == Label::Free;
        }
    }

    pub(super) fn polish(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        if self.refine.is_spent() {
            return;
        }
        let mut best = std::mem::take(&mut self.best);
        best.clear();
        best.extend_from_slice(&answer.witness);
        self.refine_from(ground, &plan.polish, Start::at(&best), answer.depth, answer);
        self.best = best;
    }

    /// Where descents saw meshes as pieces around them, carries the other ways out that were nearer than `most` to their ends too: pieces stand out
    /// differently.
    fn polish_others(&mut self, ground: &Ground, plan: &Plan, most: f64, answer: &mut Answer) {
        if ground.checker.all_convex() {
            return;
        }
        let mut best = std::mem::take(&mut self.best);
        for rank in 1..REMEMBERED {
            let other = self.exits.iter().nth(rank).filter(|(depth, _)| *depth < most);
            let Some((_, config)) = other.filter(|_| !self.refine.is_spent()) else { break };
            best.clear();
            best.extend_from_slice(config);
            self.refine_from(ground, &plan.polish, Start::at(&best), answer.depth, answer);
        }
        self.best = best;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LearnOptions;
    use crate::model::Model;
    use crate::model::measure::tests::colliding;
    use crate::penetration::answer::free_answer;
    use crate::penetration::options::{Effort, QueryOptions};
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    /// What pieces keep clear the exact check calls free, up to rounding; here an answer is made up that it does not.
    #[test]
    fn an_answer_that_collides_gives_way_to_the_one_before() {
        let options = LearnOptions { labels: 3_000, seconds: None, ..LearnOptions::default() };
        let scene = builtin::scene("shelf-arm").unwrap();
        let model = Model::learn(scene, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let (ground, mut scratch) = (model.ground(), QueryScratch::default());
        for q in colliding(&model, 5) {
            let found = model.query(&q, &QueryOptions::default(), &mut scratch);
            assert!(found.verified);
            scratch.fallback = (found.depth, found.witness.clone());
            let mut answer = free_answer(&q, model.scene().space.nv(), Effort::Refined);
            answer.verified = false;
            scratch.refine.begin();
            scratch.settle(&ground, &mut answer);
            assert_eq!((answer.verified, answer.depth, &answer.witness), (true, found.depth, &found.witness));
        }
    }
}

//! What is said about a witness once it is chosen.

use super::Ground;
use super::answer::{Answer, Exit, TOUCHING, Way};
use super::certificate::{self, Look};
use super::options::{Effort, QueryOptions};
use super::search::QueryScratch;
use crate::collision::{SegmentOptions, SegmentOutcome};
use crate::scene::MetricSpec;

/// Step of central differences \[rad or m\]: both the curvature they leave out and the digits they lose are then about 1e-10.
const DIFFERENCE: f64 = 1e-5;

impl QueryScratch {
    /// Fills in all but witness and depth.
    pub(super) fn describe(&mut self, ground: &Ground, options: &QueryOptions, answer: &mut Answer) {
        let Self { refine, anchor, far_anchor, motion, overlaps, .. } = self;
        if options.tells_contacts() {
            let margin = ground.clearance + TOUCHING;
            answer.contacts.extend_from_slice(refine.touching(ground, &answer.witness, margin));
            answer.touching.extend(answer.contacts.iter().map(|contact| contact.pair));
            answer.touching.dedup();
            ground.metric.anchor_at(&answer.witness, refine.check.poses(), far_anchor);
        } else {
            ground.metric.anchor(&answer.witness, far_anchor);
        }
        answer.max_displacement = ground.metric.max_displacement_at(anchor, &far_anchor.poses);
        let poses = &anchor.poses;
        let (colliding, ceiling) = (&answer.colliding, answer.depth);
        let bound = if options.effort == Effort::Nearest {
            let look = (Look::Quick, ceiling);
            certificate::lower_bound(ground, poses, colliding, &[], look, motion, &mut refine.check)
        } else {
            overlaps.clear();
            ground.checker.convex_overlaps(&anchor.q, colliding, &mut refine.check, overlaps);
            let look = (Look::Close, ceiling);
            certificate::lower_bound(ground, poses, colliding, overlaps, look, motion, &mut refine.check)
        };
        answer.lower_bound = bound.min(answer.depth);
        self.gradient(ground, answer);
        if options.exits > 1 {
            self.describe_exits(ground, answer);
        }
        if answer.verified {
            let space = &ground.checker.scene().space;
            answer.unique = !self.exits.rival(space, &mut self.local, answer.depth, &answer.witness);
        }
        if options.way {
            answer.way = Some(self.way(ground, answer));
        }
        answer.checks = self.refine.checks;
    }

    /// Where the witness stays the best, moving it changes the depth by nothing to first order: what is left is the gradient of the
    /// distance to it.
    fn gradient(&mut self, ground: &Ground, answer: &mut Answer) {
        let Self { anchor, far_anchor, quadratic, refine, moved, step, .. } = self;
        // The distance is symmetric: half its square, seen from the witness, has this gradient at the query, times the depth.
        match ground.metric.kind() {
            MetricSpec::Joint => {
                ground.metric.joint_gradient(far_anchor, &anchor.q, &mut answer.gradient);
                return answer.gradient.iter_mut().for_each(|slope| *slope /= answer.depth);
            }
            MetricSpec::ObjectNorm => {
                ground.metric.quadratic_model(far_anchor, &anchor.q, &anchor.poses, quadratic);
                let slopes = quadratic.gradient.iter().map(|slope| slope / answer.depth);
                return answer.gradient.iter_mut().zip(slopes).for_each(|(out, slope)| *out = slope);
            }
            MetricSpec::MaxDisplacement => {}
        }
        // Its model has a few points of each body only; the farthest one need not be among them.
        let space = &ground.checker.scene().space;
        step.clear();
        step.resize(space.nv(), 0.0);
        moved.resize(space.nq(), 0.0);
        for k in 0..space.nv() {
            let mut change = 0.0;
            for sign in [1.0, -1.0] {
                step[k] = sign * DIFFERENCE;
                space.integrate(&anchor.q, step, moved);
                change += sign * ground.metric.distance_from(far_anchor, moved, &mut refine.metric);
            }
            step[k] = 0.0;
            answer.gradient[k] = change / (2.0 * DIFFERENCE);
        }
    }

    fn describe_exits(&mut self, ground: &Ground, answer: &mut Answer) {
        let margin = ground.clearance + TOUCHING;
        let Self { exits, refine, .. } = self;
        for (depth, witness) in exits.iter() {
            let mut touching: Vec<usize> = refine.touching(ground, witness, margin).iter().map(|c| c.pair).collect();
            touching.dedup();
            answer.exits.push(Exit { depth, witness: witness.to_vec(), touching });
        }
        if answer.exits.is_empty() {
            let (witness, touching) = (answer.witness.clone(), answer.touching.clone());
            answer.exits.push(Exit { depth: answer.depth, witness, touching });
        }
    }

    fn way(&mut self, ground: &Ground, answer: &Answer) -> Way {
        self.refine.checks += 1;
        let (from, to) = (&answer.witness[..], &self.anchor.q[..]);
        match ground.checker.segment(from, to, &SegmentOptions::default(), &mut self.refine.check) {
            // The query collides, so this is not to be expected; it claims the least.
            SegmentOutcome::Free => Way { colliding_until: 1.0, free_from: 1.0 },
            SegmentOutcome::Contact { free_until, colliding_at: at, .. }
            | SegmentOutcome::Undecided { free_until, near_at: at, .. } => {
                Way { colliding_until: 1.0 - at, free_from: 1.0 - free_until }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LearnOptions;
    use crate::collision::{CheckScratch, ContactQuery, ContactSearch};
    use crate::model::Model;
    use crate::model::measure::tests::colliding;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    /// What the last descent saw of its end is not looked at again; it has to be what a look would see.
    #[test]
    fn contacts_are_those_of_a_look_at_the_witness_alone() {
        for name in ["planar-arm", "hand"] {
            let options = LearnOptions { labels: 30_000, seconds: None, ..LearnOptions::default() };
            let model =
                Model::learn(builtin::scene(name).unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap();
            let (mut scratch, mut seen) = (QueryScratch::default(), 0);
            for q in colliding(&model, 100) {
                let answer = model.query(&q, &QueryOptions::default(), &mut scratch);
                let margin = model.scene().clearance + TOUCHING;
                let look = ContactQuery { margin, search: ContactSearch::Exact };
                let mut contacts = Vec::new();
                model.checker().contacts(&answer.witness, look, &mut CheckScratch::default(), &mut contacts);
                contacts.sort_by_key(|contact| contact.pair);
                assert_eq!(contacts.len(), answer.contacts.len(), "{name} {q:?}");
                for (told, found) in answer.contacts.iter().zip(&contacts) {
                    assert_eq!(told.pair, found.pair);
                    assert!((told.distance - found.distance).abs() < 1e-9, "{name} {q:?}: {told:?} {found:?}");
                    // Of points 0.1 mm apart on round shapes: searches from elsewhere end 1e-9 m from each other.
                    assert!((told.normal - found.normal).norm() < 1e-4, "{name} {q:?}: {told:?} {found:?}");
                }
                seen += contacts.len();
            }
            assert!(seen > 100, "{name}: {seen}");
        }
    }
}

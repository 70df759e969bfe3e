//! The proxy of a continuous stream, which only moves where its whole way is proved free.
//!
//! The nearest exit jumps when another becomes nearer, and the straight segment there leads through
//! collisions. A proxy goes toward the query as far as contacts let it. Its direction changes with
//! the contacts, and the answer reports those that hold it.

use crate::collision::{ContactQuery, ContactSearch, SegmentBudget, SegmentOptions, SegmentOutcome};
use crate::cspace::Label;
use crate::metric::Anchor;
use crate::query::constraints::MAX_HALVINGS;
use crate::query::context::{Context, TouchingPairs};
use crate::query::descent::subproblem::Subproblem;
use crate::query::evaluate::Evaluator;
use crate::query::plan::MARGIN;
use crate::query::qp::QpOutcome;

/// Distance beyond the scene's clearance that a proxy aims at by default \[m\]: moves along a
/// contact are proved in stretches of about this length.
pub const DEFAULT_MARGIN_M: f64 = 5e-4;
/// Most steps of the proxy in a frame.
const MAX_STEPS: usize = 8;
/// Most stretches in which a move is proved, so that a frame takes a bounded time. The next frames
/// continue a longer move.
const MAX_STRETCHES: usize = 64;
/// A step of which less than this share is proved free is tried again, shorter.
const RETRIED_SHARE: f64 = 0.1;
/// Trust region of the shorter try, as a share of the step.
const SHRINK_SHARE: f64 = 0.3;
/// A step is the last if it brings the proxy nearer by less than this share of its distance.
const TOLERANCE_SHARE: f64 = 1e-3;
/// A step of a detour that is not proved in one go is halved this often.
const HALVINGS_OF_A_STEP: usize = 4;
/// Halvings in which the longest allowed part of a move is found.
const HALVINGS_OF_A_MOVE: usize = 30;
/// Contacts are constraints within this multiple of the farthest motion, at least four default
/// margins.
const REACH_FACTOR: f64 = 1.2;

/// A free configuration that follows the query.
///
/// # Source
/// M. Ortega, S. Redon and S. Coquillart, "A six degree-of-freedom god-object method for haptic
/// display of rigid bodies with surface properties", IEEE Transactions on Visualization and
/// Computer Graphics 13(3), 2007, doi:10.1109/TVCG.2007.1028: the proxy moves in the direction that
/// contacts allow, as far as continuous collision detection finds it free. Deviations: articulated
/// models; several steps a frame; bounds prove the motion free, including the clearance.
#[derive(Default)]
pub struct Proxy {
    /// Present configuration; empty before the first frame.
    pub config: Vec<f64>,
    target: Vec<f64>,
    subproblem: Subproblem,
    /// Whether no configuration near the last step keeps the clearance that was aimed at.
    is_tight: bool,
}

impl Proxy {
    /// Moves toward the anchor along contacts at the clearance `aim` \[m\]. It exceeds the scene's,
    /// so that every straight move is proved free in `context`. In too narrow a place, the excess
    /// is halved until the proxy can move. Pairs that touch in `context` stay in touch if they can.
    /// Returns the clearance that was aimed at last.
    pub fn follow(&mut self, context: &Context, aim: f64, anchor: &Anchor, evaluator: &mut Evaluator) -> f64 {
        let (mut clearance, before) = (aim, self.config.clone());
        for halvings in 0..=MAX_HALVINGS {
            clearance = context.clearance + (aim - context.clearance) * 0.5_f64.powi(halvings);
            let checker = context.checker.with_clearance(clearance);
            self.is_tight = false;
            let aimed = Context { checker: &checker, clearance, ..*context };
            self.settle(context, &aimed, evaluator);
            let settled = self.config.clone();
            self.go_toward(context, &aimed, anchor, evaluator);
            let has_moved = self.config != settled;
            self.settle(context, &aimed, evaluator);
            // The parts of the move are proved, but not the straight segment over all of them.
            let is_bent = !context.kept.is_empty() && self.config != before;
            if is_bent && proved(context, &aimed, (&before, &self.config), evaluator) < 1.0 {
                self.config.copy_from_slice(&settled);
            }
            if !self.is_tight || has_moved {
                break;
            }
        }
        clearance
    }

    /// Moves straight toward `target`, all the way or half of it and so on, if that is proved free.
    /// Returns whether it moved.
    pub fn goes_some_way(
        &mut self,
        context: &Context,
        aim: f64,
        mut target: Vec<f64>,
        evaluator: &mut Evaluator,
    ) -> bool {
        let aimed = Context { clearance: aim, ..*context };
        for _ in 0..=HALVINGS_OF_A_STEP {
            if proved(context, &aimed, (&self.config, &target), evaluator) >= 1.0 {
                self.config.copy_from_slice(&target);
                return true;
            }
            let far = target.clone();
            context.checker.scene().space.interpolate(&self.config, &far, 0.5, &mut target);
        }
        false
    }

    /// Shortens the move of a frame that began at `before` and is proved, if it is longer than
    /// `most` (metric units).
    pub fn move_at_most(&mut self, context: &Context, before: &[f64], most: f64, evaluator: &mut Evaluator) {
        if context.metric.distance(before, &self.config) > most {
            let part = toward(context, before, &self.config, most);
            // Interpolation rounds, and the rounded configuration is not proved.
            let is_free = evaluator.label(context, &part) == Label::Free;
            self.config.copy_from_slice(if is_free { &part } else { before });
        }
    }

    /// Moves straight to where the links are kept, as far as that is proved free.
    fn settle(&mut self, context: &Context, aimed: &Context, evaluator: &mut Evaluator) {
        if context.kept.is_empty() {
            return;
        }
        let start = self.config.clone();
        self.target.clone_from(&start);
        if evaluator.project(context, &mut self.target) && self.target != start {
            let share = proved(context, aimed, (&start, &self.target), evaluator);
            self.go(context, (&start, share), evaluator);
        }
    }

    fn go_toward(&mut self, context: &Context, aimed: &Context, anchor: &Anchor, evaluator: &mut Evaluator) {
        let start = self.config.clone();
        if evaluator.label(aimed, &anchor.q) == Label::Free
            && proved(context, aimed, (&start, &anchor.q), evaluator) >= 1.0
        {
            self.config.copy_from_slice(&anchor.q);
            return;
        }
        let mut distance = evaluator.distance(context, anchor, &self.config);
        // A step must not leave the range in which contacts are known.
        let most = MARGIN / context.metric.lever().max(1e-9);
        let (mut radius, mut has_moved) = (distance.max(1e-3 * context.scale).min(most), false);
        for _ in 0..MAX_STEPS {
            if distance <= 0.0 || evaluator.is_spent() {
                return;
            }
            let Some(length) = self.step(aimed, anchor, (distance, radius), evaluator) else { return };
            let share = proved(context, aimed, (&start, &self.target), evaluator);
            if share < 1.0 && has_moved {
                // The segment from the start is not proved; the next frame goes on from here.
                return;
            }
            self.go(context, (&start, share), evaluator);
            has_moved |= share > 0.0;
            let now = evaluator.distance(context, anchor, &self.config);
            if share < RETRIED_SHARE {
                (radius, has_moved) = (SHRINK_SHARE * length.min(radius), false);
                self.config.copy_from_slice(&start);
            } else if share < 1.0 || distance - now < TOLERANCE_SHARE * distance {
                return;
            }
            if radius < TOLERANCE_SHARE * distance {
                return;
            }
            distance = if has_moved { now } else { distance };
        }
    }

    /// Sets `target` to the end of a step along the contacts. Returns its length, or `None` if it
    /// is negligible or no step keeps the clearance.
    fn step(
        &mut self,
        aimed: &Context,
        anchor: &Anchor,
        (distance, radius): (f64, f64),
        evaluator: &mut Evaluator,
    ) -> Option<f64> {
        let reach = (REACH_FACTOR * distance.min(radius) * aimed.metric.lever()).max(4.0 * DEFAULT_MARGIN_M);
        let query = ContactQuery { margin: aimed.clearance + reach, search: ContactSearch::Exact };
        evaluator.contacts_at(aimed, &self.config, query);
        let poses = evaluator.check.poses();
        let Self { subproblem, config, target, .. } = self;
        aimed.metric.quadratic_model(anchor, config, poses, &mut subproblem.quadratic);
        let apart = Context { touching: TouchingPairs::default(), ..*aimed };
        // Pairs that cannot all stay in touch may part.
        let tries = if aimed.touching.pairs.is_empty() { &[aimed][..] } else { &[aimed, &apart] };
        let is_possible = tries.iter().any(|context| {
            subproblem.build(context, config, radius, (&evaluator.contacts, poses));
            subproblem.solve(f64::INFINITY) != QpOutcome::Infeasible
        });
        if !is_possible {
            self.is_tight = true;
            return None;
        }
        let length = subproblem.clip_step();
        target.resize(config.len(), 0.0);
        aimed.checker.scene().space.integrate(config, &subproblem.step, target);
        if !evaluator.project(aimed, target) {
            return None;
        }
        (length > TOLERANCE_SHARE * TOLERANCE_SHARE * distance).then_some(length)
    }

    /// Moves by the proved share of the straight segment from `start` to the target.
    fn go(&mut self, context: &Context, (start, share): (&[f64], f64), evaluator: &mut Evaluator) {
        if share >= 1.0 {
            self.config.copy_from_slice(&self.target);
            return;
        }
        let mut moved = vec![0.0; start.len()];
        context.checker.scene().space.interpolate(start, &self.target, share, &mut moved);
        // Interpolation rounds, and the rounded configuration is not proved.
        if is_free(context, &moved, evaluator) {
            self.config.copy_from_slice(&moved);
        }
    }
}

/// Whether a configuration is free, even if links are off there: they may be on the way of a proxy.
/// What [`Evaluator::label`] remembers as free may be so for other links.
pub fn is_free(context: &Context, q: &[f64], evaluator: &mut Evaluator) -> bool {
    if context.kept.is_empty() {
        return evaluator.label(context, q) == Label::Free;
    }
    evaluator.checks += 1;
    context.checker.scene().space.is_within(q) && context.checker.label(q, &mut evaluator.check) == Label::Free
}

/// Returns the last configuration on the segment that is at most `most` (metric units) from its
/// beginning. Distances of some metrics are no share of the segment's, so it halves the rest.
pub fn toward(context: &Context, from: &[f64], to: &[f64], most: f64) -> Vec<f64> {
    let (space, mut reached) = (&context.checker.scene().space, to.to_vec());
    if context.metric.distance(from, to) <= most {
        return reached;
    }
    let [mut near, mut far] = [0.0, 1.0];
    for _ in 0..HALVINGS_OF_A_MOVE {
        let middle = 0.5 * (near + far);
        space.interpolate(from, to, middle, &mut reached);
        let is_near = context.metric.distance(from, &reached) <= most;
        *(if is_near { &mut near } else { &mut far }) = middle;
    }
    space.interpolate(from, to, near, &mut reached);
    reached
}

/// Returns the share of a straight segment that is proved free.
fn proved(context: &Context, aimed: &Context, (from, to): (&[f64], &[f64]), evaluator: &mut Evaluator) -> f64 {
    let options = SegmentOptions { resolution: 0.5 * (aimed.clearance - context.clearance) };
    evaluator.checks += 1;
    let budget = SegmentBudget { stretches: MAX_STRETCHES, ..SegmentBudget::UNLIMITED };
    match context.checker.segment_within((from, to), &options, &budget, &mut evaluator.check) {
        SegmentOutcome::Free => 1.0,
        SegmentOutcome::Contact { free_until, .. } | SegmentOutcome::Undecided { free_until, .. } => free_until,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Follower, StreamOptions};
    use super::*;
    use crate::applications::motion::testing::labelled;
    use crate::collision::CheckScratch;
    use crate::query::QueryOptions;
    use crate::query::keep::{KeptLink, LinkConstraint, Projection};
    use crate::query::prepared::Prepared;
    use crate::scene::builtin;
    use rand::{RngExt, SeedableRng};

    /// The queries move between random configurations in small frames. Every move of the proxy has
    /// to be proved, it is never nearer than the nearest exit, and it follows into the open.
    #[test]
    fn a_proxy_never_jumps_and_never_lags_in_the_open() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(9);
        for name in ["planar-arm", "shelf-arm", "free-box"] {
            let world = Prepared::new(builtin::scene(name).unwrap());
            let (space, checker) = (&world.scene().space, world.checker());
            let (mut scratch, resolution) = (CheckScratch::default(), SegmentOptions { resolution: 2e-5 });
            let (mut frames, mut behind, mut reached) = (0, 0, 0);
            for _ in 0..3 {
                let options = StreamOptions { continuous: true, ..StreamOptions::default() };
                let mut stream = Follower::new(options, QueryOptions::default());
                let halton = crate::cspace::sampling::Halton::new(space.nv(), rng.random());
                let mut ends = [vec![0.0; space.nq()], vec![0.0; space.nq()]];
                ends.iter_mut().enumerate().for_each(|(k, q)| halton.config(space, k as u64, q));
                let (mut before, mut q) = (Vec::new(), vec![0.0; space.nq()]);
                for frame in 0..40 {
                    space.interpolate(&ends[0], &ends[1], f64::from(frame) / 200.0, &mut q);
                    let answer = stream.query(&world.context(), &space.config_anywhere(&q).unwrap()).unwrap();
                    let nearest = answer.nearest.unwrap();
                    assert!(answer.verified && answer.depth >= nearest - 1e-9, "{name}: {} {nearest}", answer.depth);
                    assert!(answer.lower_bound <= nearest + 1e-9, "{name}");
                    if !before.is_empty() {
                        let moved = checker.segment(&before, &answer.witness, &resolution, &mut scratch);
                        let is_contact = matches!(moved, SegmentOutcome::Contact { .. });
                        assert!(!is_contact, "{name}, frame {frame}: {moved:?}");
                        frames += 1;
                    }
                    behind += usize::from(answer.depth > 1.05 * nearest + 1e-3);
                    reached += usize::from(answer.is_free() && answer.depth == 0.0);
                    before = answer.witness.into();
                }
            }
            assert!(
                frames > 100 && reached + behind > 5,
                "{name}: {frames} frames, {reached} reached, {behind} behind"
            );
        }
    }

    /// The queries move at random, and each holds the gripper where it has it. A frame has an
    /// answer if the proxy could follow; between answers of successive frames it moved where all is
    /// proved free.
    #[test]
    fn a_proxy_keeps_links_or_has_no_answer() {
        let world = Prepared::new(builtin::scene("shelf-arm").unwrap());
        let (scene, checker) = (world.scene(), world.checker());
        let keep = KeptLink::from_text(scene, r#"{"link": "gripper", "rotation": null}"#).unwrap();
        let options = QueryOptions::default().keep(keep.clone());
        let mut stream = Follower::new(StreamOptions { continuous: true, ..StreamOptions::default() }, options.clone());
        let ends = labelled(checker, Label::Colliding, 6, 3);
        let (mut answered, mut possible, mut q) = (0, 0, vec![0.0; scene.space.nq()]);
        let (mut projection, mut check, mut query) = Default::default();
        for (from, to) in ends.iter().zip(&ends[1..]) {
            let mut before: Option<Vec<f64>> = None;
            for frame in 0..30 {
                scene.space.interpolate(from, to, f64::from(frame) / 1000.0, &mut q);
                let config = scene.space.config(&q).unwrap();
                let answer = stream.query(&world.context(), &config);
                possible += usize::from(crate::query::query(&world.context(), &config, &options, &mut query).is_some());
                answered += usize::from(answer.is_some());
                let after = answer.map(|answer| {
                    let kept = LinkConstraint::all(scene, &keep, &q);
                    assert!(answer.verified && Projection::keeps(&mut projection, scene, &kept, &answer.witness));
                    answer.witness.to_vec()
                });
                if let (Some(before), Some(after)) = (&before, &after) {
                    let options = SegmentOptions { resolution: 2e-5 };
                    let moved = checker.segment(before, after, &options, &mut check);
                    assert!(!matches!(moved, SegmentOutcome::Contact { .. }), "{frame}: {moved:?}");
                }
                before = after;
            }
        }
        assert!(possible > 50 && 10 * answered >= 9 * possible, "{answered} answered, {possible} possible");
    }
}

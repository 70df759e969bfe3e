//! Releases a grasp, in these steps.
//!
//! 1. Find the links that touch at the query ([`Grip`]). A free query is the answer.
//! 2. Open the fingers to where they first touched ([`first_touch`]): there, their side of the
//!    object is known.
//! 3. Descend from there, along the contacts, to what is nearest to the query.
//! 4. If a link lost its contact, descend again while the pairs that touched may not part.
//! 5. If fingers changed their side, repeat in stages from the first touch toward the query. A
//!    finger that changes its side in a stage stays where it was before.
//! 6. Verify the best with the exact checker.

use super::grip::Grip;
use super::hand::Hand;
use super::opening::first_touch;
use super::options::{Keep, ReleaseOptions};
use super::report::{Grasp, report};
use super::weights::base_weights;
use crate::cspace::{Config, Label};
use crate::metric::Anchor;
use crate::query::constraints::{SearchResult, under};
use crate::query::descent::prune::Pruning;
use crate::query::descent::{DescentScratch, Start, descend};
use crate::query::evaluate::Evaluator;
use crate::query::plan::Plan;
use crate::query::termination::Deadline;
use crate::query::{Context, Effort, QueryOptions, QueryScratch, Stop, TouchingPairs, nearest_exit};
use crate::scene::{PairId, Scene};
use crate::solver::Solver;

/// Gap that held pairs may have, as a share of the touch distance. With less, contacts are hardly
/// straight enough for a step.
const HELD_GAP_SHARE: f64 = 0.25;
/// Stages from the first touch to the query, used if fingers changed their side.
const SIDE_STAGES: usize = 5;
/// Exits that are compared if descents from the first touch find nothing.
const COMPARED_EXITS: usize = 4;

impl Solver {
    /// Searches for the nearest configuration to `q` at which nothing penetrates, what touched the
    /// object still touches it, and each finger is on its side. Returns `None` if nothing free was
    /// found, or if a stop ends the query before it begins.
    ///
    /// `q` may lie beyond limits ([`crate::ConfigSpace::config_anywhere`]). The scene has to be the
    /// one that the hand was made for, or one with the same bodies and pairs.
    ///
    /// # Guarantee
    /// [`Grasp::verified`]: the exact checker called the configuration free, in every checked pair,
    /// during this call. Nothing is proved about how near it is.
    ///
    /// # Cost
    /// A few descents: about as much as a query. No model is used.
    pub fn release(&self, hand: &Hand, q: &Config, options: &ReleaseOptions) -> Option<Grasp> {
        let context = self.prepared().context();
        self.memory().of_queries(|scratch| release(hand, &context, q, options, scratch))
    }
}

impl Hand {
    /// Returns the scene with weights of a floating or planar base that make moving the hand about
    /// as expensive as moving its fingers. Returns `None` if the base is fixed or has weights other
    /// than 1. Metrics other than `joint` measure the bodies themselves and give `None` too.
    ///
    /// With equal weights a metre counts as a radian, and the base runs away before a finger moves.
    /// With these weights, moving the base by the length `l` counts as turning a joint by 1 rad.
    /// Here `l` is how far a radian of a joint moves what it carries, root mean square over the
    /// volume and the joints.
    pub fn weighted(scene: &Scene) -> Option<Scene> {
        let weights = base_weights(scene);
        let named = weights.iter().map(|(name, weights)| (name.as_str(), *weights));
        if weights.is_empty() { None } else { scene.weighted(named).ok() }
    }
}

pub fn release(
    hand: &Hand,
    context: &Context,
    q: &Config,
    options: &ReleaseOptions,
    scratch: &mut QueryScratch,
) -> Option<Grasp> {
    if options.query.termination.stop.as_ref().is_some_and(Stop::is_asked) {
        return None;
    }
    let mut grasp = under(context, q, &options.query, scratch, |context, query, _, scratch| {
        let options = &ReleaseOptions { query: query.clone(), ..options.clone() };
        let mut release = Release::begin(hand, context, q, options, scratch);
        let found = match options.keep {
            _ if release.is_free(q) => Some(q.to_vec()),
            Keep::Contacts => {
                let mut within = q.to_vec();
                context.checker.scene().space.clamp(&mut within);
                release.keeping_contacts(&within)
            }
            Keep::Pose => None,
        };
        let config = found.or_else(|| release.nearest_exit(q))?;
        let moved = release.scratch.evaluator.distance(context, &release.anchor, &config);
        let Release { before, touched, scratch, sides, .. } = release;
        let kept_sides = sides.as_ref().is_none_or(|sides| {
            let now = Grip::at(hand, context, &config, Some(options.touch), &mut scratch.evaluator.check);
            let both: Vec<bool> = now.touching(options.touch).iter().zip(&touched).map(|(a, b)| *a && *b).collect();
            !now.turned(hand, sides, &both).contains(&true)
        });
        let found = (config, moved, kept_sides);
        Some(report(hand, context, options, (&before, &touched), found, &mut scratch.evaluator))
    })?;
    grasp.checks = scratch.checks();
    Some(grasp)
}

impl SearchResult for Grasp {
    fn nearest(&self) -> (f64, &[f64]) {
        (self.moved, &self.config)
    }
}

struct Release<'a> {
    hand: &'a Hand,
    context: &'a Context<'a>,
    options: &'a ReleaseOptions,
    plan: Plan,
    anchor: Anchor,
    scratch: &'a mut QueryScratch,
    /// The grip at the query.
    before: Grip,
    /// Whether each link touched at the query.
    touched: Vec<bool>,
    /// The grip at the first touch, whose normals define the sides.
    sides: Option<Grip>,
}

/// A free configuration to which a descent led.
struct Candidate {
    config: Vec<f64>,
    depth: f64,
    /// Whether each link touched at the query and still does.
    kept: Vec<bool>,
    /// Whether each finger is on the wrong side.
    turned: Vec<bool>,
}

impl<'a> Release<'a> {
    fn begin(
        hand: &'a Hand,
        context: &'a Context<'a>,
        q: &Config,
        options: &'a ReleaseOptions,
        scratch: &'a mut QueryScratch,
    ) -> Self {
        scratch.evaluator.begin(Deadline::of(&options.query.termination));
        let mut anchor = Anchor::default();
        context.metric.anchor(q, &mut anchor);
        let before = Grip::at(hand, context, q, Some(options.touch), &mut scratch.evaluator.check);
        let touched = before.touching(options.touch);
        let plan = Plan::of(&options.query, context);
        Self { hand, context, options, plan, anchor, scratch, before, touched, sides: None }
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.scratch.evaluator.label(self.context, q) == Label::Free
    }

    /// Carries out steps 2 to 5.
    fn keeping_contacts(&mut self, q: &[f64]) -> Option<Vec<f64>> {
        let open = self.options.open.as_deref();
        let first = first_touch(self.hand, self.context, q, open, &mut self.scratch.evaluator.check);
        let sides = Grip::at(self.hand, self.context, &first, None, &mut self.scratch.evaluator.check);
        self.sides = Some(sides);
        let mut best = self.slide(&first, &[], None);
        for attempt in 0..2 {
            let lost = self.lost(best.as_ref(), attempt > 0);
            if lost.is_empty() || self.scratch.evaluator.is_spent() {
                break;
            }
            let from = best.as_ref().map_or_else(|| first.clone(), |best| best.config.clone());
            let found = self.slide(&from, &lost, None);
            best = self.better(best, found);
        }
        let staged = match &best {
            Some(best) if !best.turned.contains(&true) => None,
            _ => self.in_stages(&first, q),
        };
        let best = self.better(best, staged)?;
        Some(best.config)
    }

    /// Returns the pairs to hold if a link lost its contact: those of all links that touched. If
    /// `is_modest`: that of the nearest such link of each finger, if a whole finger lost contact.
    fn lost(&mut self, best: Option<&Candidate>, is_modest: bool) -> Vec<PairId> {
        let Self { hand, context, touched, scratch, .. } = self;
        let Some(best) = best else { return self.pairs_of(&self.touched) };
        let is_lost = |at: usize| touched[at] && !best.kept[at];
        if !(0..touched.len()).any(is_lost) {
            return Vec::new();
        }
        if !is_modest {
            return self.pairs_of(&self.touched);
        }
        let now = Grip::at(hand, context, &best.config, None, &mut scratch.evaluator.check);
        let kept = Grip::fingers(hand, &best.kept);
        let fingers = Grip::fingers(hand, touched);
        if fingers.iter().zip(&kept).all(|(touched, kept)| touched == kept) {
            return Vec::new();
        }
        let mut held = vec![false; touched.len()];
        for finger in (0..fingers.len()).filter(|finger| fingers[*finger]) {
            let own = (0..touched.len()).filter(|at| touched[*at] && hand.links[*at].finger == Some(finger));
            let nearest = own.min_by(|a, b| now.gaps[*a].total_cmp(&now.gaps[*b]));
            nearest.into_iter().for_each(|at| held[at] = true);
        }
        self.pairs_of(&held)
    }

    fn pairs_of(&self, links: &[bool]) -> Vec<PairId> {
        self.hand.links.iter().zip(links).filter(|(_, is_one)| **is_one).map(|(link, _)| link.pair).collect()
    }

    /// Carries out step 3 while the pairs `touching` may not part. A stage has an anchor of its own
    /// to descend toward, and coordinates that stay.
    fn slide(&mut self, from: &[f64], touching: &[PairId], stage: Option<(&Anchor, &[bool])>) -> Option<Candidate> {
        let most = self.context.clearance + HELD_GAP_SHARE * self.options.touch;
        let (anchor, locked) = stage.unwrap_or((&self.anchor, self.context.locked));
        let context = Context {
            touching: TouchingPairs { pairs: touching, most, aim: most, are_required: false },
            locked,
            ..*self.context
        };
        let pruning = Pruning { factor: self.plan.prune_factor, ..Pruning::alone(f64::INFINITY) };
        let QueryScratch { descent, evaluator, .. } = &mut *self.scratch;
        let go = |from: &[f64], options, descent: &mut DescentScratch, evaluator: &mut Evaluator| {
            let depth = descend(&context, anchor, Start::at(from), pruning, options, descent, evaluator).0;
            depth.map(|_| descent.best.clone())
        };
        let first = go(from, &self.plan.descent, descent, evaluator);
        let from = first.clone().unwrap_or_else(|| descent.end.clone());
        let last = go(&from, &self.plan.polish, descent, evaluator);
        let mut found = [last, first].into_iter().flatten();
        let config = found.find(|config| self.scratch.evaluator.label(self.context, config) == Label::Free)?;
        Some(self.candidate(config))
    }

    fn candidate(&mut self, config: Vec<f64>) -> Candidate {
        let depth = self.scratch.evaluator.distance(self.context, &self.anchor, &config);
        let touch = self.options.touch;
        let now = Grip::at(self.hand, self.context, &config, Some(touch), &mut self.scratch.evaluator.check);
        let kept: Vec<bool> = now.touching(touch).iter().zip(&self.touched).map(|(a, b)| *a && *b).collect();
        let turned = self.sides.as_ref().map(|sides| now.turned(self.hand, sides, &kept)).unwrap_or_default();
        Candidate { config, depth, kept, turned }
    }

    /// Carries out step 5.
    fn in_stages(&mut self, first: &[f64], q: &[f64]) -> Option<Candidate> {
        let space = &self.context.checker.scene().space;
        let mut locked = match self.context.locked {
            [] => vec![false; space.nv()],
            locked => locked.to_vec(),
        };
        let (mut at, mut goal, mut anchor) = (first.to_vec(), q.to_vec(), Anchor::default());
        let mut best = None;
        for stage in 1..=SIDE_STAGES {
            space.interpolate(first, q, stage as f64 / SIDE_STAGES as f64, &mut goal);
            self.context.metric.anchor(&goal, &mut anchor);
            let mut found = self.slide(&at, &[], Some((&anchor, &locked)));
            if let Some(turned) =
                found.as_ref().map(|found| found.turned.clone()).filter(|turned| turned.contains(&true))
            {
                let fingers = self.hand.fingers.iter().zip(turned).filter(|(_, turned)| *turned);
                let factors = fingers.flat_map(|(finger, _)| finger.factors.iter().map(|at| &space.factors()[*at]));
                factors.flat_map(|factor| factor.tangents()).for_each(|v| locked[v] = true);
                found = self.slide(&at, &[], Some((&anchor, &locked)));
            }
            if let Some(found) = found.filter(|found| !found.turned.contains(&true)) {
                at.clone_from(&found.config);
                best = Some(found);
            }
        }
        best
    }

    /// Prefers fewer fingers on the wrong side, then more fingers that touch, more links that
    /// touch, and the smaller depth.
    fn better(&self, one: Option<Candidate>, other: Option<Candidate>) -> Option<Candidate> {
        let rank = |candidate: &Candidate| {
            let count = |some: &[bool]| some.iter().filter(|is_one| **is_one).count() as i64;
            let fingers = count(&Grip::fingers(self.hand, &candidate.kept));
            (-count(&candidate.turned), fingers, count(&candidate.kept))
        };
        let (Some(a), Some(b)) = (&one, &other) else { return one.or(other) };
        let is_better = rank(b).cmp(&rank(a)).then(a.depth.total_cmp(&b.depth)).is_gt();
        if is_better { other } else { one }
    }

    /// Returns the nearest free configuration, whatever it touches. If contacts were to be kept, it
    /// is the one of a few exits that keeps most.
    fn nearest_exit(&mut self, q: &Config) -> Option<Vec<f64>> {
        let exits = if self.options.keep == Keep::Contacts { COMPARED_EXITS } else { 1 };
        let options =
            QueryOptions { effort: Effort::Refined, exits, toward: None, gap: None, ..self.options.query.clone() };
        let checks = self.scratch.evaluator.checks;
        let answer = nearest_exit(self.context, q, &options, self.scratch)?;
        self.scratch.evaluator.checks += checks;
        let own = answer.verified.then(|| answer.witness.to_vec());
        let others: Vec<_> = self.scratch.known.exits.iter().take(exits).map(|end| end.config.clone()).collect();
        let mut best = None;
        for config in own.into_iter().chain(others) {
            if self.is_free(&config) {
                let candidate = self.candidate(config);
                best = self.better(best, Some(candidate));
            }
        }
        Some(best?.config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::applications::grasp::hand::tests::with_ball;
    use crate::collision::{CheckScratch, Checker};
    use crate::scene::Scene;
    use crate::solver::Solver;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const CURLS: [usize; 3] = [1, 3, 4];

    /// Closes every finger until it touches, and then by a further `by()`.
    fn squeezed(checker: &Checker, spread: [f64; 2], by: &mut dyn FnMut() -> f64) -> Vec<f64> {
        let mut scratch = CheckScratch::default();
        let mut q = vec![spread[0], 0.0, spread[1], 0.0, 0.0];
        for curl in CURLS {
            while checker.label(&q, &mut scratch) == Label::Free && q[curl] < 1.6 {
                q[curl] += 0.01;
            }
            q[curl] -= 0.01;
        }
        CURLS.iter().for_each(|curl| q[*curl] += by());
        q
    }

    fn release_of(scene: &Scene, q: &[f64], options: &ReleaseOptions) -> Option<Grasp> {
        let solver = Solver::new(scene.clone());
        let hand = Hand::new(scene, "ball").unwrap();
        solver.release(&hand, &scene.config(q).unwrap(), options)
    }

    /// Whatever the squeeze, nothing penetrates any more, and nearly all fingers still touch on
    /// their sides. They move about as far as the squeeze, even if the nearest exit is past the
    /// ball.
    #[test]
    fn squeezed_fingers_are_released_and_still_touch() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (mut fingers, mut all) = (0, 0);
        for (radius, squeeze) in [(0.03, 0.05), (0.03, 0.15), (0.03, 0.3), (0.012, 0.3), (0.012, 0.6)] {
            let scene = with_ball(radius);
            let checker = Checker::new(scene.clone().into());
            for _ in 0..10 {
                let spread = [0.4 * rng.random::<f64>() - 0.2, 0.4 * rng.random::<f64>() - 0.2];
                let q = squeezed(&checker, spread, &mut || squeeze * (0.5 + rng.random::<f64>()));
                if scene.config(&q).is_err() || checker.label(&q, &mut CheckScratch::default()) == Label::Free {
                    continue;
                }
                let grasp = release_of(&scene, &q, &ReleaseOptions::default()).unwrap();
                assert!(grasp.verified && grasp.kept_sides, "{radius} {squeeze} {q:?}: {grasp:?}");
                assert_eq!(checker.label(&grasp.config, &mut CheckScratch::default()), Label::Free);
                assert!(grasp.moved <= 1.5 * squeeze * 3.0_f64.sqrt() + 0.1, "{radius} {squeeze}: {grasp:?}");
                (fingers, all) = (fingers + grasp.fingers[1], all + grasp.fingers[0]);
            }
        }
        assert!(all > 100 && fingers as f64 >= 0.97 * all as f64, "{fingers} of {all}");
    }

    #[test]
    fn a_free_grasp_stays_and_another_posture_is_the_nearest() {
        let scene = with_ball(0.03);
        let checker = Checker::new(scene.clone().into());
        let q = squeezed(&checker, [0.1, -0.1], &mut || 0.0);
        let grasp = release_of(&scene, &q, &ReleaseOptions::default()).unwrap();
        assert_eq!((&*grasp.config, grasp.moved), (q.as_slice(), 0.0));
        assert!(grasp.contacts.len() >= 3 && grasp.kept == grasp.touched);
        let q = squeezed(&checker, [0.1, -0.1], &mut || 0.2);
        let held = release_of(&scene, &q, &ReleaseOptions::default()).unwrap();
        let pose = ReleaseOptions { keep: Keep::Pose, ..ReleaseOptions::default() };
        let nearest = release_of(&scene, &q, &pose).unwrap();
        assert!(nearest.verified && nearest.moved <= held.moved + 1e-6, "{} {}", nearest.moved, held.moved);
    }

    #[test]
    fn locked_joints_stay() {
        let scene = with_ball(0.03);
        let q = squeezed(&Checker::new(scene.clone().into()), [0.1, -0.1], &mut || 0.2);
        let mut options = ReleaseOptions::default();
        options.query.locked = scene.joints_named("locked", ["index_spread", "middle_spread"]).unwrap();
        let grasp = release_of(&scene, &q, &options).unwrap();
        assert!(grasp.verified && grasp.config[0] == q[0] && grasp.config[2] == q[2], "{grasp:?}");
        // If no joint may move, there is no answer.
        options.query.locked = (0..scene.joints.len()).collect();
        assert_eq!(release_of(&scene, &q, &options), None);
    }
}

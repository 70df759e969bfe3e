//! The search for the nearest way out: starts, probes, descents, in an order that any budget may cut short.

use std::time::{Duration, Instant};

use super::Ground;
use super::answer::{Answer, free_answer};
use super::exits::Exits;
use super::local_metric::LocalMetric;
use super::options::{QueryBudget, QueryOptions};
use super::plan::{HOPE, Plan};
use super::refine::{RefineOptions, RefineScratch, Start, slide};
use super::scatter::{ScatterScratch, scatter};
use super::turns::Lead;
use super::wander::{WanderScratch, wander};
use crate::boundary::{BoundaryScratch, Wanted};
use crate::collision::ConvexOverlap;
use crate::cspace::{Config, ConfigSpace, Label};
use crate::metric::Anchor;
use crate::metric::motion_bound::MotionPath;
use crate::metric::quadratic::Quadratic;

/// Memory that queries reuse; one per thread.
#[derive(Default)]
pub struct QueryScratch {
    pub(super) refine: RefineScratch,
    pub(super) boundary: BoundaryScratch,
    pub(super) motion: MotionPath,
    pub(super) overlaps: Vec<ConvexOverlap>,
    scatter: ScatterScratch,
    pub(super) local: LocalMetric,
    wander: WanderScratch,
    pub(super) anchor: Anchor,
    /// Of the witness, for the gradient.
    pub(super) far_anchor: Anchor,
    pub(super) quadratic: Quadratic,
    pub(super) moved: Vec<f64>,
    pub(super) step: Vec<f64>,
    /// Whether descents are believed where the pieces around meshes keep the clearance, until the last one.
    pub(super) trusts_pieces: bool,
    /// What the answer was before one was believed: its depth and witness.
    pub(super) fallback: (f64, Vec<f64>),
    /// Where a stream has come from.
    pub(super) lead: Lead,
    /// Where a last descent starts.
    pub(super) best: Vec<f64>,
    pub(super) pool: Vec<(u32, f64)>,
    pub(super) near_exits: Vec<(u32, f64)>,
    /// A sample nearer than what descents found; the pool is still needed by the plan that comes after.
    nearer: Vec<(u32, f64)>,
    pub(super) chosen: Vec<u32>,
    /// The same with how far they are, where they are put in order.
    pub(super) ordered: Vec<(f64, u32)>,
    /// Flat coordinates of what was chosen, row major.
    pub(super) places: Vec<f64>,
    pub(super) slid: Vec<f64>,
    /// What the probed descents are expected to reach, and which they are.
    promising: Vec<(f64, usize)>,
    /// Where they stand, row major.
    ends: Vec<f64>,
    /// Ways out: those wanted, or, where one is, the best few, to tell whether it is alone.
    pub(super) exits: Exits,
}

/// First radius of the trust region of descents in turn, as a share of the distance to the query: longer steps find more, and deeper overlaps, which
/// take longer to look at.
const RADIUS_IN_TURN: f64 = 0.45;
/// Ways out that are remembered where one is wanted.
pub(super) const REMEMBERED: usize = 4;

impl QueryScratch {
    /// Begins a query from `q`, which is where time and checks begin to count: whether and where it collides.
    pub(super) fn begin(&mut self, ground: &Ground, q: &Config, options: &QueryOptions) -> Answer {
        // Seconds that no clock can hold are no limit; negative ones and NaN are none left.
        let until = |seconds: f64| match Duration::try_from_secs_f64(seconds.max(0.0)) {
            Ok(duration) => Instant::now().checked_add(duration),
            Err(_) => None,
        };
        let QueryBudget { checks, seconds } = options.budget;
        let limit = &mut self.refine.limit;
        (limit.checks, limit.deadline) = (checks, seconds.and_then(until));
        // Queries of a batch share one: counting who holds it, each anew, would have threads wait for each other.
        if limit.stop != options.stop {
            limit.stop.clone_from(&options.stop);
        }
        self.refine.check.forget_contacts();
        self.refine.begin();
        self.lead.config.clear();
        let space = &ground.checker.scene().space;
        let mut answer = free_answer(q, space.nv(), options.effort);
        if options.tells_contacts() {
            ground.checker.colliding_pairs(q, &mut self.refine.check, &mut answer.colliding);
        } else {
            answer.colliding.extend(ground.checker.colliding_pair(q, &mut self.refine.check));
        }
        if !answer.colliding.is_empty() {
            ground.metric.anchor_at(q, self.refine.check.poses(), &mut self.anchor);
            let wanted = if options.exits > 1 { options.exits } else { REMEMBERED };
            self.exits.reset(wanted, space.nq());
        }
        answer
    }

    /// Makes the nearest sample the answer (or the nearest exit, where the plan begins there), as far as the plan takes care, and fills the pool of
    /// the plan; where they are stale, see [`QueryScratch::first_free`]. False where no witness was found.
    pub(super) fn first_witness(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) -> bool {
        self.near_exits.clear();
        if plan.begins_at_exits() {
            return self.first_exit(ground, plan, answer);
        }
        if ground.is_stale() {
            return self.first_free(ground, plan, answer);
        }
        let wanted = Wanted { care: plan.care, ..Wanted::NEAREST };
        let Self { anchor, boundary, pool, .. } = self;
        ground.boundary.nearest(wanted, ground.metric, anchor, plan.pool(), boundary, pool);
        let Some(&(id, depth)) = self.pool.first() else { return false };
        self.take_sample(ground, id, depth, false, answer);
        true
    }

    /// Makes the nearest of the exits that the plan chooses of the answer.
    fn first_exit(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) -> bool {
        self.pool.clear();
        self.find_exits(ground, plan);
        if ground.is_stale() {
            return self.first_free(ground, plan, answer);
        }
        let Some(&(id, depth)) = self.near_exits.first() else { return false };
        self.take_sample(ground, id, depth, false, answer);
        true
    }

    /// Makes a sample the answer.
    pub(super) fn take_sample(&self, ground: &Ground, id: u32, depth: f64, verified: bool, answer: &mut Answer) {
        (answer.depth, answer.verified) = (depth, verified);
        answer.coverage = ground.coverage.of(depth);
        answer.witness.copy_from_slice(ground.boundary.config(id));
    }

    /// An exact check, counted.
    pub(crate) fn label(&mut self, ground: &Ground, q: &[f64]) -> Label {
        self.refine.label(ground, q)
    }

    /// Other ways out with their depths, distinct from the answer and from each other, where descents of the last query ended besides: nearest first,
    /// not carried to the last digit and not checked. At most four where one was wanted.
    pub(crate) fn other_ways_out(&mut self, space: &ConfigSpace, answer: &Answer) -> Vec<(f64, Vec<f64>)> {
        let Self { exits, local, .. } = self;
        let others = exits.besides(space, local, answer.depth, &answer.witness);
        others.map(|(depth, config)| (depth, config.to_vec())).collect()
    }

    /// Checks of the last query so far.
    pub(crate) fn checks(&self) -> usize {
        self.refine.checks
    }

    /// Takes the metric at the query.
    pub(super) fn look_around(&mut self, ground: &Ground) {
        self.local.set(ground, &self.anchor, &self.anchor.poses);
    }

    /// Refines from the chosen samples and from the query itself; keeps the best verified result in `answer`, and where several
    /// are wanted those in `exits`.
    pub(super) fn refine_all(&mut self, ground: &Ground, plan: &Plan, options: &QueryOptions, answer: &mut Answer) {
        let several = options.exits > 1;
        self.forget_probes();
        // Of the nearest sample: what looks around the query may start from and end at, whatever the descents before them find.
        let first = answer.depth;
        let ceiling = if several { f64::INFINITY } else { first };
        let chosen = std::mem::take(&mut self.chosen);
        let in_turn = plan.in_turn.filter(|_| !several);
        self.fallback.0 = answer.depth;
        self.fallback.1.clone_from(&answer.witness);
        // The last descent looks at the meshes themselves.
        self.trusts_pieces = in_turn.is_some() && !ground.checker.all_convex();
        ground.boundary.fetch_planes(&chosen);
        if let Some(hope) = in_turn {
            self.descend_in_turn(
                ground,
                &RefineOptions { hope, radius: RADIUS_IN_TURN, ..plan.refine },
                &chosen,
                answer,
            );
        } else {
            chosen.iter().for_each(|id| self.probe(ground, &plan.probe, Start::of(ground, *id), ceiling, answer));
        }
        self.chosen = chosen;
        if plan.begins_at_exits() && !several {
            self.look_for_nearer_sample(ground, plan, answer);
        }
        self.look_near(ground, plan, first, ceiling, answer);
        if plan.scatter_again {
            let ceiling = if several { f64::INFINITY } else { answer.depth };
            self.probe_scattered(ground, plan, answer.depth, ceiling, answer);
        }
        if several {
            self.carry_on_to_several(ground, plan, answer);
        } else {
            self.carry_on(ground, plan, answer);
        }
        self.settle(ground, answer);
    }

    /// Probes from the query itself and from free configurations around it, nearer than `within`, as the plan says. After what was chosen: labels around
    /// the query take fifty checks and more, which a query of few is better off spending on descents.
    fn look_near(&mut self, ground: &Ground, plan: &Plan, within: f64, ceiling: f64, answer: &mut Answer) {
        if plan.from_query {
            let mut start = std::mem::take(&mut self.best);
            start.clear();
            start.extend_from_slice(&self.anchor.q);
            self.probe(ground, &plan.probe, Start::at(&start), ceiling, answer);
            self.best = start;
        }
        self.probe_scattered(ground, plan, within, ceiling, answer);
    }

    /// Takes a sample for the answer where one is nearer than all that descents have found: which is seldom, and mostly told by the lists alone.
    fn look_for_nearer_sample(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        let wanted = Wanted { within: answer.depth, care: plan.care, ..Wanted::NEAREST };
        let Self { anchor, boundary, nearer, .. } = self;
        ground.boundary.nearest(wanted, ground.metric, anchor, 1, boundary, nearer);
        let Some((id, depth)) = nearer.pop().filter(|(_, depth)| *depth < answer.depth) else { return };
        if ground.is_stale() && self.refine.label(ground, ground.boundary.config(id)) == Label::Colliding {
            return;
        }
        (answer.depth, answer.verified) = (depth, false);
        answer.witness.copy_from_slice(ground.boundary.config(id));
        self.fallback.0 = depth;
        self.fallback.1.clone_from(&answer.witness);
    }

    /// Notes the way out in `slid`.
    pub(super) fn remember(&mut self, ground: &Ground, depth: f64) {
        self.exits.offer(&ground.checker.scene().space, &mut self.local, depth, &self.slid);
    }

    /// Puts the most promising probes first.
    fn sort_probes(&mut self) {
        self.promising.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Forgets where probes ended.
    pub(super) fn forget_probes(&mut self) {
        self.ends.clear();
        self.promising.clear();
    }

    /// Carries the most promising probes on, and the best of all to its end.
    pub(super) fn carry_on(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        self.sort_probes();
        self.promising.truncate(plan.kept);
        let (promising, ends) = (std::mem::take(&mut self.promising), std::mem::take(&mut self.ends));
        let nq = answer.witness.len();
        for (expected, at) in &promising {
            if *expected > HOPE * answer.depth || self.refine.is_spent() {
                break;
            }
            let found =
                self.refine_from(ground, &plan.refine, Start::at(&ends[at * nq..(at + 1) * nq]), answer.depth, answer);
            if let Some(depth) = found {
                self.remember(ground, depth);
            }
        }
        (self.promising, self.ends) = (promising, ends);
        self.trusts_pieces = false;
        // The descents so far were cut short; the best one is carried to its end.
        self.polish_all(ground, plan, answer);
        if answer.verified && plan.wander > 0 {
            let Self { anchor, local, wander: wandering, refine, .. } = self;
            let best = (&mut answer.witness[..], answer.depth);
            answer.depth = wander(ground, anchor, best, plan.wander, local, wandering, refine);
            self.polish(ground, plan, answer);
        }
    }

    /// Carries probes on until no other is expected to end among the wanted ones, each to its end.
    fn carry_on_to_several(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        self.sort_probes();
        let (promising, ends) = (std::mem::take(&mut self.promising), std::mem::take(&mut self.ends));
        let nq = answer.witness.len();
        // The best found while probing, which need not be where a probe ended.
        let best = answer.clone();
        let starts = promising.iter().map(|(expected, at)| (*expected, &ends[at * nq..(at + 1) * nq]));
        for (expected, start) in std::iter::once((0.0, &best.witness[..])).chain(starts) {
            if self.refine.is_spent() || expected > HOPE * self.exits.ceiling() {
                break;
            }
            let ceiling = self.exits.ceiling();
            let Some(mut exit) = self.descend(ground, &plan.refine, start, ceiling, answer) else { continue };
            self.polish(ground, plan, &mut exit);
            if plan.wander > 0 {
                let Self { anchor, local, wander: wandering, refine, .. } = self;
                let place = (&mut exit.witness[..], exit.depth);
                exit.depth = wander(ground, anchor, place, plan.wander, local, wandering, refine);
                self.polish(ground, plan, &mut exit);
            }
            self.exits.offer(&ground.checker.scene().space, &mut self.local, exit.depth, &exit.witness);
            if exit.depth < answer.depth || !answer.verified {
                (answer.depth, answer.verified) = (exit.depth, true);
                answer.witness.copy_from_slice(&exit.witness);
            }
        }
        (self.promising, self.ends) = (promising, ends);
    }

    /// One descent on its own: `frame` with a verified witness of its own, wherever another's is.
    fn descend(
        &mut self,
        ground: &Ground,
        options: &RefineOptions,
        start: &[f64],
        ceiling: f64,
        frame: &Answer,
    ) -> Option<Answer> {
        let mut exit = Answer { depth: f64::INFINITY, verified: false, ..frame.clone() };
        self.refine_from(ground, options, Start::at(start), ceiling, &mut exit);
        exit.verified.then_some(exit)
    }

    /// The first steps of a descent, given up where it is not expected to end nearer than `ceiling`; where it stands then and what it is expected to
    /// reach are noted.
    pub(super) fn probe(
        &mut self,
        ground: &Ground,
        options: &RefineOptions,
        start: Start,
        ceiling: f64,
        answer: &mut Answer,
    ) {
        if self.refine.is_spent() {
            return;
        }
        self.refine_from(ground, options, start, ceiling, answer);
        self.promising.push((self.refine.expected, self.promising.len()));
        self.ends.extend_from_slice(self.refine.end());
    }

    /// Probes from free configurations around the query, nearer than `within`.
    pub(super) fn probe_scattered(
        &mut self,
        ground: &Ground,
        plan: &Plan,
        within: f64,
        ceiling: f64,
        answer: &mut Answer,
    ) {
        let Self { anchor, local, scatter: scattered, refine, .. } = self;
        scatter(ground, anchor, within, &plan.scatter, local, scattered, refine);
        let scattered = std::mem::take(&mut self.scatter.starts);
        for start in scattered.chunks_exact(self.anchor.q.len()) {
            self.probe(ground, &plan.probe, Start::at(start), ceiling, answer);
        }
        self.scatter.starts = scattered;
    }

    /// Refines from `start`; a better result replaces the answer's witness if the exact checker calls it free. The end, in `slid`,
    /// is at the depth that is returned.
    pub(super) fn refine_from(
        &mut self,
        ground: &Ground,
        options: &RefineOptions,
        start: Start,
        ceiling: f64,
        answer: &mut Answer,
    ) -> Option<f64> {
        let depth = slide(ground, &self.anchor, start, ceiling, options, &mut self.slid, &mut self.refine)?;
        let is_nearer = depth < answer.depth || (!answer.verified && depth <= answer.depth);
        if is_nearer && (self.trusts_pieces || self.refine.label(ground, &self.slid) == Label::Free) {
            answer.depth = depth;
            answer.witness.copy_from_slice(&self.slid);
            answer.verified = !self.trusts_pieces;
        }
        Some(depth)
    }
}

//! Descent: slides a configuration along the contact surface toward the query (sequential quadratic
//! programming).

mod cuts;
pub mod prune;
mod start;
pub mod subproblem;

use std::ops::ControlFlow;

use super::context::Context;
use super::evaluate::Evaluator;
use super::qp::QpOutcome;
use crate::collision::{Contact, ContactQuery, ContactSearch};
use crate::cspace::Label;
use crate::kinematics::forward;
use crate::math::Pose;
use crate::metric::Anchor;
use crate::samples::contact_planes::Planes;
use crate::scene::MetricKind;
use cuts::{Cut, add_cuts};
use prune::Pruning;
pub use start::Start;
use subproblem::Subproblem;

/// A descent aims at this much more than the clearance \[m\], so that a linearised step ends on the
/// free side.
///
/// It costs depth: this times the slope of depth over clearance, 1e-6 rad for a lever of one metre.
const SLACK_M: f64 = 1e-7;
/// The slack along raw meshes, as a share of the length to which the descent's tolerance
/// corresponds.
const SLACK_SHARE: f64 = 0.05;
/// Contacts within this of the clearance are always evaluated \[m\].
const MIN_MARGIN_M: f64 = 0.001;
/// The trust region shrinks to this share of a rejected step.
const REJECTED_STEP_SHARE: f64 = 0.35;
/// An overlapping descent is stuck if no step longer than this share of the distance to the query
/// helps. With 0.01 queries take a twenty-fifth fewer checks, but under the metrics of bodies one
/// query in fifty more ends over 1 % farther.
const STUCK_STEP_SHARE: f64 = 0.001;
/// A step shorter than this share of the space's diameter counts as zero.
const ZERO_STEP_SHARE: f64 = 1e-12;
/// A descent toward a known end is given up if it is not expected to end nearer than this share of
/// the incumbent. The last descent finds the remaining digits.
const KNOWN_END_SHARE: f64 = 0.99;

/// Effort and accuracy of a descent.
#[derive(Debug, Clone, Copy)]
pub struct DescentOptions {
    /// Most iterations; each mostly evaluates the near contacts once.
    pub iterations: usize,
    /// Largest distance \[m\] beyond the clearance at which contacts are constraints.
    pub margin: f64,
    /// The same limit as a share of the farthest motion of any point; the smaller limit holds.
    pub reach: f64,
    /// How contacts are searched for.
    pub search: ContactSearch,
    /// Initial radius of the trust region, as a share of the distance to the query.
    pub radius: f64,
    /// The descent ends if a step would change the depth by less than this share of it.
    pub tolerance: f64,
}

/// Why a descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It was given up because it cannot beat the incumbent.
    Pruned,
    /// It was given up because it leads to the end of another descent.
    Known,
    /// It converged, got stuck, or spent its iterations or the budget.
    Ended,
}

/// Memory that descents reuse.
#[derive(Default)]
pub struct DescentScratch {
    /// The nearest configuration of the last descent whose contacts all kept the clearance, if any.
    pub best: Vec<f64>,
    /// Configuration at which the last descent ended.
    pub end: Vec<f64>,
    trial: Vec<f64>,
    subproblem: Subproblem,
    poses: Vec<Pose>,
    contacts: Vec<Contact>,
    /// Poses and contacts at the end of a rejected step.
    hit_poses: Vec<Pose>,
    hit: Vec<Contact>,
}

/// Minimises the distance to the anchor from `start`, subject to clearance and limits.
///
/// Each iteration linearises the signed distances of the near contacts and solves a quadratic
/// program in a trust region. It accepts the step if a merit function falls: half the squared
/// distance plus a penalty on the worst violation. A descent is given up if it is not expected to
/// beat the incumbent, or to end elsewhere than other descents of the search.
///
/// # Guarantee
/// `Some(depth)` with a configuration in `scratch.best` whose contacts all kept the clearance; the
/// caller verifies it with the exact checker. `None` if no such configuration was met.
pub fn descend(
    context: &Context,
    anchor: &Anchor,
    start: Start,
    pruning: Pruning,
    options: &DescentOptions,
    scratch: &mut DescentScratch,
    evaluator: &mut Evaluator,
) -> (Option<f64>, Outcome) {
    let Some(mut descent) = Descent::at(context, anchor, start, pruning, options, scratch, evaluator) else {
        return (None, Outcome::Ended);
    };
    if descent.starts_in_vain(&start) {
        return (None, Outcome::Pruned);
    }
    descent.evaluate_start();
    for iteration in 0..options.iterations {
        if let ControlFlow::Break(outcome) = descent.iterate(iteration) {
            return (descent.found, outcome);
        }
    }
    (descent.found, Outcome::Ended)
}

struct Descent<'a> {
    context: &'a Context<'a>,
    anchor: &'a Anchor,
    pruning: Pruning<'a>,
    options: &'a DescentOptions,
    scratch: &'a mut DescentScratch,
    evaluator: &'a mut Evaluator,
    /// Contact planes of the start, until contacts are evaluated.
    planes: Option<Planes<'a>>,
    /// Whether a configuration without contacts below the clearance is free.
    is_complete: bool,
    /// Distance of the present configuration from the query (metric units).
    distance: f64,
    /// By how much \[m\] the worst contact misses the clearance.
    violation: f64,
    /// How far beyond the clearance contacts are evaluated, now and at most \[m\].
    margin: f64,
    widest: f64,
    /// Radius of the trust region (metric units).
    radius: f64,
    penalty: f64,
    cut: Option<Cut>,
    was_rejected: bool,
    /// Whether the linearised contacts contradict each other.
    contradicts: bool,
    /// Depth of the best configuration.
    found: Option<f64>,
}

impl<'a> Descent<'a> {
    /// Returns `None` if no configuration near the start keeps the links.
    fn at(
        context: &'a Context<'a>,
        anchor: &'a Anchor,
        start: Start<'a>,
        pruning: Pruning<'a>,
        options: &'a DescentOptions,
        scratch: &'a mut DescentScratch,
        evaluator: &'a mut Evaluator,
    ) -> Option<Self> {
        for x in [&mut scratch.end, &mut scratch.trial] {
            x.clear();
            x.extend_from_slice(start.config);
        }
        if !evaluator.project(context, &mut scratch.end) {
            return None;
        }
        let (metric, distance) = (context.metric, evaluator.distance(context, anchor, &scratch.end));
        // The lever is the largest of all points, and most pairs part or meet at a fraction of it.
        // A reach of a tenth finds the same answers as half. A quarter of that finds other answers
        // for a hand, whose fingers are all near each other.
        let widest = (options.reach * distance * metric.lever()).clamp(MIN_MARGIN_M, options.margin);
        let is_complete = context.checker.contacts_are_complete(options.search);
        scratch.subproblem.slack = SLACK_M;
        if !is_complete {
            // Between triangles the linearised distances are off by micrometres, and one more
            // evaluation of the meshes takes as long as ten of their pieces.
            scratch.subproblem.slack = SLACK_M.max(SLACK_SHARE * options.tolerance * distance * metric.lever());
        }
        Some(Self {
            planes: start.planes.filter(|_| start.are_all),
            radius: (options.radius * distance).max(1e-3 * context.scale),
            margin: widest,
            violation: 0.0,
            penalty: 0.0,
            cut: None,
            was_rejected: false,
            contradicts: false,
            found: None,
            context,
            anchor,
            pruning,
            options,
            scratch,
            evaluator,
            is_complete,
            distance,
            widest,
        })
    }

    /// Whether the contact planes of the start already show that it is of no use. If some contacts
    /// have no plane, these only lead farther.
    fn starts_in_vain(&mut self, start: &Start) -> bool {
        let Some(planes) = start.planes else { return false };
        let Self { context, scratch, .. } = self;
        let DescentScratch { end, poses, subproblem, .. } = &mut **scratch;
        let scene = context.checker.scene();
        if context.metric.kind() != MetricKind::Joint {
            forward(scene, end, poses);
        }
        context.metric.quadratic_model(self.anchor, end, poses, &mut subproblem.quadratic);
        subproblem.projection_is_of_no_use(&scene.space, end, planes, self.distance, &self.pruning)
    }

    fn evaluate_start(&mut self) {
        if self.planes.is_none() {
            self.violation = self.evaluate_here();
        }
        if self.violation <= 0.0 {
            self.scratch.best.clone_from(&self.scratch.end);
            self.found = Some(self.distance);
        }
    }

    /// Evaluates the contacts of the present configuration; returns by how much \[m\] the worst
    /// misses the clearance.
    fn evaluate_here(&mut self) -> f64 {
        let query = ContactQuery { margin: self.context.clearance + self.margin, search: self.options.search };
        let violation = self.evaluator.contacts_at(self.context, &self.scratch.end, query);
        self.take_evaluated();
        violation
    }

    /// Copies the contacts and poses of the last evaluation.
    fn take_evaluated(&mut self) {
        self.planes = None;
        self.scratch.contacts.clone_from(&self.evaluator.contacts);
        self.scratch.poses.clear();
        self.scratch.poses.extend_from_slice(self.evaluator.check.poses());
    }

    /// Drops the last cut, if there is one. Depth and direction of a deep overlap may have nothing
    /// to do with the beginning of the step. Then no way seems to be left, though a shorter step
    /// would do.
    fn drops_cut(&mut self) -> bool {
        let Some(Cut { known_before, shorter }) = self.cut.take() else { return false };
        self.scratch.contacts.truncate(known_before);
        self.radius = shorter;
        true
    }

    fn iterate(&mut self, iteration: usize) -> ControlFlow<Outcome> {
        if self.evaluator.is_spent() {
            return ControlFlow::Break(Outcome::Ended);
        }
        let Self { context, scratch, .. } = self;
        let scene = context.checker.scene();
        let DescentScratch { end: x, poses, contacts, subproblem, .. } = &mut **scratch;
        context.metric.quadratic_model(self.anchor, x, poses, &mut subproblem.quadratic);
        let rows = match self.planes {
            Some(planes) => subproblem.build_from_planes(&scene.space, x, self.radius, (planes, context.locked)),
            None => subproblem.build(context, x, self.radius, (contacts, poses)),
        };
        let bends = !subproblem.quadratic.rows.is_empty();
        // The planes of the start were tested against the limit before.
        let limit = if self.planes.is_some() { f64::INFINITY } else { self.pruning.limit(iteration) };
        let has_evaluated = iteration > 0 || self.planes.is_some();
        // The program of an overlapping configuration may be infeasible, which does not mean far.
        let may_end = has_evaluated && self.violation <= 0.0 && !bends;
        let most = if may_end { 0.5 * (limit.powi(2) - self.distance * self.distance) } else { f64::INFINITY };
        let outcome = subproblem.solve(most);
        if outcome == QpOutcome::Above {
            return if self.drops_cut() { ControlFlow::Continue(()) } else { ControlFlow::Break(Outcome::Pruned) };
        }
        self.contradicts = outcome == QpOutcome::Infeasible;
        let length = subproblem.clip_step();
        let at_rim = subproblem.step_at_rim(self.radius);
        let wanted = if outcome == QpOutcome::Solved {
            2.0 * subproblem.qp.multiplier_sum(rows)
        } else {
            4.0 * self.distance * self.distance / context.clearance.max(1e-3)
        };
        self.penalty = self.penalty.max(wanted);
        // If the metric's model has rows of its own, a step to the rim of the trust region does not
        // yet show how far the descent may lead.
        if outcome == QpOutcome::Solved
            && (!at_rim || !bends)
            && let Some(outcome) = self.is_done(has_evaluated, limit)
        {
            return if self.drops_cut() { ControlFlow::Continue(()) } else { ControlFlow::Break(outcome) };
        }
        let least = self.options.tolerance * self.distance.max(1e-6 * self.context.scale);
        // If no joint can move along the normals of the contacts, the step is zero and the overlap
        // stays.
        let leads_nowhere = length <= ZERO_STEP_SHARE * self.context.scale;
        if leads_nowhere || (length <= least && self.violation <= 0.0) {
            return ControlFlow::Break(Outcome::Ended);
        }
        self.try_step(length, at_rim)
    }

    /// Returns an outcome if the program leads beyond the limit, to a known end, or hardly nearer
    /// than the present configuration.
    fn is_done(&mut self, has_evaluated: bool, limit: f64) -> Option<Outcome> {
        let DescentScratch { end: x, subproblem, .. } = &mut *self.scratch;
        let space = &self.context.checker.scene().space;
        let expected = subproblem.expected(self.distance);
        if has_evaluated && expected > limit {
            return Some(Outcome::Pruned);
        }
        if has_evaluated
            && expected > KNOWN_END_SHARE * self.pruning.incumbent
            && subproblem.leads_to_an_end(space, x, &self.pruning)
        {
            return Some(Outcome::Known);
        }
        let is_still = self.violation <= 0.0 && expected > (1.0 - self.options.tolerance) * self.distance;
        is_still.then_some(Outcome::Ended)
    }

    /// Evaluates the contacts at the end of the step, and accepts it if the merit function falls.
    fn try_step(&mut self, length: f64, at_rim: bool) -> ControlFlow<Outcome> {
        let Self { context, scratch, evaluator, .. } = self;
        let DescentScratch { end: x, trial, best, subproblem, .. } = &mut **scratch;
        context.checker.scene().space.integrate(x, &subproblem.step, trial);
        if !evaluator.project(context, trial) {
            return self.shorten(REJECTED_STEP_SHARE * length.min(self.radius));
        }
        let distance = evaluator.distance(context, self.anchor, trial);
        let query = ContactQuery { margin: context.clearance + self.margin, search: self.options.search };
        let mut violation = evaluator.contacts_at(context, trial, query);
        // The exact check differs from contacts by far less than this.
        let sure = if self.is_complete { -0.1 * SLACK_M } else { 0.0 };
        if violation <= sure && self.found.is_none_or(|depth| distance < depth) {
            if !self.is_complete && evaluator.label(context, trial) == Label::Colliding {
                // Contacts propose and the exact check decides: a body inside another has no near
                // contact.
                violation = context.clearance.max(SLACK_M);
            } else {
                best.clone_from(trial);
                self.found = Some(distance);
            }
        }
        let merit = |d: f64, v: f64| 0.5 * d * d + self.penalty * v.max(0.0);
        if merit(self.distance, self.violation) > merit(distance, violation) {
            self.accept(length, at_rim, distance, violation)
        } else {
            self.reject(length)
        }
    }

    fn accept(&mut self, length: f64, at_rim: bool, distance: f64, violation: f64) -> ControlFlow<Outcome> {
        std::mem::swap(&mut self.scratch.end, &mut self.scratch.trial);
        self.take_evaluated();
        self.cut = None;
        let change = (self.distance - distance).abs() / self.distance.max(1e-300);
        let done = change < self.options.tolerance && self.violation <= 0.0 && violation <= 0.0;
        (self.distance, self.violation) = (distance, violation);
        self.margin = (length * self.context.metric.lever()).clamp(MIN_MARGIN_M, self.widest);
        if at_rim {
            self.radius *= 2.0;
        }
        self.was_rejected = false;
        if done { ControlFlow::Break(Outcome::Ended) } else { ControlFlow::Continue(()) }
    }

    /// Adds the contacts of the rejected step as cuts. Keeps the radius if some are new and the
    /// step before was accepted. If a body lies flat on a face, contacts miss some of its corners,
    /// and a step may rotate one of them into the face. With the cut, a step of the same length may
    /// succeed.
    fn reject(&mut self, length: f64) -> ControlFlow<Outcome> {
        // Shorter steps mostly get stuck here too. Such descents took half of the checks of a
        // search and found an exit in one of some hundred queries. Other starts find more.
        if self.contradicts && self.violation > 0.0 && self.pruning.exits.is_some() {
            return ControlFlow::Break(Outcome::Ended);
        }
        self.scratch.hit.clone_from(&self.evaluator.contacts);
        self.scratch.hit_poses.clear();
        self.scratch.hit_poses.extend_from_slice(self.evaluator.check.poses());
        if self.margin < self.widest || self.planes.is_some() {
            self.margin = self.widest;
            self.evaluate_here();
        }
        let DescentScratch { contacts, poses, hit, hit_poses, .. } = &mut *self.scratch;
        let known_before = contacts.len();
        let learned = add_cuts(self.context.checker, (contacts, poses), (hit, hit_poses));
        let shorter = REJECTED_STEP_SHARE * length.min(self.radius);
        // Along smooth contacts and under the joint metric, dropping cuts finds nothing nearer for
        // up to a twenty-fifth more checks.
        let may_drop = self.context.metric.kind() != MetricKind::Joint || !self.is_complete;
        self.cut = (learned && may_drop).then_some(Cut { known_before, shorter });
        let radius = if !learned || self.was_rejected { shorter } else { self.radius };
        self.shorten(radius)
    }

    /// Sets the radius after a rejected step; the descent ends if it is too short.
    fn shorten(&mut self, radius: f64) -> ControlFlow<Outcome> {
        self.radius = radius;
        self.was_rejected = true;
        let least = if self.violation > 0.0 { STUCK_STEP_SHARE } else { self.options.tolerance };
        if self.radius < least * self.distance { ControlFlow::Break(Outcome::Ended) } else { ControlFlow::Continue(()) }
    }
}

//! Refinement: slide a configuration along the contact surface toward the query (sequential quadratic programming).

mod lesson;
mod program;

use super::Ground;
use super::hope::Hope;
use super::limit::Limit;
use super::qp::{Qp, QpOutcome};
use crate::boundary::tangents::Planes;
use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch};
use crate::cspace::Label;
use crate::kinematics::{Twists, forward};
use crate::math::Pose;
use crate::metric::{Anchor, MetricScratch, quadratic::Quadratic};
use crate::scene::MetricSpec;
use lesson::Lesson;

/// What refinement aims at beyond the clearance \[m\], so that a linearised step ends on the free side.
///
/// The depth it costs is this times the slope of depth over clearance, 1e-6 rad for a lever of one metre.
const SLACK: f64 = 1e-7;

/// Along raw meshes, the same as a share of the length that the descent's tolerance stands for.
const SLACK_SHARE: f64 = 0.05;

/// Contacts nearer than this are always looked at \[m\].
const LEAST_MARGIN: f64 = 0.001;

/// How far a refinement goes.
#[derive(Debug, Clone, Copy)]
pub struct RefineOptions {
    /// Most iterations; each evaluates the near contacts once.
    pub iterations: usize,
    /// Pairs nearer than this are constraints \[m\], where that is not more than `reach` asks for.
    pub margin: f64,
    /// The same as a share of the farthest that any point may have to move.
    pub reach: f64,
    /// How their contacts are searched for.
    pub search: ContactSearch,
    /// First radius of the trust region, as a share of the distance to the query.
    pub radius: f64,
    /// Ends when a step would change the depth by less than this share of it.
    pub tolerance: f64,
    /// When it is given up.
    pub hope: Hope,
}

/// Where a descent starts.
#[derive(Clone, Copy)]
pub struct Start<'a> {
    /// The configuration; it may collide.
    pub config: &'a [f64],
    /// Its contacts, where it is free and they are known: the first step then needs no look at them.
    pub planes: Option<Planes<'a>>,
    /// Whether it has no others: only then the planes tell where it is safe to go, else they only tell where it leads nowhere.
    pub are_all: bool,
}

/// Memory that refinement reuses.
#[derive(Default)]
pub struct RefineScratch {
    /// For the exact checker.
    pub check: CheckScratch,
    /// For distances.
    pub metric: MetricScratch,
    /// Exact checks and contact evaluations so far.
    pub checks: usize,
    /// Where they end.
    pub limit: Limit,
    /// The distance that the last descent's model expected to reach in the end.
    pub expected: f64,
    poses: Vec<Pose>,
    twists: Twists,
    /// Where a step that was not taken would have led.
    hit_poses: Vec<Pose>,
    /// What it taught, where the last one did.
    lesson: Option<Lesson>,
    contacts: Vec<Contact>,
    /// While a step is tried, those of where it begins; once it is not taken, those of where it would have led.
    other_contacts: Vec<Contact>,
    /// The configuration that was checked last, where `contacts` are all its exact ones nearer than a margin \[m\]; else empty.
    looked_at: Vec<f64>,
    looked_within: f64,
    /// The configuration that a check of this query last called free; else empty.
    called_free: Vec<f64>,
    /// What the present descent aims at beyond the clearance \[m\].
    slack: f64,
    quadratic: Quadratic,
    qp: Qp,
    trial: Vec<f64>,
    step: Vec<f64>,
    /// Of the metric, a coordinate each.
    inverse_weights: Vec<f64>,
    x: Vec<f64>,
    /// Where descents in turn of this query came to an end or near one, row major; not those that were given up for leading too far.
    ends: Vec<f64>,
    /// From where a step leads to one of them.
    rest: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl<'a> Start<'a> {
    /// From a configuration of which nothing is known.
    pub fn at(config: &'a [f64]) -> Self {
        Self { config, planes: None, are_all: false }
    }

    /// From a stored sample, with what is known of it in this scene.
    pub fn of(ground: &Ground<'a>, sample: u32) -> Self {
        let boundary = ground.boundary;
        let planes = boundary.planes(sample);
        let here = |planes: Planes<'a>| ground.change.map_or(planes, |change| planes.elsewhere(change.of_planes()));
        Self { config: boundary.config(sample), planes: planes.map(here), are_all: !ground.is_stale() }
    }
}

impl RefineScratch {
    /// Begins a query whose configuration was checked.
    pub fn begin(&mut self) {
        self.checks = 1;
        self.ends.clear();
        self.looked_at.clear();
        self.called_free.clear();
    }

    /// Whether the budget is spent.
    pub fn is_spent(&self) -> bool {
        self.limit.is_reached(self.checks)
    }

    /// Whether the caller ended the query.
    pub fn is_stopped(&self) -> bool {
        self.limit.is_stopped()
    }

    /// Where the last descent stood when it ended.
    pub fn end(&self) -> &[f64] {
        &self.x
    }

    /// An exact check, counted, unless the last one that found a free configuration was of the same.
    pub fn label(&mut self, ground: &Ground, q: &[f64]) -> Label {
        // A descent along meshes has its steps checked; where it ends is then known.
        if !self.called_free.is_empty() && self.called_free == q {
            return Label::Free;
        }
        self.checks += 1;
        if self.looked_at != q {
            self.looked_at.clear();
        }
        let label = ground.checker.label(q, &mut self.check);
        if label == Label::Free {
            self.called_free.clear();
            self.called_free.extend_from_slice(q);
        }
        label
    }

    /// Contacts of the pairs nearer than `margin` \[m\] at `q`, ascending by pair; `check` then holds its poses.
    pub fn touching(&mut self, ground: &Ground, q: &[f64], margin: f64) -> &[Contact] {
        if self.looked_at == q && self.looked_within >= margin {
            self.contacts.retain(|contact| contact.distance < margin);
            self.looked_within = margin;
        } else {
            self.contacts_at(ground, q, ContactQuery { margin, search: ContactSearch::Exact });
        }
        self.contacts.sort_by_key(|contact| contact.pair);
        &self.contacts
    }

    /// Distance from the anchor, in metric units.
    pub fn distance(&mut self, ground: &Ground, anchor: &Anchor, q: &[f64]) -> f64 {
        ground.metric.distance_from(anchor, q, &mut self.metric)
    }
}

/// Minimises the distance to the anchor from `start`, subject to clearance and limits.
///
/// Each iteration linearises the signed distances of the near contacts, solves a quadratic program in a trust region and
/// accepts the step if a merit function (half the squared distance plus a penalty on the worst violation) falls. A descent that
/// is not expected to end nearer than `ceiling`, or elsewhere than another one of the query, is given up.
///
/// # Guarantee
/// `Some(depth)` with a configuration in `best` whose contacts all kept the clearance; the caller verifies it with the
/// exact checker. `None` where no such configuration was met.
pub fn slide(
    ground: &Ground,
    anchor: &Anchor,
    start: Start,
    ceiling: f64,
    options: &RefineOptions,
    best: &mut Vec<f64>,
    scratch: &mut RefineScratch,
) -> Option<f64> {
    let scene = ground.checker.scene();
    let checks_before = scratch.checks;
    let mut x = std::mem::take(&mut scratch.x);
    let mut trial = std::mem::take(&mut scratch.trial);
    x.clear();
    x.extend_from_slice(start.config);
    trial.clear();
    trial.extend_from_slice(start.config);
    let mut distance = scratch.distance(ground, anchor, &x);
    // The lever is the largest there is and most pairs part or meet at a fraction of it: five times less finds the same answers,
    // a fourth of it (for a hand, whose fingers are all within a wide margin of each other) other ones.
    let widest = (options.reach * distance * ground.metric.lever()).clamp(LEAST_MARGIN, options.margin);
    let mut margin = widest;
    let complete = ground.checker.contacts_are_complete(options.search);
    scratch.slack = SLACK;
    if !complete {
        // Between triangles the linearised distances are off by micrometres, and one more look at the meshes takes as long as ten at their pieces.
        scratch.slack = SLACK.max(SLACK_SHARE * options.tolerance * distance * ground.metric.lever());
    }
    let within = |margin| ContactQuery { margin, search: options.search };
    let mut planes = start.planes.filter(|_| start.are_all);
    if planes.is_some() && ground.metric.kind() != MetricSpec::Joint {
        // The model of another metric needs the poses, which else come with contacts.
        forward(scene, &x, &mut scratch.poses);
    }
    if !start.are_all && scratch.leads_nowhere(ground, anchor, &start, distance, options.hope, ceiling) {
        scratch.x = x;
        scratch.trial = trial;
        return None;
    }
    let mut violation = match planes {
        Some(_) => 0.0,
        None => scratch.contacts_at(ground, &x, within(margin)),
    };
    if planes.is_none() {
        scratch.copy_poses();
    }
    let mut found = None;
    if violation <= 0.0 {
        best.clear();
        best.extend_from_slice(&x);
        found = Some(distance);
    }
    let mut radius = (options.radius * distance).max(1e-3 * ground.scale);
    let (mut penalty, mut retried, mut is_given_up) = (0.0_f64, false, false);
    scratch.lesson = None;
    // Along smooth contacts and under the metric of the joints it finds nothing nearer, for up to a twenty-fifth more checks.
    let may_unlearn = ground.metric.kind() != MetricSpec::Joint || !complete;
    // Well below what the exact check may differ by from a contact.
    let sure = if complete { -0.1 * SLACK } else { 0.0 };
    for iteration in 0..options.iterations {
        is_given_up = false;
        if scratch.is_spent() {
            break;
        }
        ground.metric.quadratic_model(anchor, &x, &scratch.poses, &mut scratch.quadratic);
        if iteration == 0
            && let Some((planes, hope)) = planes.zip(options.hope.of_foot())
            && scratch.foot_is_elsewhere(ground, &x, planes, distance, hope, ceiling)
        {
            scratch.expected = hope * ceiling;
            break;
        }
        let rows = scratch.build_program(ground, &x, radius, planes);
        let hope = options.hope.after(iteration, start.planes.is_some(), planes.is_some());
        let has_looked = iteration > 0 || planes.is_some();
        // Where it overlaps, a model may have no solution, which is not to be taken for a far one.
        let may_end = has_looked && violation <= 0.0 && scratch.quadratic.rows.is_empty();
        let most = if may_end { 0.5 * ((hope * ceiling).powi(2) - distance * distance) } else { f64::INFINITY };
        let outcome = scratch.qp.solve(&scratch.quadratic.hessian, &scratch.quadratic.gradient, most);
        if outcome == QpOutcome::Above {
            if let Some(shorter) = scratch.unlearn() {
                radius = shorter;
                continue;
            }
            scratch.expected = hope * ceiling;
            is_given_up = true;
            break;
        }
        if outcome == QpOutcome::Solved {
            penalty = penalty.max(2.0 * scratch.qp.multiplier_sum(rows));
        } else {
            penalty = penalty.max(4.0 * distance * distance / ground.clearance.max(1e-3));
        }
        scratch.clip_step();
        let length = scratch.quadratic.step_length(&scratch.step);
        let at_rim = scratch.step_at_rim(radius);
        scratch.expected = distance;
        if outcome == QpOutcome::Solved {
            scratch.expected = scratch.quadratic.expected_distance(distance, &scratch.qp.step);
        }
        // At the rim of the trust region, a model with rows of its own has not said yet how far it may lead.
        if outcome == QpOutcome::Solved && (!at_rim || scratch.quadratic.rows.is_empty()) {
            let is_alike = planes.is_none() && options.hope.is_alike(scratch.expected, ceiling);
            is_given_up = has_looked && scratch.expected > hope * ceiling;
            let mut is_known = || is_alike || scratch.ends_as_another(ground, &x, options.hope, ceiling);
            let is_lost = is_given_up || (has_looked && is_known());
            if is_lost || (violation <= 0.0 && scratch.expected > (1.0 - options.tolerance) * distance) {
                if let Some(shorter) = scratch.unlearn() {
                    radius = shorter;
                    continue;
                }
                break;
            }
        }
        if length <= options.tolerance * distance.max(1e-6 * ground.scale) && violation <= 0.0 {
            break;
        }
        scene.space.integrate(&x, &scratch.step, &mut trial);
        let trial_distance = scratch.distance(ground, anchor, &trial);
        std::mem::swap(&mut scratch.contacts, &mut scratch.other_contacts);
        let mut trial_violation = scratch.contacts_at(ground, &trial, within(margin));
        let improves = trial_violation <= sure && found.is_none_or(|depth| trial_distance < depth);
        if improves && !complete && scratch.label(ground, &trial) == Label::Colliding {
            // Contacts propose, the exact check decides: a body inside another has no near contact.
            trial_violation = ground.clearance.max(SLACK);
        } else if improves {
            best.clear();
            best.extend_from_slice(&trial);
            found = Some(trial_distance);
        }
        let merit = |d: f64, v: f64| 0.5 * d * d + penalty * v.max(0.0);
        let is_partial = margin < widest || planes.is_some();
        let gain = merit(distance, violation) - merit(trial_distance, trial_violation);
        if gain > 0.0 {
            std::mem::swap(&mut x, &mut trial);
            scratch.copy_poses();
            planes = None;
            scratch.lesson = None;
            let relative = (distance - trial_distance).abs() / distance.max(1e-300);
            let done = relative < options.tolerance && violation <= 0.0 && trial_violation <= 0.0;
            distance = trial_distance;
            violation = trial_violation;
            margin = (length * ground.metric.lever()).clamp(LEAST_MARGIN, widest);
            if at_rim {
                radius *= 2.0;
            }
            retried = false;
            if done {
                break;
            }
        } else {
            std::mem::swap(&mut scratch.contacts, &mut scratch.other_contacts);
            scratch.hit_poses.clear();
            scratch.hit_poses.extend_from_slice(scratch.check.poses());
            if is_partial {
                margin = widest;
                scratch.contacts_at(ground, &x, within(margin));
                scratch.copy_poses();
                planes = None;
            }
            // Flat on a face, contacts do not tell of all corners and the step turns another one into the face: once that is known, a
            // step as long may do.
            let known_before = scratch.contacts.len();
            let learned = scratch.learn_from(ground);
            let shorter = 0.35 * length.min(radius);
            scratch.lesson = (learned && may_unlearn).then_some(Lesson { known_before, shorter });
            if !learned || retried {
                radius = shorter;
            }
            retried = true;
            if radius < options.tolerance * distance {
                break;
            }
        }
    }
    if options.hope.is_in_turn() && scratch.checks > checks_before && !is_given_up {
        scratch.ends.extend_from_slice(&x);
    }
    scratch.x = x;
    scratch.trial = trial;
    found
}

impl RefineScratch {
    /// Gathers the contacts at `q`; returns by how much \[m\] the worst misses the clearance (negative: by how much it keeps it).
    fn contacts_at(&mut self, ground: &Ground, q: &[f64], query: ContactQuery) -> f64 {
        self.checks += 1;
        self.contacts.clear();
        self.looked_at.clear();
        if query.search == ContactSearch::Exact {
            self.looked_at.extend_from_slice(q);
            self.looked_within = ground.checker.exact_within(query.margin);
        }
        ground.checker.contacts(q, query, &mut self.check, &mut self.contacts);
        let least = self.contacts.iter().map(|c| c.distance).fold(query.margin, f64::min);
        ground.clearance - least
    }

    /// Notes the poses of the configuration whose contacts were looked at last.
    fn copy_poses(&mut self) {
        self.poses.clear();
        self.poses.extend_from_slice(self.check.poses());
    }
}

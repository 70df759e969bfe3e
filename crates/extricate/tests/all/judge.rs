//! Judges each claim of an answer by itself: by another library's distances, by a checker that has
//! seen nothing else, and by the metric. It takes nothing from the query but its answers.

use std::sync::Arc;

use extricate::geometry::{Geometry, Pose};
use extricate::internals::kinematics::forward;
use extricate::internals::math::Vec3;
use extricate::internals::metric::Metric;
use extricate::internals::query::answer::{RIVAL, TOUCHING};
use extricate::internals::scene::Part;
use extricate::{
    Answer, CheckScratch, Checker, Config, Effort, Exit, Label, Manifold, MetricKind, PairId, QueryOptions, Scene,
    SegmentOptions, SegmentOutcome, StraightSegment,
};

use crate::recheck::{Recheck, SLACK};

/// Checks beyond a budget that end a query, apart from those of exits and of the segment.
const ENDING_CHECKS: usize = 3;
/// Excess over the clearance \[m\] at which a collision of the segment still counts: ten times the
/// resolution of segments.
const SEGMENT_SLACK_M: f64 = 1e-3;
/// Slack of contacts \[m\]: their search ends beside the nearest points of round shapes.
const CONTACT_SLACK_M: f64 = 1e-5;
/// Step of difference quotients, as a share of the depth.
const STEP_SHARE: f64 = 3e-4;
/// Least step \[rad or m\], over which gradients of the largest displacement are a mean.
const MIN_STEP: f64 = 2e-5;
/// Slack of the gradient against slopes over such steps, relative to one or the slope.
const SLOPE_SLACK: f64 = 2e-3;

/// Reference data that answers about one scene are judged by.
pub struct Judge<'a> {
    scene: &'a Scene,
    metric: Metric,
    recheck: Recheck<'a>,
    checker: Checker,
    /// Whether another scene than this one was learned.
    changed: bool,
}

/// Judges answers one after the other, with memory of its own.
pub struct Hearing<'a> {
    judge: &'a Judge<'a>,
    check: CheckScratch,
    faults: Vec<String>,
}

impl<'a> Judge<'a> {
    /// Makes a judge of answers about `scene`; `changed` says that another scene was learned.
    pub fn new(scene: &'a Scene, changed: bool) -> Self {
        let shared = Arc::new(scene.clone());
        Self {
            scene,
            metric: Metric::new(shared.clone()),
            recheck: Recheck::new(scene),
            checker: Checker::new(shared),
            changed,
        }
    }

    /// Makes a hearing, for use on one thread.
    pub fn hearing(&'a self) -> Hearing<'a> {
        Hearing { judge: self, check: CheckScratch::default(), faults: Vec::new() }
    }
}

impl Hearing<'_> {
    /// Returns whether the checker of the judge calls `q` free.
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        self.judge.checker.label(q, &mut self.check) == Label::Free
    }

    /// Returns the faults of `answer` to `q` under `options`, which is a frame if `streamed`.
    pub fn faults(&mut self, q: &Config, options: &QueryOptions, answer: &Answer, streamed: bool) -> Vec<String> {
        self.expect("the effort is another", answer.effort == options.effort);
        self.expect("free or not, two parts disagree", (answer.depth == 0.0) == answer.colliding.is_empty());
        if answer.depth == 0.0 {
            self.free(q, answer);
        } else {
            self.colliding(q, options, answer);
            self.witness(q, options, answer);
            self.gradient(q, answer);
            self.displacement(q, answer);
            self.exits(q, if streamed { 1 } else { options.exits }, answer);
            self.expect(
                "the segment is told or not, against what was asked",
                answer.segment.is_some() == options.segment,
            );
            answer.segment.iter().for_each(|segment| self.segment(q, segment, answer));
            // In a changed scene the search for a first witness overdraws the budget.
            let most = options.termination.max_checks.filter(|_| !self.judge.changed);
            let to_end = ENDING_CHECKS + answer.exits.len() + usize::from(options.segment);
            let most = most.map_or(usize::MAX, |checks| checks.max(1) + to_end);
            self.expect("the budget is overdrawn", answer.checks <= most);
        }
        std::mem::take(&mut self.faults)
    }

    fn expect(&mut self, what: &str, holds: bool) {
        if !holds {
            self.faults.push(what.into());
        }
    }

    fn free(&mut self, q: &Config, answer: &Answer) {
        let agrees = self.judge.recheck.agrees_free(q) && self.is_free(q);
        self.expect("called free, but collides", agrees);
        let is_plain = answer.witness == *q
            && answer.lower_bound == 0.0
            && answer.max_displacement == 0.0
            && answer.gradient.iter().all(|slope| *slope == 0.0)
            && answer.gradient.len() == self.judge.scene.space().nv()
            && answer.touching.is_empty()
            && answer.contacts.is_empty()
            && answer.exits.is_empty()
            && answer.segment.is_none()
            && answer.verified
            && answer.unique;
        self.expect("free, but more is told than that", is_plain);
    }

    /// Judges the colliding pairs: those that are reported collide, and no others do if all are
    /// reported.
    fn colliding(&mut self, q: &Config, options: &QueryOptions, answer: &Answer) {
        let collides = !self.is_free(q);
        self.expect("called colliding, but is free", collides);
        let told = &answer.colliding;
        self.expect("colliding pairs are out of order or told twice", told.is_sorted_by(|a, b| a < b));
        let are_all = options.contacts || options.effort != Effort::Nearest;
        self.expect("more than one colliding pair without contacts", are_all || told.len() <= 1);
        let clearance = self.judge.scene.clearance();
        for (pair, distance) in self.judge.recheck.distances(q, clearance + 2.0 * SLACK).into_iter().enumerate() {
            if told.contains(&PairId::new(pair)) {
                let near = distance <= clearance + SLACK || self.judge.recheck.has_mesh(pair);
                self.expect("a pair is called colliding that keeps the clearance", near);
            } else {
                self.expect("a pair that collides is left out", !are_all || distance >= clearance - SLACK);
            }
        }
    }

    /// Judges where the witness is, and what touches there.
    fn witness(&mut self, q: &Config, options: &QueryOptions, answer: &Answer) {
        self.free_at_depth("the witness", q, answer.depth, &answer.witness);
        self.expect("the lower bound is above the depth", (0.0..=answer.depth).contains(&answer.lower_bound));
        let verifies = options.effort != Effort::Nearest || self.judge.changed;
        self.expect("verified or not, against what the effort promises", answer.verified == verifies);
        if !options.contacts && options.effort == Effort::Nearest {
            return self.expect("contacts that nobody asked for", answer.touching.is_empty());
        }
        self.touching("the witness", &answer.witness, &answer.touching);
        let mut pairs: Vec<PairId> = answer.contacts.iter().map(|contact| contact.pair).collect();
        pairs.dedup();
        self.expect("contacts and touching pairs disagree", pairs == answer.touching);
        let far = self.judge.scene.clearance() + TOUCHING + 2.0 * CONTACT_SLACK_M;
        let distances = self.judge.recheck.distances(&answer.witness, far);
        for (pair, distance) in distances.iter().enumerate() {
            let nearest =
                answer.contacts.iter().filter(|contact| contact.pair.index() == pair).map(|contact| contact.distance);
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let is_it = nearest == f64::INFINITY || (nearest - distance).abs() <= CONTACT_SLACK_M;
            self.expect("the nearest contact is not at the distance of its pair", is_it);
        }
        for contact in &answer.contacts {
            self.expect("a normal that is not of unit length", (contact.normal.norm() - 1.0).abs() < 1e-9);
            let along = (contact.point_first - contact.point_second).dot(&contact.normal);
            self.expect("points of a contact are not at its distance", (along - contact.distance).abs() < 1e-9);
        }
    }

    /// Judges a configuration that is said to be free at this distance from the query.
    fn free_at_depth(&mut self, whose: &str, q: &Config, depth: f64, witness: &[f64]) {
        let agrees = self.judge.recheck.agrees_free(witness) && self.is_free(witness);
        self.expect(&format!("{whose} collides"), agrees);
        let limited = self.judge.scene.space().config(witness);
        let keeps = limited.is_ok_and(|w| w.iter().zip(witness).all(|(a, b)| (a - b).abs() < 1e-9));
        self.expect(&format!("{whose} is out of limits"), keeps);
        let distance = self.judge.metric.distance(q, witness);
        self.expect(&format!("{whose} is not at the depth"), (distance - depth).abs() <= 1e-9 + 1e-6 * distance);
    }

    /// Judges the touching pairs: those that are reported touch, and no others do.
    fn touching(&mut self, whose: &str, witness: &[f64], told: &[PairId]) {
        self.expect("touching pairs are out of order or told twice", told.is_sorted_by(|a, b| a < b));
        let margin = self.judge.scene.clearance() + TOUCHING;
        for (pair, distance) in
            self.judge.recheck.distances(witness, margin + 2.0 * CONTACT_SLACK_M).into_iter().enumerate()
        {
            let (touches, parted) = (distance <= margin - CONTACT_SLACK_M, distance >= margin + CONTACT_SLACK_M);
            let holds = if told.contains(&PairId::new(pair)) { !parted } else { !touches };
            self.expect(&format!("at {whose} a pair touches that is not told, or the other way round"), holds);
        }
    }

    /// Judges the gradient: the slope along each coordinate lies between those of short steps to
    /// both sides. Under the joint metric the steepest slope is 1.
    fn gradient(&mut self, q: &Config, answer: &Answer) {
        let space = self.judge.scene.space();
        self.expect("the gradient is of another length than tangents", answer.gradient.len() == space.nv());
        // Kinks beside an exit of the largest displacement are nearer than any step that rounding
        // allows.
        if answer.depth < 1e-4
            || answer.gradient.len() != space.nv()
            || self.judge.scene.metric() == MetricKind::MaxDisplacement
        {
            return;
        }
        let h = f64::max(STEP_SHARE * answer.depth, MIN_STEP);
        let (mut step, mut moved, mut steepest) = (vec![0.0; space.nv()], vec![0.0; space.nq()], 0.0);
        let mut off = false;
        for factor in space.factors() {
            let is_at_limit = matches!(factor.manifold, Manifold::Interval { lower, upper }
                if q[factor.q] - h < lower || q[factor.q] + h > upper);
            for k in factor.v..factor.v + if factor.manifold == Manifold::Rotation { 3 } else { 1 } {
                steepest += answer.gradient[k].powi(2) / factor.weight;
                if is_at_limit {
                    continue;
                }
                let slopes = [h, -h].map(|h| {
                    step[k] = h;
                    space.integrate(q, &step, &mut moved);
                    step[k] = 0.0;
                    (self.judge.metric.distance(&moved, &answer.witness) - answer.depth) / h
                });
                let [least, most] = [f64::min, f64::max].map(|of| of(slopes[0], slopes[1]));
                let slack = SLOPE_SLACK * (1.0 + most.abs());
                // A depth no longer than a few steps bends over them, so it is left out.
                off |= h < 1e-2 * answer.depth && !(least - slack..=most + slack).contains(&answer.gradient[k]);
            }
        }
        self.expect("the gradient is not the slope of the distance", !off);
        let is_unit = self.judge.scene.metric() != MetricKind::Joint || (steepest.sqrt() - 1.0).abs() < 1e-6;
        self.expect("the gradient is not of unit length", is_unit);
    }

    /// Judges the largest displacement: it lies between that of points of the bodies and that of
    /// points around them.
    fn displacement(&mut self, q: &Config, answer: &Answer) {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        forward(self.judge.scene, q, &mut from);
        forward(self.judge.scene, &answer.witness, &mut to);
        let (mut least, mut most) = (0.0, 0.0);
        for body in self.judge.scene.bodies().iter().filter(|body| body.frame != 0) {
            for part in &body.parts {
                let (inside, around) = points(part);
                let far = |points: &[Vec3]| {
                    let moved = |point: &Vec3| {
                        let at = |poses: &[Pose]| poses[body.frame].then(&part.pose_frame_part).point(point);
                        (at(&from) - at(&to)).norm()
                    };
                    points.iter().map(moved).fold(0.0, f64::max)
                };
                least = f64::max(least, far(&inside));
                // A displacement is convex in the point, so the corners of a hull bound it.
                most = f64::max(most, far(&around));
            }
        }
        let told = answer.max_displacement;
        self.expect("a point moves farther than is told", told >= least - 1e-9);
        self.expect("no point moves as far as is told", told <= most + 1e-9);
        let is_depth = self.judge.scene.metric() != MetricKind::MaxDisplacement || (told - answer.depth).abs() < 1e-6;
        self.expect("the depth is not the largest displacement", is_depth);
    }

    fn exits(&mut self, q: &Config, wanted: usize, answer: &Answer) {
        let exits = &answer.exits;
        if wanted <= 1 {
            return self.expect("exits that nobody asked for", exits.is_empty());
        }
        self.expect("more exits than were asked for, or none", (1..=wanted).contains(&exits.len()));
        self.expect("exits are not in order of depth", exits.is_sorted_by(|a, b| a.depth <= b.depth));
        let first = exits.first().map(|exit| (exit.depth, &exit.witness, &exit.touching));
        let begins = first == Some((answer.depth, &answer.witness, &answer.touching));
        self.expect("the first exit is not the witness", begins);
        for (i, exit) in exits.iter().enumerate() {
            self.free_at_depth("an exit", q, exit.depth, &exit.witness);
            self.touching("an exit", &exit.witness, &exit.touching);
            // Exits are distinct by the metric's tensor at the query. The metric itself deviates
            // from it on the way, but by much less than this.
            let apart = |other: &Exit| self.judge.metric.distance(&exit.witness, &other.witness) > 0.01 * other.depth;
            let are_apart = exits[..i].iter().all(apart);
            self.expect("two exits are one", are_apart);
        }
        let rivals = exits.iter().skip(1).any(|exit| exit.depth <= RIVAL * answer.depth);
        self.expect("unique, against what the exits say", answer.unique != rivals);
    }

    /// Judges that the stretch proved free is free, and that something is near its last collision.
    fn segment(&mut self, q: &Config, segment: &StraightSegment, answer: &Answer) {
        let StraightSegment { colliding_until, free_from, .. } = *segment;
        let in_order = 0.0 <= colliding_until && colliding_until <= free_from && free_from <= 1.0;
        self.expect("the parts of the segment are out of order", in_order);
        let space = self.judge.scene.space();
        let at = |t: f64| {
            let mut config = q.to_vec();
            space.interpolate(q, &answer.witness, t, &mut config);
            config
        };
        let (beginning, near) = (at(free_from), at(colliding_until));
        let stretch = (0..10).map(|k| at(free_from + (1.0 - free_from) * f64::from(k) / 10.0));
        let is_free = stretch.into_iter().all(|config| self.judge.recheck.agrees_free(&config));
        self.expect("the segment collides where it is proved free", is_free);
        if free_from < 1.0 {
            let proof =
                self.judge.checker.segment(&answer.witness, &beginning, &SegmentOptions::default(), &mut self.check);
            // Cut elsewhere, a proof may stop where two bodies come near, but it must not meet a
            // collision.
            let holds = !matches!(proof, SegmentOutcome::Contact { .. });
            self.expect(&format!("the segment is not free by another proof ({proof:?})"), holds);
        }
        let margin = self.judge.scene.clearance() + SEGMENT_SLACK_M;
        let distances = self.judge.recheck.distances(&near, margin + SLACK);
        let meets = !self.is_free(&near) || distances.iter().any(|distance| *distance <= margin);
        self.expect("nothing is near where the segment was last seen to collide", meets);
    }
}

/// Returns points of a part, and points whose hull contains it, in its own coordinates \[m\].
fn points(part: &Part) -> (Vec<Vec3>, Vec<Vec3>) {
    let corners = |h: Vec3| {
        let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
        (0..8).map(|k| Vec3::new(sign(k & 1) * h.x, sign(k & 2) * h.y, sign(k & 4) * h.z)).collect::<Vec<_>>()
    };
    let ends = |half: f64| vec![Vec3::new(0.0, 0.0, half), Vec3::new(0.0, 0.0, -half)];
    match &part.geometry {
        Geometry::Sphere { radius } => (vec![Vec3::zeros()], corners(Vec3::repeat(*radius))),
        Geometry::Box { half_extents } => (corners((*half_extents).into()), corners((*half_extents).into())),
        Geometry::Cylinder { radius, half_length } => {
            (ends(*half_length), corners(Vec3::new(*radius, *radius, *half_length)))
        }
        Geometry::Capsule { radius, half_length } => {
            (ends(half_length + radius), corners(Vec3::new(*radius, *radius, half_length + radius)))
        }
        Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => (mesh.vertices.clone(), mesh.vertices.clone()),
        _ => panic!("no judged scene has scenery"),
    }
}

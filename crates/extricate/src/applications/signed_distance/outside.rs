//! The nearest configuration in contact, from a free one.
//!
//! 1. *Candidates*: points of each pair that may meet first, its nearest ones and those that
//!    leverage brings together sooner, ascending by the length of the linear step that does.
//! 2. *Approach*: bring one pair to its clearance with as little motion as possible, by sequential
//!    quadratic programming from the end of that step. Meshes are approached by the pieces around
//!    them, then themselves.
//! 3. *Elsewhere*: draw configurations at the distance found. From one that collides, approach what
//!    collides first on the way there; from some free ones, one candidate's pair after another. The
//!    search ends when many in succession find nothing nearer.
//! 4. *Verify*: just beyond the witness, something collides by the exact checker.
//! 5. *Bound*: for each pair, a radius within which it is proved to keep its clearance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::distance::SignedDistance;
use crate::collision::{Contact, ContactQuery, ContactSearch, signed_distances_of};
use crate::cspace::{Config, Label};
use crate::kinematics::Twists;
use crate::math::{Pose, Vec3};
use crate::metric::Anchor;
use crate::query::Deadline;
use crate::query::context::Context;
use crate::query::descent::subproblem::Subproblem;
use crate::query::evaluate::Evaluator;
use crate::query::local_metric::LocalMetric;
use crate::query::report::free_radius::{Keeps, PLAY_M, free_radius};
use crate::query::report::gradient;
use crate::query::{QpOutcome, QueryScratch, Termination};
use crate::robot::Geometry;
use crate::scene::PairId;

/// Contacts of meshes are searched this far \[m\].
const FAR_M: f64 = 1e6;
/// An approach aims at this much less than the clearance \[m\], so that its end collides.
const SLACK_M: f64 = 1e-7;
/// Most steps of an approach.
const MAX_STEPS: usize = 30;
/// An approach ends if a step changes the distance by less than this share. With 1e-3 it stops
/// short: of 180 configurations (planar-arm and hand, all metrics), 10 miss instead of 1.
const TOLERANCE_SHARE: f64 = 1e-6;
/// Contacts nearer by less than this share are no reason to draw on.
const GAIN_SHARE: f64 = 1e-3;
/// Trust region of an approach that begins near its end, as a share of the distance.
const POLISH_SHARE: f64 = 0.05;
/// Pieces stand out of meshes, so an approach to meshes goes on from the end of that to their
/// pieces up to this multiple of the nearest.
const PIECES_FACTOR: f64 = 1.03;
/// Draws in succession without anything nearer, for each degree of freedom, that end the search.
const IDLE_PER_DOF: usize = 5;
/// Share of the free draws from which an approach begins. With 0, 4 of 180 distances in the joint
/// metric were missed by 5 %, with 1 none, but at up to three times the cost.
const FREE_START_SHARE: f64 = 1.0 / 3.0;
/// The trust region shrinks to this share of a rejected step; the approach ends at the second share
/// of the distance.
const REJECTED_STEP_SHARE: f64 = 0.35;
const STUCK_STEP_SHARE: f64 = 1e-4;
/// Most cuts of an approach. Distances to convex shapes are no less than any of their linear
/// models, so steps that satisfy several do not turn back and forth between two faces.
const MAX_CUTS: usize = 4;
/// Halvings that find the first collision on the way to a configuration.
const HALVINGS: usize = 12;
/// Shares by which a witness is moved back from the end of an approach until it is free.
const BACK_SHARES: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];

/// Returns the signed distance of a free configuration.
pub fn nearest_contact(
    context: &Context,
    q: &Config,
    within: f64,
    termination: &Termination,
    scratch: &mut QueryScratch,
) -> SignedDistance {
    scratch.evaluator.begin(Deadline::of(termination));
    let mut anchor = Anchor::default();
    context.metric.anchor(q, &mut anchor);
    let mut search = Outside {
        context,
        q,
        within,
        anchor: &anchor,
        evaluator: &mut scratch.evaluator,
        subproblem: Subproblem::default(),
        local: LocalMetric::default(),
        twists: Twists::default(),
        contacts: Vec::new(),
        best: None,
    };
    search.subproblem.slack = SLACK_M;
    search.local.set(context, &anchor);
    let mut proved = |search: &mut Outside, ceiling: f64| {
        free_radius(context, q, (Keeps::Clearance, ceiling), search.evaluator, &mut scratch.report.motion)
    };
    let mut bound = if within.is_finite() { proved(&mut search, within) } else { 0.0 };
    let mut found = None;
    if bound < within {
        let candidates = search.candidates();
        search.approach_candidates(&candidates);
        search.look_elsewhere(&candidates);
        found = search.verified().filter(|found| found.distance <= within);
        let ceiling = found.as_ref().map_or(context.scale, |found| found.distance).min(within);
        bound = proved(&mut search, ceiling);
    }
    let (checks, cut_short) = (search.evaluator.checks, search.evaluator.is_cut());
    let mut slopes = vec![0.0; context.checker.scene().space.nv()];
    let Some(Found { distance, config, pair }) = found else {
        let (distance, witness, pairs) = (f64::INFINITY, None, Vec::new());
        return SignedDistance { distance, bound, witness, gradient: slopes, pairs, checks, cut_short };
    };
    if distance > 0.0 {
        context.metric.anchor(&config, &mut scratch.report.far_anchor);
        gradient(context, &anchor, &mut scratch.report, &mut scratch.evaluator.metric, (distance, &mut slopes));
    }
    SignedDistance {
        distance,
        bound: bound.min(distance),
        witness: Some(Config::trusted(&config)),
        gradient: slopes,
        pairs: vec![pair],
        checks,
        cut_short,
    }
}

struct Outside<'a> {
    context: &'a Context<'a>,
    q: &'a [f64],
    /// Distance beyond which nothing matters.
    within: f64,
    anchor: &'a Anchor,
    evaluator: &'a mut Evaluator,
    local: LocalMetric,
    twists: Twists,
    subproblem: Subproblem,
    contacts: Vec<Contact>,
    /// The nearest colliding configuration so far.
    best: Option<Found>,
}

/// A configuration in contact.
#[derive(Clone)]
struct Found {
    distance: f64,
    config: Vec<f64>,
    pair: PairId,
}

/// Points of a pair that may meet first, and the length of the linear step that brings them
/// together along the normal.
struct Candidate {
    estimate: f64,
    contact: Contact,
}

/// A configuration on the way of an approach, with the contact of its pair.
struct Place {
    config: Vec<f64>,
    distance: f64,
    contact: Contact,
    /// Gradient of the contact's distance in tangent coordinates.
    row: Vec<f64>,
    poses: Vec<Pose>,
    /// Distance \[m\] that is missing until the pair surely collides: half of what an approach aims
    /// at, so that rounding does not matter.
    missing: f64,
}

/// A linear model of the distance \[m\] of a pair: its value at the present place, and its
/// gradient.
struct Cut {
    value: f64,
    row: Vec<f64>,
}

/// Returns the contact of a corner of a body with the plane through the other point of a contact.
fn at_corner(mut contact: Contact, is_first: bool, corner: Vec3) -> Contact {
    let (own, sign) = if is_first { (&mut contact.point_first, 1.0) } else { (&mut contact.point_second, -1.0) };
    let farther = sign * contact.normal.dot(&(corner - *own));
    *own = corner;
    contact.distance += farther.max(0.0);
    contact
}

impl Outside<'_> {
    fn least(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |best| best.distance)
    }

    fn limit(&self) -> f64 {
        self.least().min(self.within).min(self.context.scale)
    }

    /// Approaches the candidates, the most promising first.
    fn approach_candidates(&mut self, candidates: &[Candidate]) {
        for &Candidate { estimate, contact } in candidates {
            if self.evaluator.is_spent() || estimate >= self.limit() {
                break;
            }
            let (config, poses) = (self.q.to_vec(), self.anchor.poses.clone());
            let row = self.gradient(&contact, &poses);
            let place = Place { config, distance: 0.0, contact, row, poses, missing: contact.distance };
            if self.step(&place, &[], self.context.scale).is_some() {
                let mut start = self.q.to_vec();
                self.context.checker.scene().space.integrate(self.q, &self.subproblem.step, &mut start);
                self.approach(&start, contact.pair, 0.5 * estimate);
            }
        }
    }

    /// Returns points of pairs that may meet, ascending by estimate: the nearest ones, and corners
    /// of boxes around shapes.
    fn candidates(&mut self) -> Vec<Candidate> {
        let scene = self.context.checker.scene();
        let (mut twists, mut row) = (Twists::default(), vec![0.0; scene.space.nv()]);
        twists.set(scene, &self.anchor.poses);
        let mut all = Vec::new();
        let checks = self.evaluator.checks;
        for (index, bodies) in scene.pairs.iter().enumerate() {
            let pair = PairId::new(index);
            self.contact(self.q, pair, self.search_of(pair));
            let Self { context, local, anchor, contacts, .. } = self;
            let mut candidate = |contact: Contact| {
                row.fill(0.0);
                contact.add_gradient(scene, &twists, &mut row);
                row.iter_mut().enumerate().filter(|(v, _)| context.is_locked(*v)).for_each(|(_, slope)| *slope = 0.0);
                let estimate = (contact.distance - context.clearance).max(0.0) / local.slope(&mut row).max(1e-12);
                Candidate { estimate, contact }
            };
            for contact in contacts.iter().copied() {
                let mut best = candidate(contact);
                let nearest = best.estimate;
                for (is_first, body) in [(true, bodies.first), (false, bodies.second)] {
                    if scene.bodies[body].frame != 0 {
                        context.checker.corners_of(body, &anchor.poses, &mut |corner| {
                            let corner = candidate(at_corner(contact, is_first, corner));
                            if corner.estimate < best.estimate {
                                best = corner;
                            }
                        });
                    }
                }
                if best.estimate < nearest {
                    all.push(best);
                }
                all.push(candidate(contact));
            }
        }
        // All of them are contacts of one configuration.
        self.evaluator.checks = checks + 1;
        all.sort_by(|a, b| a.estimate.total_cmp(&b.estimate).then(a.contact.pair.cmp(&b.contact.pair)));
        all
    }

    /// Approaches what collides at the distance found, until many draws in succession lead to
    /// nothing nearer.
    fn look_elsewhere(&mut self, candidates: &[Candidate]) {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let (mut step, mut drawn) = (vec![0.0; self.context.checker.scene().space.nv()], self.q.to_vec());
        let (most, mut idle, mut next) = (IDLE_PER_DOF * step.len(), 0, 0);
        while idle < most && !self.evaluator.is_spent() {
            let (before, reach) = (self.least(), self.limit());
            self.draw(&mut rng, reach, &mut step, &mut drawn);
            if self.evaluator.label(self.context, &drawn) == Label::Free {
                let near = candidates.partition_point(|candidate| candidate.estimate < reach);
                if near > 0 && rng.random_bool(FREE_START_SHARE) {
                    self.approach(&drawn, candidates[next % near].contact.pair, 0.5 * reach);
                    next += 1;
                }
            } else if let Some((first, pair)) = self.first_collision(&drawn) {
                let distance = self.evaluator.distance(self.context, self.anchor, &first);
                self.offer(Found { distance, config: first.clone(), pair });
                self.approach(&first, pair, 0.5 * distance);
            }
            idle = if self.least() < (1.0 - GAIN_SHARE) * before { 0 } else { idle + 1 };
        }
    }

    /// Draws a configuration `reach` (metric units) away, in a direction that is uniform in the
    /// metric here.
    fn draw(&mut self, rng: &mut ChaCha8Rng, reach: f64, step: &mut [f64], out: &mut [f64]) {
        let space = &self.context.checker.scene().space;
        // The sum of twelve uniform numbers is nearly normal.
        step.iter_mut().for_each(|x| *x = (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0);
        self.local.spread(step);
        (0..step.len()).filter(|v| self.context.is_locked(*v)).for_each(|v| step[v] = 0.0);
        let length = self.local.length(step).max(1e-12);
        step.iter_mut().for_each(|x| *x *= reach / length);
        // Lengths in the metric need not be proportional to the step.
        for _ in 0..2 {
            space.integrate(self.q, step, out);
            let length = self.evaluator.distance(self.context, self.anchor, out).max(0.1 * reach);
            step.iter_mut().for_each(|x| *x *= reach / length);
        }
        space.integrate(self.q, step, out);
        space.clamp(out);
    }

    /// Returns about the first colliding configuration on the way to a colliding one, and a pair
    /// that collides there.
    fn first_collision(&mut self, end: &[f64]) -> Option<(Vec<f64>, PairId)> {
        let space = &self.context.checker.scene().space;
        let (mut free, mut hit, mut middle) = (0.0, 1.0, end.to_vec());
        let mut at = end.to_vec();
        for _ in 0..HALVINGS {
            let share = 0.5 * (free + hit);
            space.interpolate(self.q, end, share, &mut middle);
            if self.evaluator.label(self.context, &middle) == Label::Free {
                free = share;
            } else {
                hit = share;
                at.copy_from_slice(&middle);
            }
        }
        self.evaluator.checks += 1;
        let pair = self.context.checker.colliding_pair(&at, &mut self.evaluator.check)?;
        Some((at, pair))
    }

    fn offer(&mut self, found: Found) {
        if found.distance < self.least() {
            self.best = Some(found);
        }
    }

    /// Offers a place in contact, unless its contact is that of pieces.
    fn offer_place(&mut self, place: &Place, search: ContactSearch) {
        if place.missing <= 0.0 && search == ContactSearch::Exact {
            let (distance, config, pair) = (place.distance, place.config.clone(), place.contact.pair);
            self.offer(Found { distance, config, pair });
        }
    }

    /// How contacts of a pair are searched for on the way to it. Distances of meshes take long if
    /// they are far apart.
    fn search_of(&self, pair: PairId) -> ContactSearch {
        let scene = self.context.checker.scene();
        let pair = &scene.pairs[pair.index()];
        let is_any = |is: fn(&Geometry) -> bool| {
            [pair.first, pair.second].iter().any(|body| scene.bodies[*body].parts.iter().any(|part| is(&part.geometry)))
        };
        let is_slow = is_any(|geometry| matches!(geometry, Geometry::Mesh(_))) && !is_any(Geometry::is_scenery);
        if is_slow { ContactSearch::Pieces } else { ContactSearch::Exact }
    }

    /// Returns the nearest contact of a pair, however far.
    fn contact(&mut self, config: &[f64], pair: PairId, search: ContactSearch) -> Option<Contact> {
        let Self { context, evaluator, contacts, .. } = self;
        contacts.clear();
        evaluator.checks += 1;
        let mut margin = FAR_M;
        if search == ContactSearch::Exact {
            // The distance alone is found sooner than contacts within a wide margin.
            let distance = signed_distances_of(context.checker, config, &[pair], &mut evaluator.check)[0];
            margin = (distance - context.checker.excess(pair.index())).max(context.clearance) + PLAY_M;
        }
        let query = ContactQuery { margin, search };
        context.checker.contacts_of(config, pair, query, &mut evaluator.check, contacts);
        contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).copied()
    }

    /// Returns the configuration with the nearest contact of a pair; `None` if the pair has none.
    fn place(&mut self, config: Vec<f64>, pair: PairId, search: ContactSearch) -> Option<Place> {
        let contact = self.contact(&config, pair, search)?;
        let poses = self.evaluator.check.poses().to_vec();
        let row = self.gradient(&contact, &poses);
        let distance = self.evaluator.distance(self.context, self.anchor, &config);
        let missing = contact.distance - self.context.clearance + 0.5 * SLACK_M;
        Some(Place { config, distance, contact, row, poses, missing })
    }

    /// Returns the gradient of a contact's distance in tangent coordinates.
    fn gradient(&mut self, contact: &Contact, poses: &[Pose]) -> Vec<f64> {
        let scene = self.context.checker.scene();
        let mut row = vec![0.0; scene.space.nv()];
        self.twists.set(scene, poses);
        contact.add_gradient(scene, &self.twists, &mut row);
        row
    }

    /// Solves for the step that closes the contact of a place, by all cuts that hold there, and
    /// ends as near as possible, within a trust region; returns its length. Returns `None` if there
    /// is no step.
    fn step(&mut self, place: &Place, cuts: &[Cut], radius: f64) -> Option<f64> {
        let Self { context, subproblem, anchor, .. } = self;
        context.metric.quadratic_model(anchor, &place.config, &place.poses, &mut subproblem.quadratic);
        let distance = place.contact.distance;
        // Where another corner comes nearer, the distance is less than its models.
        let holding = cuts.iter().filter(|cut| cut.value < distance).map(|cut| (cut.value, &cut.row[..]));
        let rows = [(distance, &place.row[..])].into_iter().chain(holding);
        subproblem.build_closing(context, &place.config, radius, rows);
        match subproblem.solve(f64::INFINITY) {
            QpOutcome::Infeasible => None,
            _ => Some(subproblem.clip_step()),
        }
    }

    /// Brings a pair to its clearance with as little motion from the configuration as possible,
    /// beginning at `start` with a trust region of `radius` (metric units), and offers the end.
    fn approach(&mut self, start: &[f64], pair: PairId, radius: f64) {
        let search = self.search_of(pair);
        let Some(end) = self.approached(start, (pair, search), radius) else { return };
        if search == ContactSearch::Pieces && end.distance < PIECES_FACTOR * self.least() {
            self.approached(&end.config, (pair, ContactSearch::Exact), POLISH_SHARE * end.distance);
        }
    }

    /// Approaches as [`Outside::approach`] does, with one kind of contacts; only exact ones are
    /// offered. Returns the end, unless the approach is given up.
    fn approached(&mut self, start: &[f64], (pair, search): (PairId, ContactSearch), mut radius: f64) -> Option<Place> {
        let space = &self.context.checker.scene().space;
        let mut now = self.place(start.to_vec(), pair, search)?;
        self.offer_place(&now, search);
        radius = radius.max(1e-4 * self.context.scale);
        let (mut penalty, mut next) = (0.0_f64, start.to_vec());
        let mut cuts: Vec<Cut> = Vec::new();
        for step in 0..MAX_STEPS {
            if self.evaluator.is_spent() {
                return None;
            }
            let length = self.step(&now, &cuts, radius)?;
            penalty = penalty.max(2.0 * self.subproblem.qp.multiplier_sum(1));
            // Even the linearised contact is farther than what was found.
            if step >= 2 && self.subproblem.expected(now.distance) > self.limit() {
                return None;
            }
            if length <= TOLERANCE_SHARE * now.distance.max(1e-6 * self.context.scale) {
                break;
            }
            space.integrate(&now.config, &self.subproblem.step, &mut next);
            let there = self.place(next.clone(), pair, search)?;
            self.offer_place(&there, search);
            let merit = |place: &Place| 0.5 * place.distance.powi(2) + penalty * place.missing.max(0.0);
            let along = |row: &[f64]| row.iter().zip(&self.subproblem.step).map(|(slope, x)| slope * x).sum::<f64>();
            if cuts.len() == MAX_CUTS {
                cuts.remove(0);
            }
            if merit(&there) < merit(&now) {
                let is_still = (now.distance - there.distance).abs() < TOLERANCE_SHARE * now.distance;
                let is_met = now.missing <= 0.0 && there.missing <= 0.0;
                radius = if length > 0.9 * radius { 2.0 * radius } else { radius };
                cuts.iter_mut().for_each(|cut| cut.value += along(&cut.row));
                let value = now.contact.distance + along(&now.row);
                cuts.push(Cut { value, row: std::mem::replace(&mut now, there).row });
                if is_still && is_met {
                    break;
                }
            } else {
                cuts.push(Cut { value: there.contact.distance - along(&there.row), row: there.row });
                radius = REJECTED_STEP_SHARE * length.min(radius);
                if radius < STUCK_STEP_SHARE * now.distance {
                    break;
                }
            }
        }
        Some(now)
    }

    /// Returns the nearest configuration in contact, moved back until it is free. If something
    /// collides before on the way there, takes that.
    fn verified(&mut self) -> Option<Found> {
        let space = &self.context.checker.scene().space;
        let mut back = self.q.to_vec();
        loop {
            let found = self.best.take()?;
            if self.evaluator.label(self.context, &found.config) == Label::Free {
                return None;
            }
            for share in BACK_SHARES {
                space.interpolate(self.q, &found.config, 1.0 - share, &mut back);
                if self.evaluator.label(self.context, &back) == Label::Free {
                    let distance = self.evaluator.distance(self.context, self.anchor, &back);
                    return Some(Found { distance, config: back, pair: found.pair });
                }
            }
            let (config, pair) = self.first_collision(&back)?;
            let distance = self.evaluator.distance(self.context, self.anchor, &config);
            if distance <= 0.0 {
                return Some(Found { distance: 0.0, config: self.q.to_vec(), pair });
            }
            self.offer(Found { distance, config: config.clone(), pair });
            self.approach(&config, pair, 0.5 * distance);
        }
    }
}

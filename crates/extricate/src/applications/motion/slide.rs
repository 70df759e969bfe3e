//! A local planner that slides along contacts, every piece of it proved.
//!
//! A straight edge into a tight place hardly ever comes out: contacts turn it aside. A slide
//! follows them: each step goes toward the target as far as linearised contacts allow. If a contact
//! of the step's end is too near, it joins them and the step is taken anew. The step is then
//! proved, and its free part kept.
//!
//! # Source
//! L. Zhang and D. Manocha, "An efficient retraction-based RRT planner", ICRA 2008,
//! doi:10.1109/ROBOT.2008.4543785; M. Ortega, S. Redon and S. Coquillart, "A six degree-of-freedom
//! god-object method for haptic display of rigid bodies with surface properties", IEEE TVCG 13(3),
//! 2007, doi:10.1109/TVCG.2007.1028. Deviations: articulated models; contacts of the end as cutting
//! planes; steps are proved by motion bounds, with the clearance.

use super::prover::Prover;
use crate::collision::{Contact, ContactQuery, ContactSearch};
use crate::kinematics::Twists;
use crate::math::linear_algebra::dot;
use crate::metric::quadratic::Quadratic;
use crate::metric::{Anchor, Metric};
use crate::query::{Qp, QpOutcome};

/// Times that contacts of a step's end join its constraints.
const MAX_CUTS: usize = 6;
/// A step that fails is tried again at this share of its length.
const SHRINK_SHARE: f64 = 0.35;
/// A slide ends if its steps are shorter than this share of the longest.
const MIN_STEP_SHARE: f64 = 0.03;
/// A slide ends if a step comes nearer to the target by less than this share of its length.
const MIN_GAIN_SHARE: f64 = 0.02;
/// Share of a proved part that is kept, since its end is a contact.
const KEPT_SHARE: f64 = 0.98;
/// Bound on how far points move, as a share of the motion bound: steps may be this much longer.
const REACH_FACTOR: f64 = 1.3;

/// Distance beyond the clearance that steps aim to keep, as a share of how far a step may move a
/// point. With three times as much, a peg in a hole of 1.05 times its width takes 2 to 4 times the
/// checks.
const ROOM_SHARE: f64 = 0.03;
/// Share of the room, or of the play at a step's start if that is less, that its end has to keep.
const END_PLAY_SHARE: f64 = 0.3;
/// A step shorter than this share of the longest is none.
const ZERO_STEP_SHARE: f64 = 1e-3;
/// A proved share below the first shortens the next step; below the second nothing is kept.
const PROVED_SHARES: [f64; 2] = [0.2, 0.05];

/// Memory of slides in one scene.
pub struct Slider<'a> {
    metric: &'a Metric,
    /// Longest step (metric units).
    step: f64,
    /// Distance \[m\] beyond the clearance that steps aim to keep.
    room: f64,
    quadratic: Quadratic,
    twists: Twists,
    qp: Qp,
    contacts: Vec<Contact>,
    anchor: Anchor,
    row: Vec<f64>,
    /// Last solution of the quadratic program, a tangent vector.
    solution: Vec<f64>,
    /// Box of the steps.
    limits: [Vec<f64>; 2],
}

impl<'a> Slider<'a> {
    /// Prepares slides with steps of at most `step` (metric units).
    pub fn new(metric: &'a Metric, step: f64) -> Self {
        Self {
            metric,
            step,
            room: ROOM_SHARE * step * metric.lever(),
            quadratic: Quadratic::default(),
            twists: Twists::default(),
            qp: Qp::default(),
            contacts: Vec::new(),
            anchor: Anchor::default(),
            row: Vec::new(),
            solution: Vec::new(),
            limits: Default::default(),
        }
    }

    /// Slides from `from`, which is in the prover's set, toward `target`, by at most `most_steps`
    /// steps. Calls `each` with every configuration reached; returns whether the last is the
    /// target.
    ///
    /// # Guarantee
    /// The edges between successive configurations are proved to lie in the prover's set.
    pub fn slide(
        &mut self,
        prover: &mut Prover,
        from: &[f64],
        target: &[f64],
        most_steps: usize,
        each: &mut dyn FnMut(&[f64]),
    ) -> bool {
        let (mut q, mut next) = (from.to_vec(), vec![0.0; from.len()]);
        let (mut length, mut distance) = (self.step, self.metric.distance(from, target));
        for _ in 0..most_steps {
            if distance <= 0.0 {
                return true;
            }
            if prover.is_spent() || length < MIN_STEP_SHARE * self.step {
                return false;
            }
            let Some(stepped) = self.step(prover, &q, target, length.min(distance), &mut next) else {
                length *= SHRINK_SHARE;
                continue;
            };
            let mut moved = stepped;
            let proved = prover.proved_until(&q, &next);
            if proved < 1.0 {
                let share = KEPT_SHARE * proved;
                if share < PROVED_SHARES[0] {
                    length *= SHRINK_SHARE;
                }
                if share < PROVED_SHARES[1] {
                    continue;
                }
                let end = next.clone();
                prover.checker.scene().space.interpolate(&q, &end, share, &mut next);
                // Interpolation rounds, so that its result needs a proof of its own.
                if !prover.proves(&q, &next) {
                    length *= SHRINK_SHARE;
                    continue;
                }
                moved *= share;
            } else {
                length = (2.0 * length).min(self.step);
            }
            let now = self.metric.distance(&next, target);
            if now > distance - MIN_GAIN_SHARE * moved {
                return false;
            }
            each(&next);
            std::mem::swap(&mut q, &mut next);
            distance = now;
        }
        distance <= 0.0
    }

    /// Writes where a step of at most `length` toward `target` leads; returns how long it is.
    fn step(&mut self, prover: &mut Prover, q: &[f64], target: &[f64], length: f64, next: &mut [f64]) -> Option<f64> {
        let checker = prover.checker;
        let (scene, clearance) = (checker.scene(), checker.base_clearance());
        let (space, nv) = (&scene.space, scene.space.nv());
        let margin = clearance + 2.0 * self.room + REACH_FACTOR * length * self.metric.lever();
        let query = ContactQuery { margin, search: ContactSearch::Exact };
        prover.contacts(q, query, &mut self.contacts);
        let nearest = self.contacts.iter().map(|contact| contact.distance).fold(margin, f64::min);
        let play = (nearest - clearance).max(0.0);
        self.begin(prover, q, target, length);
        for _ in 0..MAX_CUTS {
            if self.qp.solve(&self.quadratic.hessian, &self.quadratic.gradient, f64::INFINITY) == QpOutcome::Infeasible
            {
                return None;
            }
            self.solution.clear();
            self.solution.extend_from_slice(&self.qp.step[..nv]);
            let mut moved = self.quadratic.tensor.length(&self.solution);
            if moved > REACH_FACTOR * length {
                let share = REACH_FACTOR * length / moved;
                self.solution.iter_mut().for_each(|x| *x *= share);
                moved *= share;
            }
            if moved < ZERO_STEP_SHARE * self.step {
                return None;
            }
            space.integrate(q, &self.solution, next);
            prover.contacts(next, query, &mut self.contacts);
            let least = self.contacts.iter().map(|contact| contact.distance).fold(margin, f64::min);
            if least >= clearance + END_PLAY_SHARE * self.room.min(play) {
                return Some(moved);
            }
            self.twists.set(scene, prover.scratch().poses());
            for contact in self.contacts.iter().filter(|contact| contact.distance - clearance < self.room) {
                self.row.clear();
                self.row.resize(nv, 0.0);
                contact.add_gradient(scene, &self.twists, &mut self.row);
                // The row is linearised at the end of the step.
                let wanted = self.room.min(0.5 * play) - (contact.distance - clearance);
                self.qp.push(wanted + dot(&self.row, &self.solution))[..nv].copy_from_slice(&self.row);
            }
        }
        None
    }

    /// Sets up the quadratic program of a step: toward `target` by `length`, along the contacts
    /// that were found at `q`, within the limits.
    fn begin(&mut self, prover: &mut Prover, q: &[f64], target: &[f64], length: f64) {
        let checker = prover.checker;
        let (scene, clearance) = (checker.scene(), checker.base_clearance());
        let (space, nv) = (&scene.space, scene.space.nv());
        let distance = self.metric.distance(q, target);
        let mut aim = target.to_vec();
        if distance > length {
            space.interpolate(q, target, length / distance, &mut aim);
        }
        self.metric.anchor(&aim, &mut self.anchor);
        let poses = prover.scratch().poses();
        self.metric.quadratic_model(&self.anchor, q, poses, &mut self.quadratic);
        self.twists.set(scene, poses);
        self.qp.reset(self.quadratic.unknowns);
        let [low, high] = &mut self.limits;
        self.quadratic.step_box(space, q, REACH_FACTOR * length, [low, high]);
        self.qp.set_box(low, high);
        for (row, bound) in self.quadratic.rows.chunks_exact(self.quadratic.unknowns).zip(&self.quadratic.bounds) {
            self.qp.push(*bound).copy_from_slice(row);
        }
        for contact in &self.contacts {
            let play = contact.distance - clearance;
            // In any play there is a step that keeps half of it.
            let row = self.qp.push(self.room.min(0.5 * play.max(0.0)) - play);
            contact.add_gradient(scene, &self.twists, &mut row[..nv]);
        }
    }
}

//! The quadratic program of one iteration: what it is made of, and what becomes of its step.

use crate::collision::Contact;
use crate::cspace::{ConfigSpace, Manifold};
use crate::kinematics::Twists;
use crate::math::Pose;
use crate::metric::quadratic::Quadratic;
use crate::query::context::Context;
use crate::query::qp::{Qp, QpOutcome};
use crate::samples::contact_planes::Planes;

/// Half the squared distance as the metric's model has it, subject to linearised contacts, joint
/// limits and a trust region.
#[derive(Default)]
pub struct Subproblem {
    /// The model of the metric at the present configuration.
    pub quadratic: Quadratic,
    /// What a descent aims at beyond the clearance \[m\].
    pub slack: f64,
    /// The tangent part of the last solution, within the box.
    pub step: Vec<f64>,
    pub(crate) qp: Qp,
    pub(crate) low: Vec<f64>,
    high: Vec<f64>,
    twists: Twists,
    /// From where a step leads to a known end.
    pub(crate) rest: Vec<f64>,
    /// Of the metric, a coordinate each.
    pub(crate) inverse_weights: Vec<f64>,
}

impl Subproblem {
    /// One row a contact and one more for each pair that is to stay in touch, how many is
    /// returned; then the metric's own; the box of limits and trust region.
    pub fn build(
        &mut self,
        context: &Context,
        x: &[f64],
        radius: f64,
        (contacts, poses): (&[Contact], &[Pose]),
    ) -> usize {
        let scene = context.checker.scene();
        self.begin(&scene.space, x, radius, context.locked);
        self.twists.set(scene, poses);
        let nv = self.low.len();
        for contact in contacts {
            contact.add_gradient(scene, &self.twists, &mut self.qp.push(0.0)[..nv]);
            self.bound_last_row(context.clearance + self.slack - contact.distance);
        }
        for pair in context.held.pairs {
            let own = contacts.iter().filter(|contact| contact.pair == *pair);
            let Some(contact) = own.min_by(|a, b| a.distance.total_cmp(&b.distance)) else { continue };
            let row = &mut self.qp.push(0.0)[..nv];
            contact.add_gradient(scene, &self.twists, row);
            row.iter_mut().for_each(|slope| *slope = -*slope);
            self.bound_last_row(contact.distance - context.held.most);
        }
        self.end()
    }

    /// The same of contact planes that are known of `x`.
    pub fn build_from_planes(
        &mut self,
        space: &ConfigSpace,
        x: &[f64],
        radius: f64,
        (planes, locked): (Planes, &[bool]),
    ) -> usize {
        self.begin(space, x, radius, locked);
        for (room, gradient) in planes.iter() {
            self.qp.push(0.0).iter_mut().zip(gradient).for_each(|(slot, g)| *slot = g);
            self.bound_last_row(self.slack - room);
        }
        self.end()
    }

    /// Solves it; told where its value is more than `most`.
    pub fn solve(&mut self, most: f64) -> QpOutcome {
        let Self { qp, quadratic, .. } = self;
        qp.solve(&quadratic.hessian, &quadratic.gradient, most)
    }

    /// The distance that the solution leads to, from `distance`.
    pub fn expected(&self, distance: f64) -> f64 {
        self.quadratic.expected_distance(distance, &self.qp.step)
    }

    fn begin(&mut self, space: &ConfigSpace, x: &[f64], radius: f64, locked: &[bool]) {
        let Self { quadratic, low, high, qp, .. } = self;
        let nv = space.nv();
        low.clear();
        high.clear();
        for k in 0..nv {
            let reach = radius / quadratic.tensor.diagonal(k).sqrt();
            low.push(-reach);
            high.push(reach);
        }
        for factor in space.factors() {
            if let Manifold::Interval { lower, upper } = factor.manifold {
                low[factor.v] = low[factor.v].max(lower - x[factor.q]).min(0.0);
                high[factor.v] = high[factor.v].min(upper - x[factor.q]).max(0.0);
            }
        }
        for v in (0..locked.len()).filter(|v| locked[*v]) {
            (low[v], high[v]) = (0.0, 0.0);
        }
        qp.reset(quadratic.unknowns);
    }

    fn end(&mut self) -> usize {
        let Self { quadratic, low, high, qp, .. } = self;
        let contacts = qp.rows();
        qp.set_box(low, high);
        for (row, bound) in quadratic.rows.chunks_exact(quadratic.unknowns).zip(&quadratic.bounds) {
            qp.push(*bound).copy_from_slice(row);
        }
        contacts
    }

    /// Asks `wanted` of the row that was added last, but no more than the box can give, or the
    /// program has no solution.
    fn bound_last_row(&mut self, wanted: f64) {
        let Self { low, high, qp, .. } = self;
        // The box holds the step of none, which gives that much.
        if wanted <= 0.0 {
            *qp.last_bound() = wanted;
            return;
        }
        let sides = low.iter().zip(&*high);
        let reach: f64 = qp.last_row()[..low.len()].iter().zip(sides).map(|(a, (l, h))| f64::max(a * l, a * h)).sum();
        *qp.last_bound() = wanted.min(0.8 * reach);
    }

    /// Keeps the solution's step within the box, and returns how long it is in the metric.
    pub fn clip_step(&mut self) -> f64 {
        let Self { quadratic, step, low, high, qp, .. } = self;
        step.clear();
        step.extend_from_slice(&qp.step[..low.len()]);
        for (s, (l, h)) in step.iter_mut().zip(low.iter().zip(&*high)) {
            *s = s.clamp(*l, *h);
        }
        quadratic.tensor.length(step)
    }

    /// Whether the trust region, not only a joint limit, held the step back in some coordinate.
    ///
    /// Measured by coordinate, because along a self-motion that moves bodies little a step that
    /// fills the box is short.
    pub fn step_at_rim(&self, radius: f64) -> bool {
        let reach = |k: usize| radius / self.quadratic.tensor.diagonal(k).sqrt();
        self.step.iter().enumerate().any(|(k, s)| s.abs() > 0.99 * reach(k))
    }
}

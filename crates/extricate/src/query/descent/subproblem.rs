//! The quadratic program of one iteration of a descent, and its step.

use crate::collision::Contact;
use crate::cspace::ConfigSpace;
use crate::kinematics::Twists;
use crate::math::Pose;
use crate::metric::quadratic::Quadratic;
use crate::query::context::Context;
use crate::query::keep::{KeptRows, Span};
use crate::query::qp::{Qp, QpOutcome};
use crate::samples::contact_planes::Planes;

/// Minimises the metric's model of half the squared distance, subject to linearised contacts, joint
/// limits and a trust region.
#[derive(Default)]
pub struct Subproblem {
    /// Model of half the squared distance at the present configuration.
    pub quadratic: Quadratic,
    /// Target distance beyond the clearance \[m\].
    pub slack: f64,
    /// Tangent part of the last solution, clamped to the box.
    pub step: Vec<f64>,
    pub(crate) qp: Qp,
    pub(crate) low: Vec<f64>,
    high: Vec<f64>,
    twists: Twists,
    kept: KeptRows,
    span: Span,
    /// Inverse weights of the coordinates that may move; 0 for others.
    inverse: Vec<f64>,
    /// Difference between a known end and the end of a step.
    pub(crate) rest: Vec<f64>,
    /// Inverse diagonal entries of the Hessian.
    pub(crate) inverse_weights: Vec<f64>,
}

impl Subproblem {
    /// Builds the program from contacts, with one row for each contact and one for each pair that
    /// has to stay in touch. The rows of kept links, those of the metric and the box follow.
    /// Returns the number of rows before these.
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
        self.set_kept(context, poses);
        for contact in contacts {
            contact.add_gradient(scene, &self.twists, &mut self.qp.push(0.0)[..nv]);
            self.bound_last_row(context.clearance + self.slack - contact.distance);
        }
        for pair in context.touching.pairs {
            let own = contacts.iter().filter(|contact| contact.pair == *pair);
            let Some(contact) = own.min_by(|a, b| a.distance.total_cmp(&b.distance)) else { continue };
            let row = &mut self.qp.push(0.0)[..nv];
            contact.add_gradient(scene, &self.twists, row);
            row.iter_mut().for_each(|slope| *slope = -*slope);
            self.bound_last_row(contact.distance - context.touching.aim);
        }
        let rows = self.qp.rows();
        self.kept.push(&mut self.qp, nv);
        self.end();
        rows
    }

    /// Builds the program of a step that brings a pair to the clearance less the slack, or nearer,
    /// by linear models of its distance: values at `x`, and gradients.
    pub fn build_closing<'a>(
        &mut self,
        context: &Context,
        x: &[f64],
        radius: f64,
        models: impl Iterator<Item = (f64, &'a [f64])>,
    ) {
        self.begin(&context.checker.scene().space, x, radius, context.locked);
        for (value, row) in models {
            self.qp.push(0.0).iter_mut().zip(row).for_each(|(slot, slope)| *slot = -slope);
            self.bound_last_row(value - (context.clearance - self.slack));
        }
        self.end();
    }

    /// Builds the program from the contact planes of `x`; else as [`Subproblem::build`].
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
        let rows = self.qp.rows();
        self.end();
        rows
    }

    /// Solves the program; ends as [`QpOutcome::Above`] if the minimum exceeds `most`.
    pub fn solve(&mut self, most: f64) -> QpOutcome {
        let Self { qp, quadratic, .. } = self;
        qp.solve(&quadratic.hessian, &quadratic.gradient, most)
    }

    /// Returns the distance that the model expects after the step, starting from `distance`.
    pub fn expected(&self, distance: f64) -> f64 {
        self.quadratic.expected_distance(distance, &self.qp.step)
    }

    fn begin(&mut self, space: &ConfigSpace, x: &[f64], radius: f64, locked: &[bool]) {
        let Self { quadratic, low, high, qp, kept, .. } = self;
        // Programs from planes have no kept links.
        kept.clear();
        quadratic.step_box(space, x, radius, [low, high]);
        for v in (0..locked.len()).filter(|v| locked[*v]) {
            (low[v], high[v]) = (0.0, 0.0);
        }
        qp.reset(quadratic.unknowns);
    }

    fn end(&mut self) {
        let Self { quadratic, low, high, qp, .. } = self;
        qp.set_box(low, high);
        for (row, bound) in quadratic.rows.chunks_exact(quadratic.unknowns).zip(&quadratic.bounds) {
            qp.push(*bound).copy_from_slice(row);
        }
    }

    /// Linearises the kept links, and finds the span of their rows.
    fn set_kept(&mut self, context: &Context, poses: &[Pose]) {
        let Self { quadratic, kept, span, inverse, twists, .. } = self;
        kept.set(context.checker.scene(), context.kept, poses, twists);
        if context.kept.is_empty() {
            return;
        }
        inverse.clear();
        let weight = |v: usize| if context.is_locked(v) { 0.0 } else { 1.0 / quadratic.tensor.diagonal(v) };
        inverse.extend((0..context.checker.scene().space.nv()).map(weight));
        span.set(&kept.rows, inverse);
    }

    /// Sets the bound of the last row to `wanted`, but to no more than the box can give: otherwise
    /// the program has no solution.
    fn bound_last_row(&mut self, wanted: f64) {
        let Self { low, high, qp, kept, span, inverse, .. } = self;
        // The zero step is in the box and satisfies such a row.
        if wanted <= 0.0 {
            *qp.last_bound() = wanted;
            return;
        }
        let row = &qp.last_row()[..low.len()];
        let reach = if kept.rows.is_empty() {
            row.iter().zip(low.iter().zip(&*high)).map(|(a, (l, h))| f64::max(a * l, a * h)).sum::<f64>()
        } else {
            // Only what the kept links leave of the row can be reached: along its steepest
            // direction to the rim of the trust region.
            let left = span.reduce(row, inverse);
            let (mut slope, mut scale) = (0.0, f64::INFINITY);
            for (v, a) in left.iter().enumerate() {
                let along = inverse[v] * a;
                slope += a * along;
                if along != 0.0 {
                    scale = scale.min(low[v].abs().max(high[v]) / along.abs());
                }
            }
            if slope > 0.0 { slope * scale } else { 0.0 }
        };
        *qp.last_bound() = wanted.min(0.8 * reach);
    }

    /// Clamps the step to the box and returns its length in the metric.
    pub fn clip_step(&mut self) -> f64 {
        let Self { quadratic, step, low, high, qp, .. } = self;
        step.clear();
        step.extend_from_slice(&qp.step[..low.len()]);
        for (s, (l, h)) in step.iter_mut().zip(low.iter().zip(&*high)) {
            *s = s.clamp(*l, *h);
        }
        quadratic.tensor.length(step)
    }

    /// Whether the trust region, and not only a joint limit, held the step back in some coordinate.
    ///
    /// Each coordinate is compared separately: a step along a self-motion, which moves bodies
    /// little, is short even if it fills the box.
    pub fn step_at_rim(&self, radius: f64) -> bool {
        let reach = |k: usize| radius / self.quadratic.tensor.diagonal(k).sqrt();
        self.step.iter().enumerate().any(|(k, s)| s.abs() > 0.99 * reach(k))
    }
}

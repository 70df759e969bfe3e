//! The quadratic program of one iteration: what it is made of, and what becomes of its step.

use super::{RefineScratch, SLACK};
use crate::boundary::tangents::Planes;
use crate::cspace::Manifold;
use crate::penetration::Ground;

impl RefineScratch {
    /// Rows: one a contact (of `planes`, where they are given), how many is returned; then the metric's own; the box of limits and trust
    /// region.
    pub(super) fn build_program(&mut self, ground: &Ground, x: &[f64], radius: f64, planes: Option<Planes>) -> usize {
        let scene = ground.checker.scene();
        let nv = scene.space.nv();
        self.low.clear();
        self.high.clear();
        for k in 0..nv {
            let reach = radius / self.quadratic.tensor[k * nv + k].sqrt();
            self.low.push(-reach);
            self.high.push(reach);
        }
        for factor in scene.space.factors() {
            if let Manifold::Interval { lower, upper } = factor.manifold {
                self.low[factor.v] = self.low[factor.v].max(lower - x[factor.q]).min(0.0);
                self.high[factor.v] = self.high[factor.v].min(upper - x[factor.q]).max(0.0);
            }
        }
        let unknowns = self.quadratic.unknowns;
        self.qp.reset(unknowns);
        if let Some(planes) = planes {
            for (room, gradient) in planes.iter() {
                self.qp.push(0.0).iter_mut().zip(gradient).for_each(|(slot, g)| *slot = g);
                self.bound_last_row(nv, SLACK - room);
            }
        } else {
            for at in 0..self.contacts.len() {
                let contact = &self.contacts[at];
                contact.add_gradient(scene, &self.poses, &mut self.qp.push(0.0)[..nv]);
                self.bound_last_row(nv, ground.clearance + SLACK - contact.distance);
            }
        }
        let contacts = self.qp.rows();
        self.qp.set_box(&self.low, &self.high);
        for (row, bound) in self.quadratic.rows.chunks_exact(unknowns).zip(&self.quadratic.bounds) {
            self.qp.push(*bound).copy_from_slice(row);
        }
        contacts
    }

    /// Asks `wanted` of the row that was added last, but no more than the box can give, or the program has no solution.
    fn bound_last_row(&mut self, nv: usize, wanted: f64) {
        let sides = self.low.iter().zip(&self.high);
        let reach: f64 = self.qp.last_row()[..nv].iter().zip(sides).map(|(a, (l, h))| f64::max(a * l, a * h)).sum();
        *self.qp.last_bound() = wanted.min(0.8 * reach);
    }

    /// Whether the trust region, not only a joint limit, held the step back in some coordinate.
    ///
    /// Measured by coordinate, because along a self-motion that moves bodies little a step that fills the box is short.
    pub(super) fn step_at_rim(&self, radius: f64) -> bool {
        let nv = self.step.len();
        let reach = |k: usize| radius / self.quadratic.tensor[k * nv + k].sqrt();
        self.step.iter().enumerate().any(|(k, s)| s.abs() > 0.99 * reach(k))
    }

    pub(super) fn clip_step(&mut self) {
        self.step.clear();
        self.step.extend_from_slice(&self.qp.step[..self.low.len()]);
        for (k, s) in self.step.iter_mut().enumerate() {
            *s = s.clamp(self.low[k], self.high[k]);
        }
    }
}

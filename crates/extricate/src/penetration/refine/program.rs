//! The quadratic program of one iteration: what it is made of, and what becomes of its step.

use super::{QpOutcome, RefineScratch, Start};
use crate::boundary::tangents::Planes;
use crate::cspace::Manifold;
use crate::kinematics::forward;
use crate::metric::Anchor;
use crate::penetration::Ground;
use crate::penetration::answer::SEPARATION;
use crate::penetration::hope::Hope;
use crate::scene::MetricSpec;

/// How far the foot of the query is looked for, as a multiple of the distance of the start: beyond any that counts.
const FAR: f64 = 3.0;
/// Descents that are expected to end within this share of the nearest way out of each other end at the same one: with 0.3 one query in a thousand ends
/// more than 1 % farther.
const SAME_END: f64 = 0.2;

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
                self.bound_last_row(nv, self.slack - room);
            }
        } else {
            self.twists.set(scene, &self.poses);
            for at in 0..self.contacts.len() {
                let contact = &self.contacts[at];
                contact.add_gradient(scene, &self.twists, &mut self.qp.push(0.0)[..nv]);
                self.bound_last_row(nv, ground.clearance + self.slack - contact.distance);
            }
        }
        let contacts = self.qp.rows();
        self.qp.set_box(&self.low, &self.high);
        for (row, bound) in self.quadratic.rows.chunks_exact(unknowns).zip(&self.quadratic.bounds) {
            self.qp.push(*bound).copy_from_slice(row);
        }
        contacts
    }

    /// Whether the planes of `x` (`distance` from the query) lead farther than `hope` times the `ceiling`, or to where another descent ended: by the foot of the query
    /// on them, which is too far off to go there, but near enough to tell ways out apart. The model has to be that of `x`.
    pub(super) fn foot_is_elsewhere(
        &mut self,
        ground: &Ground,
        x: &[f64],
        planes: Planes,
        distance: f64,
        hope: f64,
        ceiling: f64,
    ) -> bool {
        if self.quadratic.is_diagonal && self.one_plane_leads_beyond(planes, hope * ceiling) {
            return true;
        }
        self.build_program(ground, x, FAR * distance, Some(planes));
        let most = 0.5 * ((hope * ceiling).powi(2) - distance * distance);
        match self.qp.solve(&self.quadratic.hessian, &self.quadratic.gradient, most) {
            QpOutcome::Above => return true,
            QpOutcome::Infeasible => return false,
            QpOutcome::Solved => {}
        }
        self.leads_to_an_end(ground, x, SEPARATION * ceiling)
    }

    /// Whether a descent in turn at `x` is about to end where another one did, which then was no nearer: it would take some more looks to come there.
    pub(super) fn ends_as_another(&mut self, ground: &Ground, x: &[f64], hope: Hope, ceiling: f64) -> bool {
        hope.is_in_turn() && self.expected > ceiling && self.leads_to_an_end(ground, x, SAME_END * ceiling)
    }

    /// Whether the step of the program leads from `x` to within `reach` of where another descent ended.
    fn leads_to_an_end(&mut self, ground: &Ground, x: &[f64], reach: f64) -> bool {
        let Self { quadratic, ends, rest, low, qp, .. } = self;
        let space = &ground.checker.scene().space;
        rest.resize(low.len(), 0.0);
        ends.chunks_exact(x.len()).any(|end| {
            space.difference(x, end, rest);
            rest.iter_mut().zip(&qp.step).for_each(|(rest, step)| *rest -= step);
            quadratic.step_length(rest) < reach
        })
    }

    /// Whether the planes that are known of a start, which need not be all, lead elsewhere: others only lead farther.
    pub(super) fn leads_nowhere(
        &mut self,
        ground: &Ground,
        anchor: &Anchor,
        start: &Start,
        distance: f64,
        hope: Hope,
        ceiling: f64,
    ) -> bool {
        let Some((planes, hope)) = start.planes.zip(hope.of_foot()) else { return false };
        let x = start.config;
        if ground.metric.kind() != MetricSpec::Joint {
            forward(ground.checker.scene(), x, &mut self.poses);
        }
        ground.metric.quadratic_model(anchor, x, &self.poses, &mut self.quadratic);
        let is_elsewhere = self.foot_is_elsewhere(ground, x, planes, distance, hope, ceiling);
        if is_elsewhere {
            self.expected = hope * ceiling;
        }
        is_elsewhere
    }

    /// Whether one of the planes alone is farther than `limit` from the query, the Hessian being diagonal: then so is the foot on all of them. Tells nearly
    /// all of those that are, without a program.
    fn one_plane_leads_beyond(&mut self, planes: Planes, limit: f64) -> bool {
        let Self { quadratic, step, inverse_weights, slack, .. } = self;
        let nv = quadratic.unknowns;
        inverse_weights.clear();
        inverse_weights.extend((0..nv).map(|k| 1.0 / quadratic.hessian[k * nv + k]));
        // Back to the query.
        step.clear();
        step.extend(quadratic.gradient.iter().zip(&*inverse_weights).map(|(slope, inverse)| -slope * inverse));
        let limit_squared = limit * limit;
        planes.iter().any(|(room, gradient)| {
            let (mut missing, mut squared) = (*slack - room, 0.0);
            for ((g, step), inverse) in gradient.zip(&*step).zip(&*inverse_weights) {
                missing -= g * step;
                squared += g * g * inverse;
            }
            missing > 0.0 && missing * missing > limit_squared * squared
        })
    }

    /// Asks `wanted` of the row that was added last, but no more than the box can give, or the program has no solution.
    fn bound_last_row(&mut self, nv: usize, wanted: f64) {
        // The box holds the step of none, which gives that much.
        if wanted <= 0.0 {
            *self.qp.last_bound() = wanted;
            return;
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::tangents::Tangents;
    use crate::learning::LearnOptions;
    use crate::model::Model;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    #[test]
    fn the_foot_tells_far_exits_and_those_that_lead_to_known_ends() {
        let options = LearnOptions { labels: 5_000, seconds: None, ..LearnOptions::default() };
        let scene = builtin::scene("planar-arm").unwrap();
        let model = Model::learn(scene, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let (ground, space) = (model.ground(), &model.scene().space);
        let (x, nv): (Vec<f64>, usize) = (vec![0.0; space.nq()], space.nv());
        let at = |steps: [f64; 2]| -> Vec<f64> {
            let (mut step, mut q): (Vec<f64>, Vec<f64>) = (vec![0.0; nv], x.clone());
            step[..2].copy_from_slice(&steps);
            space.integrate(&x, &step, &mut q);
            q
        };
        // Toward the query along the first coordinate, a plane ends the way after 0.3 of 1.
        let mut tangents = Tangents::new(nv);
        let mut toward = vec![0.0; nv];
        toward[0] = -1.0;
        tangents.push(0, 0.3, &toward);
        tangents.end_sample();
        let planes = tangents.planes(0);
        let q = at([1.0, 0.0]);
        let mut anchor = Anchor::default();
        ground.metric.anchor(&q, &mut anchor);
        let mut scratch = RefineScratch::default();
        let distance = scratch.distance(&ground, &anchor, &x);
        let (foot, unit) = (scratch.distance(&ground, &anchor, &at([0.3, 0.0])), distance);
        assert!(foot < 0.8 * unit);
        let mut is_elsewhere = |ceiling: f64, end: Option<&[f64]>| {
            scratch.ends.clear();
            scratch.ends.extend_from_slice(end.unwrap_or_default());
            ground.metric.quadratic_model(&anchor, &x, &[], &mut scratch.quadratic);
            scratch.foot_is_elsewhere(&ground, &x, planes, distance, 1.2, ceiling)
        };
        assert!(!is_elsewhere(f64::INFINITY, None));
        assert!(!is_elsewhere(foot / 1.19, None) && is_elsewhere(foot / 1.21, None));
        for off in [-1.0, 1.0] {
            let share = |share: f64| at([0.3, off * share * foot]);
            assert!(is_elsewhere(foot, Some(&share(0.9 * SEPARATION))));
            assert!(!is_elsewhere(foot, Some(&share(1.1 * SEPARATION))));
        }
        // The step is that to the foot; what lies beyond the best so far ends as another does that ended beside it.
        let mut ends_as_another = |off: f64, expected: f64, hope: Hope| {
            scratch.ends = [x.clone(), at([0.3, off * SAME_END * foot])].concat();
            scratch.expected = expected * foot;
            scratch.ends_as_another(&ground, &x, hope, foot)
        };
        assert!(ends_as_another(0.9, 1.01, Hope::IN_TURN) && ends_as_another(-0.9, 1.01, Hope::IN_TURN));
        assert!(!ends_as_another(1.1, 1.01, Hope::IN_TURN) && !ends_as_another(-1.1, 1.01, Hope::IN_TURN));
        assert!(!ends_as_another(0.9, 0.99, Hope::IN_TURN) && !ends_as_another(0.9, 1.01, Hope::OF_A_PROBE));
    }
}

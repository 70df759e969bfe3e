//! Pruning: gives up starts and descents that cannot beat the incumbent, or that lead to a known
//! end.

use super::subproblem::Subproblem;
use crate::cspace::ConfigSpace;
use crate::query::answer::SEPARATION;
use crate::query::exits::Exits;
use crate::query::qp::QpOutcome;
use crate::samples::contact_planes::Planes;

/// The limits that a descent has to beat.
#[derive(Clone, Copy)]
pub struct Pruning<'a> {
    /// Depth of the nearest exit, or of the last wanted exit if several are wanted.
    pub incumbent: f64,
    /// A start is given up if the projection of the query on its contact planes is farther than
    /// this times the incumbent.
    pub factor: f64,
    /// Ends of other descents, if descents that lead there are given up.
    pub exits: Option<&'a Exits>,
}

/// The projection is searched within this times the distance of the start, beyond any that counts.
const PROJECTION_RADIUS_FACTOR: f64 = 3.0;

impl Pruning<'_> {
    /// Creates the limits of a descent that the ends of other descents do not stop.
    pub fn alone(incumbent: f64) -> Self {
        Self { incumbent, factor: 1.0, exits: None }
    }

    /// Returns how far a descent may be expected to end after an iteration. The limit falls because
    /// the expectation improves with every iteration.
    pub fn limit(&self, iteration: usize) -> f64 {
        (1.0 + (self.factor - 1.0) * 0.5_f64.powi(iteration as i32)) * self.incumbent
    }
}

impl Subproblem {
    /// Whether the projection of the query on the contact planes of `x` (`distance` from the query)
    /// is beyond the limit or at a known end. The quadratic model has to be that of `x`.
    pub fn projection_is_of_no_use(
        &mut self,
        space: &ConfigSpace,
        x: &[f64],
        planes: Planes,
        distance: f64,
        pruning: &Pruning,
    ) -> bool {
        let limit = pruning.factor * pruning.incumbent;
        if self.quadratic.hessian.is_diagonal() && self.one_plane_leads_beyond(planes, limit) {
            return true;
        }
        self.build_from_planes(space, x, PROJECTION_RADIUS_FACTOR * distance, (planes, &[]));
        let most = 0.5 * (limit.powi(2) - distance * distance);
        match self.solve(most) {
            QpOutcome::Above => true,
            QpOutcome::Infeasible => false,
            QpOutcome::Solved => self.leads_to_an_end(space, x, pruning),
        }
    }

    /// Whether the step of the program leads from `x` to the end of another descent.
    pub fn leads_to_an_end(&mut self, space: &ConfigSpace, x: &[f64], pruning: &Pruning) -> bool {
        let Self { quadratic, rest, low, qp, .. } = self;
        rest.resize(low.len(), 0.0);
        pruning.exits.into_iter().flat_map(Exits::last).any(|end| {
            space.difference(x, &end.config, rest);
            rest.iter_mut().zip(&qp.step).for_each(|(rest, step)| *rest -= step);
            quadratic.tensor.length(rest) < SEPARATION * pruning.incumbent.min(end.distance)
        })
    }

    /// Whether a single plane is farther than `limit` from the query; then so is the projection on
    /// all. Needs a diagonal Hessian. Finds nearly all far projections without a quadratic program.
    fn one_plane_leads_beyond(&mut self, planes: Planes, limit: f64) -> bool {
        let Self { quadratic, step, inverse_weights, slack, .. } = self;
        inverse_weights.clear();
        inverse_weights.extend(quadratic.hessian.entries().iter().map(|h| 1.0 / h));
        // The step back to the query.
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::{Anchor, MetricScratch};
    use crate::query::local_metric::LocalMetric;
    use crate::query::prepared::Prepared;
    use crate::samples::contact_planes::ContactPlanes;
    use crate::scene::builtin;

    #[test]
    fn the_projection_tells_starts_that_lead_far_and_those_that_lead_to_known_ends() {
        let world = Prepared::new(builtin::scene("planar-arm").unwrap());
        let (metric, space) = (world.metric(), &world.scene().space);
        let (x, nv): (Vec<f64>, usize) = (vec![0.0; space.nq()], space.nv());
        let at = |steps: [f64; 2]| -> Vec<f64> {
            let (mut step, mut q): (Vec<f64>, Vec<f64>) = (vec![0.0; nv], x.clone());
            step[..2].copy_from_slice(&steps);
            space.integrate(&x, &step, &mut q);
            q
        };
        // The query is 1 away along the first coordinate, and a plane stops the way there after
        // 0.3.
        let mut stored = ContactPlanes::new(nv);
        let mut toward = vec![0.0; nv];
        toward[0] = -1.0;
        stored.push(0, 0.3, &toward);
        stored.end_sample();
        let planes = stored.planes(0);
        let (mut anchor, mut scratch) = (Anchor::default(), MetricScratch::default());
        metric.anchor(&at([1.0, 0.0]), &mut anchor);
        let distance = metric.distance_from(&anchor, &x, &mut scratch);
        let projection = metric.distance_from(&anchor, &at([0.3, 0.0]), &mut scratch);
        assert!(projection < 0.8 * distance);
        let mut subproblem = Subproblem::default();
        metric.quadratic_model(&anchor, &x, &[], &mut subproblem.quadratic);
        let mut is_of_no_use = |incumbent: f64, end: Option<&[f64]>| {
            let (mut exits, mut local) = (Exits::default(), LocalMetric::default());
            local.set(&world.context(), &anchor);
            end.iter().for_each(|end| exits.offer((space, &mut local), (projection, end), (true, true)));
            let pruning = Pruning { incumbent, factor: 1.2, exits: Some(&exits) };
            subproblem.projection_is_of_no_use(space, &x, planes, distance, &pruning)
        };
        assert!(!is_of_no_use(1e9, None));
        assert!(!is_of_no_use(projection / 1.19, None) && is_of_no_use(projection / 1.21, None));
        for off in [-1.0, 1.0] {
            let end = |share: f64| at([0.3, off * share * SEPARATION * projection]);
            assert!(is_of_no_use(projection, Some(&end(0.9))) && !is_of_no_use(projection, Some(&end(1.1))));
        }
    }

    #[test]
    fn what_a_descent_may_lead_to_comes_down_to_the_incumbent() {
        let pruning = Pruning { factor: 2.0, ..Pruning::alone(0.5) };
        let limits: Vec<f64> = (0..60).map(|iteration| pruning.limit(iteration)).collect();
        assert!(limits[0] == 1.0 && limits[1] == 0.75 && limits.is_sorted_by(|a, b| a >= b) && limits[59] == 0.5);
    }
}

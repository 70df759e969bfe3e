//! Which starts and descents are given up: those that lead farther than the incumbent, or to an end
//! that is known.

use crate::cspace::ConfigSpace;
use crate::query::descent::qp::QpOutcome;
use crate::query::descent::subproblem::Subproblem;
use crate::samples::contact_planes::Planes;

/// What a descent has to beat.
#[derive(Clone, Copy)]
pub struct Pruning<'a> {
    /// Depth of the incumbent; of several wanted exits, of the last of them.
    pub incumbent: f64,
    /// A start whose contact planes put the projection of the query farther than this times the
    /// incumbent is given up.
    pub factor: f64,
    /// Where other descents of the search ended.
    pub ends: &'a Ends,
}

/// Configurations in which descents of a search ended, no two of them alike.
#[derive(Debug, Clone, Default)]
pub struct Ends {
    nq: usize,
    configs: Vec<f64>,
}

/// The projection is looked for as far as this times the distance of the start: beyond any that
/// counts.
const FAR: f64 = 3.0;
/// Descents that are expected to end within this share of the incumbent's depth of each other end
/// at the same exit: with 0.3 one query in a thousand ends more than 1 % farther.
pub const SAME_END: f64 = 0.2;

impl Pruning<'_> {
    /// How far a descent may be expected to end after so many iterations: what it sees of its end
    /// gets better with every one of them.
    pub fn limit(&self, iteration: usize) -> f64 {
        (1.0 + (self.factor - 1.0) * 0.5_f64.powi(iteration as i32)) * self.incumbent
    }
}

impl Ends {
    /// Of configurations of `nq` coordinates, none yet.
    pub fn reset(&mut self, nq: usize) {
        self.nq = nq;
        self.configs.clear();
    }

    /// Adds one that is unlike the others.
    pub fn push(&mut self, end: &[f64]) {
        self.configs.extend_from_slice(end);
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.configs.len() / self.nq.max(1)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.configs.chunks_exact(self.nq.max(1))
    }
}

impl Subproblem {
    /// Whether the contact planes of `x` (`distance` from the query) put the projection of the
    /// query on them beyond what a start may lead to, or at a known end. The model has to be that
    /// of `x`.
    pub fn projection_is_of_no_use(
        &mut self,
        space: &ConfigSpace,
        x: &[f64],
        planes: Planes,
        distance: f64,
        pruning: &Pruning,
    ) -> bool {
        let limit = pruning.factor * pruning.incumbent;
        if self.quadratic.is_diagonal && self.one_plane_leads_beyond(planes, limit) {
            return true;
        }
        self.build_from_planes(space, x, FAR * distance, (planes, &[]));
        let most = 0.5 * (limit.powi(2) - distance * distance);
        match self.solve(most) {
            QpOutcome::Above => true,
            QpOutcome::Infeasible => false,
            QpOutcome::Solved => self.leads_to_an_end(space, x, pruning),
        }
    }

    /// Whether the step of the program leads from `x` to where another descent ended.
    pub fn leads_to_an_end(&mut self, space: &ConfigSpace, x: &[f64], pruning: &Pruning) -> bool {
        let Self { quadratic, rest, low, qp, .. } = self;
        let reach = SAME_END * pruning.incumbent;
        rest.resize(low.len(), 0.0);
        pruning.ends.iter().any(|end| {
            space.difference(x, end, rest);
            rest.iter_mut().zip(&qp.step).for_each(|(rest, step)| *rest -= step);
            quadratic.step_length(rest) < reach
        })
    }

    /// Whether one of the planes alone is farther than `limit` from the query, the Hessian being
    /// diagonal: then so is the projection on all of them. Tells nearly all of those that are,
    /// without a program.
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::metric::{Anchor, MetricScratch};
    use crate::model::Model;
    use crate::samples::contact_planes::ContactPlanes;
    use crate::scene::builtin;

    #[test]
    fn the_projection_tells_starts_that_lead_far_and_those_that_lead_to_known_ends() {
        let options = LearnOptions { labels: 5_000, seconds: None, ..LearnOptions::default() };
        let scene = builtin::scene("planar-arm").unwrap();
        let model = Model::learn(scene, &options).unwrap();
        let (metric, space) = (model.metric(), &model.scene().space);
        let (x, nv): (Vec<f64>, usize) = (vec![0.0; space.nq()], space.nv());
        let at = |steps: [f64; 2]| -> Vec<f64> {
            let (mut step, mut q): (Vec<f64>, Vec<f64>) = (vec![0.0; nv], x.clone());
            step[..2].copy_from_slice(&steps);
            space.integrate(&x, &step, &mut q);
            q
        };
        // Toward the query along the first coordinate, a plane ends the way after 0.3 of 1.
        let mut tangents = ContactPlanes::new(nv);
        let mut toward = vec![0.0; nv];
        toward[0] = -1.0;
        tangents.push(0, 0.3, &toward);
        tangents.end_sample();
        let planes = tangents.planes(0);
        let (mut anchor, mut scratch) = (Anchor::default(), MetricScratch::default());
        metric.anchor(&at([1.0, 0.0]), &mut anchor);
        let distance = metric.distance_from(&anchor, &x, &mut scratch);
        let projection = metric.distance_from(&anchor, &at([0.3, 0.0]), &mut scratch);
        assert!(projection < 0.8 * distance);
        let mut subproblem = Subproblem::default();
        metric.quadratic_model(&anchor, &x, &[], &mut subproblem.quadratic);
        let mut is_of_no_use = |incumbent: f64, end: Option<&[f64]>| {
            let mut ends = Ends::default();
            ends.reset(space.nq());
            end.iter().for_each(|end| ends.push(end));
            let pruning = Pruning { incumbent, factor: 1.2, ends: &ends };
            subproblem.projection_is_of_no_use(space, &x, planes, distance, &pruning)
        };
        assert!(!is_of_no_use(1e9, None));
        assert!(!is_of_no_use(projection / 1.19, None) && is_of_no_use(projection / 1.21, None));
        for off in [-1.0, 1.0] {
            let end = |share: f64| at([0.3, off * share * SAME_END * projection]);
            assert!(is_of_no_use(projection, Some(&end(0.9))) && !is_of_no_use(projection, Some(&end(1.1))));
        }
    }

    #[test]
    fn what_a_descent_may_lead_to_comes_down_to_the_incumbent() {
        let ends = Ends::default();
        let pruning = Pruning { incumbent: 0.5, factor: 2.0, ends: &ends };
        let limits: Vec<f64> = (0..60).map(|iteration| pruning.limit(iteration)).collect();
        assert!(limits[0] == 1.0 && limits[1] == 0.75 && limits.is_sorted_by(|a, b| a >= b) && limits[59] == 0.5);
    }
}

//! Projection of configurations onto those that keep the links.

use super::{KeptRows, LinkConstraint};
use crate::cspace::Manifold;
use crate::kinematics::{Twists, forward};
use crate::math::Pose;
use crate::math::linear_algebra::{cholesky, cholesky_solve, dot};
use crate::scene::Scene;

/// Most Newton steps of a projection. With 30, queries find the same in half as much time again.
const MAX_STEPS: usize = 15;
/// No coordinate moves farther in one step \[rad or m\]: offsets are far from linear beyond.
const MAX_STEP: f64 = 0.5;
/// A projection ends once each offset is within this share of its tolerance.
const DONE_SHARE: f64 = 0.95;
/// Share of each diagonal entry that is added to it, so that steps stay finite at singularities.
const DAMPING_SHARE: f64 = 1e-9;

/// Memory of projections.
#[derive(Default)]
pub struct Projection {
    poses: Vec<Pose>,
    twists: Twists,
    rows: KeptRows,
    /// Inverse weights of the coordinates that may move; 0 for others.
    inverse: Vec<f64>,
    lifted: Vec<f64>,
    gram: Vec<f64>,
    wanted: Vec<f64>,
    step: Vec<f64>,
    moved: Vec<f64>,
}

impl Projection {
    /// Returns whether every kept link is within its tolerances at `q`.
    pub fn keeps(&mut self, scene: &Scene, kept: &[LinkConstraint], q: &[f64]) -> bool {
        self.excess(scene, kept, q) <= 1.0
    }

    /// Moves `q` to a configuration nearby, within the limits, that keeps the links, by Newton's
    /// method. Coordinates that `locked` marks stay, if it is not empty. Returns whether there is
    /// one; if not, `q` is anywhere.
    pub fn project(&mut self, scene: &Scene, kept: &[LinkConstraint], locked: &[bool], q: &mut Vec<f64>) -> bool {
        for _ in 0..MAX_STEPS {
            if self.excess(scene, kept, q) <= DONE_SHARE {
                return true;
            }
            self.twists.set(scene, &self.poses);
            self.rows.set(scene, kept, &self.poses, &self.twists);
            self.set_step(scene, locked, q);
            let longest = self.step.iter().fold(0.0_f64, |longest, s| longest.max(s.abs()));
            // If no joint can move a link, the step is zero, or not a number.
            if longest == 0.0 || self.step.iter().any(|s| !s.is_finite()) {
                return false;
            }
            let scale = if longest > MAX_STEP { MAX_STEP / longest } else { 1.0 };
            self.step.iter_mut().for_each(|s| *s *= scale);
            self.moved.resize(q.len(), 0.0);
            scene.space.integrate(q, &self.step, &mut self.moved);
            scene.space.clamp(&mut self.moved);
            std::mem::swap(q, &mut self.moved);
        }
        self.excess(scene, kept, q) <= DONE_SHARE
    }

    /// Returns the largest offset as a multiple of its tolerance.
    fn excess(&mut self, scene: &Scene, kept: &[LinkConstraint], q: &[f64]) -> f64 {
        forward(scene, q, &mut self.poses);
        kept.iter().map(|link| link.excess(&self.poses)).fold(0.0, f64::max)
    }

    /// Sets the shortest step that brings all linearised offsets within what is allowed. A
    /// coordinate that would leave its limits stays.
    fn set_step(&mut self, scene: &Scene, locked: &[bool], q: &[f64]) {
        let space = &scene.space;
        let (nv, count) = (space.nv(), self.rows.offsets.len());
        self.inverse.clear();
        self.inverse.resize(nv, 0.0);
        for factor in space.factors() {
            factor.tangents().for_each(|v| {
                if locked.get(v) != Some(&true) {
                    self.inverse[v] = 1.0 / factor.weight;
                }
            });
        }
        loop {
            self.lifted.clear();
            self.gram.clear();
            for row in self.rows.rows.chunks_exact(nv) {
                self.lifted.extend(row.iter().zip(&self.inverse).map(|(a, w)| a * w));
            }
            for (i, row) in self.rows.rows.chunks_exact(nv).enumerate() {
                self.gram.extend(self.lifted.chunks_exact(nv).map(|lifted| dot(row, lifted)));
                self.gram[i * count + i] *= 1.0 + DAMPING_SHARE;
            }
            cholesky(&mut self.gram, count);
            self.wanted.clear();
            self.wanted.extend(self.rows.changes());
            cholesky_solve(&self.gram, count, &mut self.wanted);
            self.step.clear();
            self.step.resize(nv, 0.0);
            for (lifted, wanted) in self.lifted.chunks_exact(nv).zip(&self.wanted) {
                self.step.iter_mut().zip(lifted).for_each(|(s, l)| *s += wanted * l);
            }
            let leaves = |factor: &&crate::cspace::Factor| match factor.manifold {
                Manifold::Interval { lower, upper } => {
                    let (x, s) = (q[factor.q], self.step[factor.v]);
                    x <= lower && s < 0.0 || x >= upper && s > 0.0
                }
                Manifold::Circle | Manifold::Rotation => false,
            };
            let mut was_free = false;
            let out: Vec<usize> = space.factors().iter().filter(leaves).map(|factor| factor.v).collect();
            for v in out {
                was_free |= self.inverse[v] > 0.0;
                self.inverse[v] = 0.0;
            }
            if !was_free {
                return;
            }
        }
    }
}

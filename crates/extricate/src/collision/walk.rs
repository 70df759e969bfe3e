//! Labels of configurations near each other, as along a trajectory: pairs that were proved apart stay so while little has moved.
//! The neighbour list of molecular dynamics (L. Verlet, 1967, doi:10.1103/PhysRev.159.98), with the motion of bodies for that of atoms.

use super::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::math::{Pose, Vec3};

/// Steps of the last length that a list is made to last for.
const STEPS: f64 = 8.0;
/// Skins are between these \[m\]: below, rounding would matter; above, too many pairs are near.
const LEAST_SKIN: f64 = 1e-6;
const MOST_SKIN: f64 = 0.02;
/// What the motion of a body is overestimated by, for rounding \[m\].
const ROUNDING: f64 = 1e-9;

/// A place, and the pairs that may collide near it.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Where the frames were.
    poses: Vec<Pose>,
    /// Pairs that are not proved to be farther apart there than clearance and skin.
    near: Vec<u32>,
    /// \[m\]
    skin: f64,
    /// How far points of bodies were from there at the configuration before, at most \[m\].
    before: f64,
}

impl Neighbours {
    /// Forgets the place.
    pub fn forget(&mut self) {
        self.poses.clear();
    }
}

impl Checker {
    /// As [`Checker::label`], for a configuration near those asked for before with the same `scratch`: pairs of bodies that were
    /// farther apart than all points can have moved since are not looked at. Where the last ones were far away it costs a
    /// little more.
    ///
    /// ```
    /// use extricate::{Checker, scene::builtin};
    /// let checker = Checker::new(builtin::scene("planar-arm")?.into());
    /// let (mut scratch, mut other) = Default::default();
    /// for step in 0..100 {
    ///     let q = [0.01 * step as f64, 0.2, -0.1];
    ///     assert_eq!(checker.label_along(&q, &mut scratch), checker.label(&q, &mut other));
    /// }
    /// # extricate::Result::Ok(())
    /// ```
    pub fn label_along(&self, q: &[f64], scratch: &mut CheckScratch) -> Label {
        self.place(q, scratch);
        if self.recent_collides(scratch) {
            return Label::Colliding;
        }
        let most = self.motion(scratch);
        // Two bodies may have moved toward each other.
        if 2.0 * most > scratch.neighbours.skin {
            let step = (most - scratch.neighbours.before).abs();
            if 2.0 * step > MOST_SKIN {
                // No trajectory.
                self.remember_place(scratch, 0.0);
                self.find_near(self.scene.clearance, scratch);
                return self.label_found(scratch);
            }
            self.remember_place(scratch, (2.0 * STEPS * step).clamp(LEAST_SKIN, MOST_SKIN));
            let farther = self.scene.clearance + scratch.neighbours.skin;
            self.find_near(farther, scratch);
            let mut near = std::mem::take(&mut scratch.neighbours.near);
            near.clear();
            near.extend_from_slice(&scratch.broad.pairs);
            near.retain(|&pair| self.pair_nearer(pair as usize, farther, scratch));
            scratch.neighbours.near = near;
        } else {
            scratch.neighbours.before = most;
        }
        scratch.broad.pairs.clear();
        for at in 0..scratch.neighbours.near.len() {
            let pair = scratch.neighbours.near[at];
            if self.balls_near(pair as usize, scratch) {
                scratch.broad.pairs.push(pair);
            }
        }
        self.label_found(scratch)
    }

    /// Bounds how far any point of a moving body is from its place; infinite where there is none.
    fn motion(&self, scratch: &mut CheckScratch) -> f64 {
        let (neighbours, placement) = (&mut scratch.neighbours, &scratch.placement);
        if neighbours.poses.is_empty() {
            return f64::INFINITY;
        }
        let each = self.broad.movers().map(|body| {
            let body = &self.bodies.bodies[body];
            let (now, then) = (&placement.poses[body.frame], &neighbours.poses[body.frame]);
            let (center, radius): (Vec3, f64) = body.ball;
            (now.point(&center) - then.point(&center)).norm() + (now.rotation - then.rotation).norm() * radius.max(0.0)
        });
        each.fold(0.0, f64::max) + ROUNDING
    }

    fn remember_place(&self, scratch: &mut CheckScratch, skin: f64) {
        let (neighbours, placement) = (&mut scratch.neighbours, &scratch.placement);
        neighbours.poses.clone_from(&placement.poses);
        (neighbours.skin, neighbours.before) = (skin, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;
    use rand::{RngExt, SeedableRng};

    /// A configuration within a millionth of others of the other label, if two random ones in a row differ.
    fn on_boundary(checker: &Checker, halton: &Halton, index: u64, scratch: &mut CheckScratch) -> Vec<f64> {
        let space = &checker.scene().space;
        let (mut a, mut b) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
        halton.config(space, index, &mut a);
        halton.config(space, index + 1, &mut b);
        let (label, mut step, mut middle) = (checker.label(&a, scratch), vec![0.0; space.nv()], a.clone());
        for _ in 0..20 {
            space.difference(&a, &b, &mut step);
            step.iter_mut().for_each(|s| *s *= 0.5);
            space.integrate(&a, &step, &mut middle);
            let end = if checker.label(&middle, scratch) == label { &mut a } else { &mut b };
            end.copy_from_slice(&middle);
        }
        a
    }

    #[test]
    fn labels_along_a_walk_are_those_of_its_configurations() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut changes = 0;
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let space = &checker.scene().space;
            let (mut scratch, mut other) = (CheckScratch::default(), CheckScratch::default());
            let (mut q, mut next) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
            let mut last = Label::Free;
            for round in 0..3000 {
                // Jumps to the boundary, and steps between a micrometre and a centimetre from there.
                if round % 50 == 0 {
                    q = on_boundary(&checker, &Halton::new(space.nv(), 8), round, &mut other);
                }
                let length = 10.0_f64.powf(-6.0 + 5.0 * ((round / 100) as f64 / 5.0 % 1.0));
                let step: Vec<f64> = (0..space.nv()).map(|_| length * (rng.random::<f64>() - 0.45)).collect();
                space.integrate(&q, &step, &mut next);
                std::mem::swap(&mut q, &mut next);
                let label = checker.label_along(&q, &mut scratch);
                assert_eq!(label, checker.label(&q, &mut other), "{name}, {round}");
                changes += usize::from(label != last);
                last = label;
            }
        }
        assert!(changes > 100, "{changes} changes of the label");
    }

    #[test]
    fn short_steps_leave_most_pairs_alone() {
        let checker = Checker::new(builtin::scene("shelf-arm").unwrap().into());
        let space = &checker.scene().space;
        let (mut scratch, mut q) = (CheckScratch::default(), vec![0.0; space.nq()]);
        let (mut lists, mut near, mut found) = (0, 0, 0);
        for start in 0..20 {
            Halton::new(space.nv(), 3).config(space, start, &mut q);
            for _ in 0..200 {
                q.iter_mut().for_each(|x| *x += 1e-4);
                checker.label_along(&q, &mut scratch);
                lists += usize::from(scratch.neighbours.before == 0.0);
                near += scratch.neighbours.near.len();
                checker.find_near(checker.scene().clearance, &mut scratch);
                found += scratch.broad.pairs.len();
            }
        }
        assert!(lists < 20 * 200 / 8, "{lists} lists");
        assert!(2 * near < found, "{near} near pairs of {found} whose balls are near");
    }
}

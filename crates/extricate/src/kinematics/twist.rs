//! How every joint moves what it carries, at one configuration. Gradients of many points and sums
//! over whole bodies are made of these twists.

use crate::math::{Pose, Vec3};
use crate::scene::{Motion, Scene};

/// Velocity of a carried body when one tangent coordinate runs at rate 1: a point `p` of the world
/// moves by `slide + turn x p`.
#[derive(Debug, Clone, Copy)]
pub struct Twist {
    /// Index of the tangent coordinate.
    pub v: usize,
    /// Angular velocity \[rad per rad or m\].
    pub turn: Vec3,
    /// Velocity at the world's origin \[m per rad or m\].
    pub slide: Vec3,
}

/// A force and its moment about the world's origin, in the caller's units.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wrench {
    /// Force in world coordinates.
    pub force: Vec3,
    /// Moment about the world's origin.
    pub moment: Vec3,
}

/// The twists of all frames' own joints. A frame is moved by those on the chain from it to the
/// world.
#[derive(Debug, Clone, Default)]
pub struct Twists {
    all: Vec<Twist>,
    /// Index of the first twist of each frame, and the end of the last frame's twists.
    starts: Vec<usize>,
}

impl Twist {
    /// Returns the power of the wrench at this velocity: for a unit force at a point, the speed of
    /// the point along it.
    pub fn power(&self, wrench: &Wrench) -> f64 {
        self.turn.dot(&wrench.moment) + self.slide.dot(&wrench.force)
    }
}

impl Wrench {
    /// Makes the wrench of a force at a point of the world.
    pub fn at(point: &Vec3, force: Vec3) -> Self {
        Self { force, moment: point.cross(&force) }
    }
}

impl std::ops::AddAssign<&Self> for Wrench {
    fn add_assign(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
    }
}

impl Twists {
    /// Computes the twists at the configuration whose frame poses are `poses`.
    pub fn set(&mut self, scene: &Scene, poses: &[Pose]) {
        self.all.clear();
        self.starts.clear();
        for (frame, pose) in scene.frames.iter().zip(poses) {
            self.starts.push(self.all.len());
            let origin = &pose.translation;
            let about = |v: usize, turn: Vec3| Twist { v, turn, slide: origin.cross(&turn) };
            match &frame.motion {
                Motion::World => {}
                Motion::Revolute { axis, coordinate } => {
                    self.all.push(about(coordinate.v, pose.vector(axis) * coordinate.multiplier));
                }
                Motion::Prismatic { axis, coordinate } => {
                    let slide = pose.vector(axis) * coordinate.multiplier;
                    self.all.push(Twist { v: coordinate.v, turn: Vec3::zeros(), slide });
                }
                Motion::Ball { v, .. } => {
                    self.all.extend((0..3).map(|k| about(v + k, pose.rotation.column(k).into_owned())));
                }
            }
        }
        self.starts.push(self.all.len());
    }

    /// Returns the twists of the joint that moves `frame` relative to its parent.
    pub fn of(&self, frame: usize) -> &[Twist] {
        &self.all[self.starts[frame]..self.starts[frame + 1]]
    }

    /// Adds the power of `wrench` on a body fixed to `frame`, for each tangent coordinate, to
    /// `gradient` (length `nv` or more).
    pub fn add_power(&self, scene: &Scene, mut frame: usize, wrench: &Wrench, gradient: &mut [f64]) {
        while frame != 0 {
            for twist in self.of(frame) {
                gradient[twist.v] += twist.power(wrench);
            }
            frame = scene.frames[frame].parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::kinematics::{add_point_gradient, forward};
    use crate::scene::builtin;

    #[test]
    fn powers_are_the_gradients_of_points() {
        for name in builtin::NAMES {
            let scene = builtin::scene(name).unwrap();
            let space = &scene.space;
            let (halton, mut q, mut poses) = (Halton::new(space.nv(), 1), vec![0.0; space.nq()], Vec::new());
            let mut twists = Twists::default();
            let (mut slow, mut fast) = (vec![0.0; space.nv()], vec![0.0; space.nv()]);
            for k in 0..20 {
                halton.config(space, k, &mut q);
                forward(&scene, &q, &mut poses);
                twists.set(&scene, &poses);
                for frame in 0..scene.frames.len() {
                    let (point, force) = (poses[frame].point(&Vec3::new(0.1, -0.2, 0.3)), Vec3::new(0.5, 1.0, -2.0));
                    slow.fill(0.0);
                    fast.fill(0.0);
                    add_point_gradient(&scene, &poses, frame, &point, &force, 1.0, &mut slow);
                    twists.add_power(&scene, frame, &Wrench::at(&point, force), &mut fast);
                    let off = slow.iter().zip(&fast).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-13, "{name} {frame}: {off}");
                }
            }
        }
    }
}

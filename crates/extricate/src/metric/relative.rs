//! Poses of one body of a checked pair relative to the other, as numbers for a kernel: what alone
//! decides whether the two collide.

use std::sync::Arc;

use super::MetricScratch;
use crate::kinematics::forward;
use crate::math::{Mat3, Pose, Vec3};
use crate::robot::mesh::moments::Moments;
use crate::scene::{Body, Part, Scene};

/// Numbers a relative pose.
pub const WIDTH: usize = 12;

/// Every checked pair of a scene with what its relative poses are measured by.
///
/// The Euclidean distance between the numbers of two configurations is the root mean square
/// displacement \[m\] of one body as seen from the other. An obstacle is always the one that is
/// seen from: so where it moves, the numbers mean what they meant before.
#[derive(Debug, Clone)]
pub struct RelativePoses {
    scene: Arc<Scene>,
    pairs: Vec<RelativePair>,
}

#[derive(Debug, Clone)]
struct RelativePair {
    /// Frame of the body that the other one is seen from, and the pose of its first part there.
    frame: usize,
    pose_frame_reference: Pose,
    /// Frame of the other body, with its centroid there.
    moved: usize,
    centroid: Vec3,
    /// `root root' = ` second moment about the centroid divided by the volume \[m\].
    root: Mat3,
}

impl RelativePoses {
    /// Of all checked pairs of `scene`.
    pub fn new(scene: Arc<Scene>) -> Self {
        let of = |pair: &crate::scene::BodyPair| {
            let (first, second) = (&scene.bodies[pair.first], &scene.bodies[pair.second]);
            let (seen_from, moved) = if second.frame == 0 { (second, first) } else { (first, second) };
            let (centroid, root) = spread(moved);
            let pose_frame_reference = seen_from.parts.first().map_or_else(Pose::identity, |part| part.pose_frame_part);
            RelativePair { frame: seen_from.frame, pose_frame_reference, moved: moved.frame, centroid, root }
        };
        let pairs = scene.pairs.iter().map(of).collect();
        Self { scene, pairs }
    }

    /// Appends the numbers of each of `pairs` (indices into [`Scene::pairs`]) at `q`: centroid and
    /// three arms of the one body in the axes of the other.
    pub fn embed(&self, q: &[f64], pairs: &[u32], scratch: &mut MetricScratch, out: &mut Vec<f64>) {
        forward(&self.scene, q, &mut scratch.poses);
        for pair in pairs {
            let pair = &self.pairs[*pair as usize];
            let reference = scratch.poses[pair.frame].then(&pair.pose_frame_reference);
            let moved = &scratch.poses[pair.moved];
            out.extend_from_slice(reference.inverse_point(&moved.point(&pair.centroid)).as_slice());
            out.extend_from_slice(reference.rotation.tr_mul(&(moved.rotation * pair.root)).as_slice());
        }
    }
}

/// Centroid of a body and root of its second moment, in its frame: of the volume if every part has
/// one, otherwise of the surface.
fn spread(body: &Body) -> (Vec3, Mat3) {
    let solid = body.parts.iter().all(|part| part.geometry.volume_moments().is_some());
    let moments = |part: &Part| {
        let local = match part.geometry.volume_moments() {
            Some(volume) if solid => volume,
            _ => part.geometry.area_moments(),
        };
        local.transformed(&part.pose_frame_part)
    };
    let Some(sum) = Moments::combine(body.parts.iter().map(moments)) else { return (Vec3::zeros(), Mat3::zeros()) };
    let eigen = sum.second_moment.symmetric_eigen();
    (sum.centroid, eigen.eigenvectors * Mat3::from_diagonal(&eigen.eigenvalues.map(|x| x.max(0.0).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;

    fn numbers(scene: &Arc<Scene>, pair: u32, q: &[f64]) -> Vec<f64> {
        let mut out = Vec::new();
        RelativePoses::new(scene.clone()).embed(q, &[pair], &mut MetricScratch::default(), &mut out);
        out
    }

    fn configs(scene: &Scene, count: u64) -> Vec<Vec<f64>> {
        let halton = Halton::new(scene.space.nv(), 1);
        let config = |i| {
            let mut q = vec![0.0; scene.space.nq()];
            halton.config(&scene.space, i, &mut q);
            q
        };
        (0..count).map(config).collect()
    }

    #[test]
    fn an_obstacle_that_moves_with_all_else_changes_nothing() {
        let scene = Arc::new(builtin::scene("shelf-arm").unwrap());
        let by = Pose::from_xyz_rpy([0.3, -0.2, 0.5], [0.4, 1.0, -2.0]);
        let mut moved = (*scene).clone();
        for body in moved.bodies.iter_mut().filter(|body| body.frame == 0) {
            body.parts.iter_mut().for_each(|part| part.pose_frame_part = by.then(&part.pose_frame_part));
        }
        for frame in moved.frames.iter_mut().skip(1).filter(|frame| frame.parent == 0) {
            frame.pose_parent_joint = by.then(&frame.pose_parent_joint);
        }
        let moved = Arc::new(moved);
        for q in configs(&scene, 20) {
            for pair in 0..scene.pairs.len() as u32 {
                let (before, after) = (numbers(&scene, pair, &q), numbers(&moved, pair, &q));
                assert_eq!(before.len(), WIDTH);
                assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-9), "{pair}: {before:?} {after:?}");
            }
        }
    }

    /// A self-collision depends on the joints between the two bodies alone, and so do its numbers.
    #[test]
    fn joints_before_both_bodies_change_nothing() {
        let scene = Arc::new(builtin::scene("shelf-arm").unwrap());
        let moving =
            |pair: &crate::scene::BodyPair| scene.bodies[pair.first].frame * scene.bodies[pair.second].frame != 0;
        let pair = scene.pairs.iter().position(moving).unwrap() as u32;
        let (mut same, mut changed) = (configs(&scene, 1).remove(0), configs(&scene, 1).remove(0));
        let before = numbers(&scene, pair, &same);
        same[0] += 0.5;
        let last = changed.len() - 1;
        changed.iter_mut().take(last).for_each(|x| *x += 0.1);
        let difference =
            |q: &[f64]| before.iter().zip(numbers(&scene, pair, q)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference(&same) < 1e-12 && difference(&changed) > 1e-3);
    }
}

//! Poses of one body of a checked pair relative to the other, as numbers for a kernel. Only the
//! relative pose decides whether the two collide.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::MetricScratch;
use crate::kinematics::forward;
use crate::math::{Mat3, Pose, Vec3};
use crate::robot::mesh::moments::Moments;
use crate::scene::{Body, BodyPair, PairId, Part, Scene};

/// Number of coordinates of a relative pose.
pub const WIDTH: usize = 12;
/// A body that is checked against more fixed bodies than this has one classifier for all of them.
/// With one for each of 300 small boxes, learning took 36 times as long as with one mesh of the
/// same shape, and answers were as good. See also lab L109.
const MAX_SEPARATE_FIXED_BODIES: usize = 16;

/// Relative poses of every checked pair of a scene, as vectors of numbers.
///
/// The Euclidean distance between the numbers of two configurations is the root mean square
/// displacement \[m\] of one body as seen from the other, the reference. An obstacle is always the
/// reference, so that the numbers keep their meaning if it is placed elsewhere. If a body is
/// checked against many fixed bodies, the world is the reference: the body's pose in it decides
/// about all.
#[derive(Debug, Clone)]
pub struct RelativePoses {
    scene: Arc<Scene>,
    pairs: Vec<RelativePair>,
    parts: Vec<LearnedAs>,
}

/// Group of checked pairs that share one classifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LearnedAs {
    /// First pair of the group, an index into [`Scene::pairs`].
    pub first: u32,
    /// Whether the group holds the pairs of one body with many fixed bodies.
    pub is_shared: bool,
}

#[derive(Debug, Clone)]
struct RelativePair {
    frame: usize,
    /// Pose of the reference's first part in `frame`; the identity if the group is shared.
    pose_frame_reference: Pose,
    /// Frame of the other body. `centroid` and `root` are in its coordinates.
    moved: usize,
    centroid: Vec3,
    /// `root root' = ` second moment about the centroid divided by the volume (or area) \[m\].
    root: Mat3,
}

impl RelativePoses {
    /// Prepares all checked pairs of `scene`.
    pub fn new(scene: Arc<Scene>) -> Self {
        let parts = parts(&scene);
        let spreads: Vec<(Vec3, Mat3)> = scene.bodies.iter().map(spread).collect();
        let of = |(pair, part): (&BodyPair, &LearnedAs)| {
            let [seen_from, moved] = seen(&scene, pair).map(|body| &scene.bodies[body]);
            let (centroid, root) = spreads[seen(&scene, pair)[1]];
            let own = seen_from.parts.first().filter(|_| !part.is_shared);
            let pose_frame_reference = own.map_or_else(Pose::identity, |part| part.pose_frame_part);
            RelativePair { frame: seen_from.frame, pose_frame_reference, moved: moved.frame, centroid, root }
        };
        let pairs = scene.pairs.iter().zip(&parts).map(of).collect();
        Self { scene, pairs, parts }
    }

    /// Returns the scene of the pairs.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the group of a checked pair.
    pub fn part(&self, pair: PairId) -> LearnedAs {
        self.parts[pair.index()]
    }

    /// Appends the numbers of each of `pairs` (indices into [`Scene::pairs`]) at `q`: centroid and
    /// three arms of the body in the axes of the reference.
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

/// Returns the two bodies of a pair, the reference first.
fn seen(scene: &Scene, pair: &BodyPair) -> [usize; 2] {
    if scene.bodies[pair.second].frame == 0 { [pair.second, pair.first] } else { [pair.first, pair.second] }
}

/// Returns the group of each checked pair.
fn parts(scene: &Scene) -> Vec<LearnedAs> {
    let mut with_fixed: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, pair) in scene.pairs.iter().enumerate() {
        let [seen_from, moved] = seen(scene, pair);
        if scene.bodies[seen_from].frame == 0 {
            with_fixed.entry(moved).or_default().push(index);
        }
    }
    let alone = |pair| LearnedAs { first: pair, is_shared: false };
    let mut parts: Vec<LearnedAs> = (0..scene.pairs.len() as u32).map(alone).collect();
    for pairs in with_fixed.values().filter(|pairs| pairs.len() > MAX_SEPARATE_FIXED_BODIES) {
        let shared = LearnedAs { first: pairs[0] as u32, is_shared: true };
        pairs.iter().for_each(|pair| parts[*pair] = shared);
    }
    parts
}

/// Returns the centroid and the root of the second moment of a body, in its frame: of the volume if
/// every part has one, otherwise of the surface.
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

    /// Each link has one group for a wall of many boxes, with the world as its reference.
    #[test]
    fn many_that_never_move_are_one_part() {
        let mut scene = builtin::scene("planar-arm").unwrap();
        let few = RelativePoses::new(Arc::new(scene.clone()));
        assert!(few.parts.iter().enumerate().all(|(pair, part)| pair == part.first as usize && !part.is_shared));
        let fixed = scene.bodies.iter().position(|body| body.frame == 0).unwrap();
        let own: Vec<BodyPair> = scene.pairs.iter().filter(|pair| pair.second == fixed).copied().collect();
        let links: std::collections::BTreeSet<usize> = own.iter().map(|pair| pair.first).collect();
        for k in 0..2 * MAX_SEPARATE_FIXED_BODIES {
            let body = Body { name: format!("box {k}"), ..scene.bodies[fixed].clone() };
            scene.bodies.push(body);
            let second = scene.bodies.len() - 1;
            scene.pairs.extend(own.iter().map(|pair| BodyPair { second, ..*pair }));
        }
        let scene = Arc::new(scene);
        let many = RelativePoses::new(scene.clone());
        let parts = |body: usize| -> std::collections::BTreeSet<u32> {
            let of_body = scene.pairs.iter().zip(&many.parts).filter(|(pair, _)| pair.first == body);
            of_body.filter(|(pair, _)| scene.bodies[pair.second].frame == 0).map(|(_, part)| part.first).collect()
        };
        assert!(!links.is_empty());
        for link in links {
            assert_eq!(parts(link).len(), 1, "{link}");
        }
        let q = configs(&scene, 1).remove(0);
        for (pair, part) in many.parts.iter().enumerate() {
            assert_eq!(numbers(&scene, pair as u32, &q), numbers(&scene, part.first, &q), "{pair} {part:?}");
        }
    }

    /// The numbers of a self-collision depend only on the joints between its two bodies.
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

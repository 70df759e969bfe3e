//! Forward kinematics of a block of configurations: one register holds the same number of several
//! configurations.

use pulp::{Simd, WithSimd};

use super::joint::{Joint, Numbers, image, joint_pose};
use super::{from_numbers, sine};
use crate::math::{Pose, Vec3};
use crate::scene::{Motion, Scene};

/// Number of configurations in a block.
pub const LANES: usize = 8;

type Lanes = [f64; LANES];

/// World poses of all frames at up to [`LANES`] configurations.
///
/// # Guarantee
/// [`PoseBlock::pose`] equals the result of [`super::forward`] there, to the last bit.
#[derive(Debug, Clone, Default)]
pub struct PoseBlock {
    /// Columns of the rotation, then the translation, of every frame.
    frames: Vec<[Lanes; 12]>,
    /// The coordinates of the configurations, transposed.
    coordinates: Vec<Lanes>,
}

impl PoseBlock {
    /// Moves the block to 1 to [`LANES`] configurations (row major, `nq` coordinates each); lanes
    /// beyond the last repeat it.
    pub fn place(&mut self, scene: &Scene, configs: &[f64]) {
        let nq = scene.space.nq();
        let last = configs.len() / nq - 1;
        self.coordinates.clear();
        self.coordinates.extend((0..nq).map(|k| {
            let mut lanes = [0.0; LANES];
            for (lane, x) in lanes.iter_mut().enumerate() {
                *x = configs[lane.min(last) * nq + k];
            }
            lanes
        }));
        self.frames.resize(scene.frames.len(), [[0.0; LANES]; 12]);
        pulp::Arch::new().dispatch(PlaceFrames { scene, block: self });
    }

    /// Number of frames of the scene.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Returns the pose of a frame at one of the configurations.
    pub fn pose(&self, frame: usize, lane: usize) -> Pose {
        let numbers = &self.frames[frame];
        from_numbers(&std::array::from_fn(|k| numbers[k][lane]))
    }

    /// Writes world coordinates \[m\] x, y, z of points fixed to frames to `out`. They equal those
    /// of [`Pose::point`] to the last bit.
    pub fn points<'a>(&self, points: impl Iterator<Item = (usize, &'a Vec3)>, out: &mut Vec<[Lanes; 3]>) {
        out.clear();
        pulp::Arch::new().dispatch(PlacePoints { block: self, points, out });
    }
}

struct PlaceFrames<'a> {
    scene: &'a Scene,
    block: &'a mut PoseBlock,
}

impl WithSimd for PlaceFrames<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let PoseBlock { frames, coordinates } = self.block;
        for (index, frame) in self.scene.frames.iter().enumerate() {
            let scaled = |coordinate: &crate::scene::Coordinate| {
                let mut lanes = coordinates[coordinate.q];
                lanes.iter_mut().for_each(|x| *x = coordinate.multiplier * *x + coordinate.offset);
                lanes
            };
            let (before, rest) = frames.split_at_mut(index);
            let (first, second) = match &frame.motion {
                Motion::Revolute { coordinate, .. } => sine::sines_cosines(simd, &scaled(coordinate)),
                Motion::Prismatic { coordinate, .. } => (scaled(coordinate), [0.0; LANES]),
                Motion::World | Motion::Ball { .. } => ([0.0; LANES], [0.0; LANES]),
            };
            for half in 0..LANES / S::F64_LANES {
                let load = |lanes: &Lanes| S::as_simd_f64s(lanes).0[half];
                let parent = if frame.parent == 0 { None } else { Some(numbers(simd, &before[frame.parent], half)) };
                let joint = match &frame.motion {
                    Motion::World => Joint::Prismatic { axis: &Vec3::zeros(), length: load(&first) },
                    Motion::Revolute { axis, .. } => {
                        Joint::Revolute { axis, sine: load(&first), cosine: load(&second) }
                    }
                    Motion::Prismatic { axis, .. } => Joint::Prismatic { axis, length: load(&first) },
                    Motion::Ball { q, .. } => {
                        let [x, y, z, w] =
                            [&coordinates[*q], &coordinates[q + 1], &coordinates[q + 2], &coordinates[q + 3]];
                        Joint::Ball { quaternion: [load(x), load(y), load(z), load(w)] }
                    }
                };
                let pose = joint_pose(simd, parent.as_ref(), &frame.pose_parent_joint, joint);
                for (lanes, number) in rest[0].iter_mut().zip(pose) {
                    S::as_mut_simd_f64s(lanes).0[half] = number;
                }
            }
        }
    }
}

/// Loads one register of each number of a frame.
#[inline(always)]
fn numbers<S: Simd>(simd: S, frame: &[Lanes; 12], half: usize) -> Numbers<S> {
    let mut numbers = [simd.splat_f64s(0.0); 12];
    for (number, lanes) in numbers.iter_mut().zip(frame) {
        *number = S::as_simd_f64s(lanes).0[half];
    }
    numbers
}

struct PlacePoints<'a, I> {
    block: &'a PoseBlock,
    points: I,
    out: &'a mut Vec<[Lanes; 3]>,
}

impl<'a, I: Iterator<Item = (usize, &'a Vec3)>> WithSimd for PlacePoints<'_, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (frame, point) in self.points {
            let mut world = [[0.0; LANES]; 3];
            for half in 0..LANES / S::F64_LANES {
                let pose = numbers(simd, &self.block.frames[frame], half);
                let turned = image(simd, &pose, point);
                for r in 0..3 {
                    S::as_mut_simd_f64s(&mut world[r]).0[half] = simd.add_f64s(turned[r], pose[9 + r]);
                }
            }
            self.out.push(world);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::kinematics::forward;
    use crate::math::{axis_rotation, quaternion_matrix};
    use crate::scene::builtin;

    /// The slow twin: it multiplies one pose after the other.
    fn plain(scene: &Scene, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::new();
        for frame in &scene.frames {
            let at = |c: &crate::scene::Coordinate| c.multiplier * q[c.q] + c.offset;
            let motion = match &frame.motion {
                Motion::World => Pose::identity(),
                Motion::Revolute { axis, coordinate } => {
                    Pose { rotation: axis_rotation(axis, at(coordinate)), ..Pose::identity() }
                }
                Motion::Prismatic { axis, coordinate } => Pose::translation(axis * at(coordinate)),
                Motion::Ball { q: k, .. } => Pose { rotation: quaternion_matrix(&q[*k..k + 4]), ..Pose::identity() },
            };
            let parent = poses.get(frame.parent).copied().unwrap_or_default();
            poses.push(parent.then(&frame.pose_parent_joint).then(&motion));
        }
        poses
    }

    /// Makes a chain of every kind of joint, with slanted axes, a follower and an axis that points
    /// backward.
    fn every_joint() -> Scene {
        use crate::cspace::{ConfigSpace, Manifold};
        use crate::scene::{Coordinate, Frame};
        let mut scene = builtin::scene("planar-arm").unwrap();
        let mut space = ConfigSpace::default();
        let slanted = Vec3::new(1.0, -2.0, 0.5).normalize();
        let fixed = |k: usize| Pose::from_xyz_rpy([0.1, 0.2 * k as f64, 0.3], [0.4, 0.5, 0.6 * k as f64]);
        let limits = Manifold::Interval { lower: -2.0, upper: 2.0 };
        let mut one = |name: &str, manifold: Manifold| {
            let (q, v) = space.push(name, manifold, 1.0);
            Coordinate { q, v, multiplier: 1.0, offset: 0.0 }
        };
        let (a, b, c, d) = (one("a", limits), one("b", Manifold::Circle), one("c", limits), one("d", limits));
        let ball = one("ball", Manifold::Rotation);
        let follower = Coordinate { multiplier: -0.7, offset: 0.3, ..a };
        let motions = [
            Motion::World,
            Motion::Revolute { axis: Vec3::z(), coordinate: a },
            Motion::Revolute { axis: slanted, coordinate: b },
            Motion::Prismatic { axis: slanted, coordinate: c },
            Motion::Ball { q: ball.q, v: ball.v },
            Motion::Revolute { axis: -Vec3::y(), coordinate: d },
            Motion::Revolute { axis: Vec3::x(), coordinate: follower },
            Motion::Prismatic { axis: -Vec3::z(), coordinate: d },
            Motion::Revolute { axis: Vec3::y(), coordinate: c },
            Motion::Revolute { axis: -slanted, coordinate: follower },
        ];
        let parents = [0, 0, 1, 2, 3, 4, 2, 0, 7, 8];
        let frame = |(k, (motion, parent)): (usize, (Motion, usize))| {
            let pose_parent_joint = if k == 0 { Pose::identity() } else { fixed(k) };
            Frame { name: k.to_string(), parent, pose_parent_joint, motion }
        };
        scene.frames = motions.into_iter().zip(parents).enumerate().map(frame).collect();
        scene.space = space;
        scene
    }

    #[test]
    fn one_configuration_and_a_block_agree_to_the_last_bit_and_with_plain_products() {
        let mut scenes: Vec<Scene> = builtin::NAMES.iter().map(|name| builtin::scene(name).unwrap()).collect();
        scenes.push(every_joint());
        for scene in &scenes {
            let nq = scene.space.nq();
            let halton = Halton::new(scene.space.nv(), 5);
            let (mut block, mut poses, mut points) = (PoseBlock::default(), Vec::new(), Vec::new());
            let point = Vec3::new(0.1, -0.7, 0.3);
            for first in 0..100 {
                let count = first % LANES + 1;
                let mut configs = vec![0.0; count * nq];
                for (k, q) in configs.chunks_exact_mut(nq).enumerate() {
                    halton.config(&scene.space, (first * LANES + k) as u64, q);
                }
                block.place(scene, &configs);
                block.points((0..scene.frames.len()).map(|frame| (frame, &point)), &mut points);
                for (lane, q) in configs.chunks_exact(nq).enumerate() {
                    forward(scene, q, &mut poses);
                    for (frame, (pose, exact)) in poses.iter().zip(plain(scene, q)).enumerate() {
                        assert_eq!(block.pose(frame, lane), *pose);
                        assert_eq!(Vec3::from(points[frame].map(|x| x[lane])), pose.point(&point));
                        assert!((pose.rotation - exact.rotation).norm() < 1e-14, "{frame}");
                        assert!((pose.translation - exact.translation).norm() < 1e-14, "{frame}");
                    }
                }
            }
        }
    }
}

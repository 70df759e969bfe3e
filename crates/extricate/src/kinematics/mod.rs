//! Forward kinematics and point Jacobians: pure functions of a scene and a configuration.

mod block;
mod joint;
mod sine;
mod speed;
mod twist;

pub use block::{LANES, PoseBlock};
#[cfg(test)]
pub use gradient::add_point_gradient;
pub use speed::ball_speeds;
pub use twist::{Twist, Twists, Wrench};

use pulp::{Scalar, Simd, WithSimd};

use crate::math::{Pose, Vec3};
use crate::scene::{Motion, Scene};
use joint::{Joint, joint_pose};

/// Frames whose sines and cosines are computed together.
const CHUNK_FRAMES: usize = 8;

impl Scene {
    /// Writes the poses of all frames in the world at `q` (length `nq`) to `poses`.
    pub fn poses(&self, q: &[f64], poses: &mut Vec<Pose>) {
        forward(self, q, poses);
    }
}

/// Writes the world poses of all frames of `scene` at configuration `q` (length `nq`) to `poses`
/// (one per frame).
///
/// # Cost
/// About one and a half 3 x 3 products a frame; allocates only when `poses` grows.
pub fn forward(scene: &Scene, q: &[f64], poses: &mut Vec<Pose>) {
    pulp::Arch::new().dispatch(Forward { scene, q, poses });
}

struct Forward<'a> {
    scene: &'a Scene,
    q: &'a [f64],
    poses: &'a mut Vec<Pose>,
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { scene, q, poses } = self;
        poses.clear();
        for frames in scene.frames.chunks(CHUNK_FRAMES) {
            let mut angles = [0.0; CHUNK_FRAMES];
            for (frame, angle) in frames.iter().zip(&mut angles) {
                if let Motion::Revolute { coordinate, .. } = &frame.motion {
                    *angle = coordinate.multiplier * q[coordinate.q] + coordinate.offset;
                }
            }
            let (sines, cosines) = sine::sines_cosines(simd, &angles);
            for (k, frame) in frames.iter().enumerate() {
                let joint = match &frame.motion {
                    Motion::World => {
                        poses.push(Pose::identity());
                        continue;
                    }
                    Motion::Revolute { axis, .. } => Joint::Revolute { axis, sine: sines[k], cosine: cosines[k] },
                    Motion::Prismatic { axis, coordinate } => {
                        let length = coordinate.multiplier * q[coordinate.q] + coordinate.offset;
                        Joint::Prismatic { axis, length }
                    }
                    Motion::Ball { q: at, .. } => Joint::Ball { quaternion: [q[*at], q[at + 1], q[at + 2], q[at + 3]] },
                };
                let parent = (frame.parent != 0).then(|| numbers(&poses[frame.parent]));
                let pose = joint_pose(Scalar::new(), parent.as_ref(), &frame.pose_parent_joint, joint);
                poses.push(from_numbers(&pose));
            }
        }
    }
}

/// Returns the columns of the rotation, then the translation.
#[inline(always)]
fn numbers(pose: &Pose) -> [f64; 12] {
    let (r, t) = (pose.rotation.as_slice(), pose.translation.as_slice());
    std::array::from_fn(|k| if k < 9 { r[k] } else { t[k - 9] })
}

#[inline(always)]
fn from_numbers(numbers: &[f64; 12]) -> Pose {
    Pose {
        rotation: crate::math::Mat3::from_column_slice(&numbers[..9]),
        translation: Vec3::from_column_slice(&numbers[9..]),
    }
}

#[cfg(test)]
mod gradient;

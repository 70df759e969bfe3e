//! Forward kinematics and point Jacobians: pure functions of a scene and a configuration.

use crate::math::{Mat3, Pose, Vec3, axis_rotation, quaternion_matrix};
use crate::scene::{Motion, Scene};

/// World poses of all frames of `scene` at configuration `q` (length `nq`), into `poses` (one per frame).
///
/// # Cost
/// One 3 x 4 product and one sine and cosine a frame; allocates only when `poses` grows.
pub fn forward(scene: &Scene, q: &[f64], poses: &mut Vec<Pose>) {
    poses.clear();
    for frame in &scene.frames {
        let pose = match &frame.motion {
            Motion::World => Pose::identity(),
            Motion::Revolute { axis, coordinate } => {
                let angle = coordinate.multiplier * q[coordinate.q] + coordinate.offset;
                turned(&poses[frame.parent].then(&frame.pose_parent_joint), &axis_rotation(axis, angle))
            }
            Motion::Prismatic { axis, coordinate } => {
                let mut pose = poses[frame.parent].then(&frame.pose_parent_joint);
                pose.translation +=
                    pose.rotation * (axis * (coordinate.multiplier * q[coordinate.q] + coordinate.offset));
                pose
            }
            Motion::Ball { q: at, .. } => {
                turned(&poses[frame.parent].then(&frame.pose_parent_joint), &quaternion_matrix(&q[*at..at + 4]))
            }
        };
        poses.push(pose);
    }
}

fn turned(pose: &Pose, rotation: &Mat3) -> Pose {
    Pose { rotation: pose.rotation * rotation, translation: pose.translation }
}

/// Adds `scale` times the gradient of `direction . point_world` over the tangent coordinates to `gradient` (length `nv`),
/// where the point is fixed to `frame`.
///
/// Units: metres per rad or m. Ball joints use the body-frame rotation vector (`q' = q exp(v)`).
pub fn add_point_gradient(
    scene: &Scene,
    poses: &[Pose],
    mut frame: usize,
    point_world: &Vec3,
    direction: &Vec3,
    scale: f64,
    gradient: &mut [f64],
) {
    while frame != 0 {
        let pose = &poses[frame];
        match &scene.frames[frame].motion {
            Motion::World => {}
            Motion::Revolute { axis, coordinate } => {
                let arm = point_world - pose.translation;
                gradient[coordinate.v] += scale * coordinate.multiplier * direction.dot(&pose.vector(axis).cross(&arm));
            }
            Motion::Prismatic { axis, coordinate } => {
                gradient[coordinate.v] += scale * coordinate.multiplier * direction.dot(&pose.vector(axis));
            }
            Motion::Ball { v, .. } => {
                let moment = pose.inverse_vector(&(point_world - pose.translation).cross(direction));
                for k in 0..3 {
                    gradient[v + k] += scale * moment[k];
                }
            }
        }
        frame = scene.frames[frame].parent;
    }
}

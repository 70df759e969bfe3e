//! Gradients of points that move with a frame, joint by joint: the slow twin of [`super::Twists`],
//! for tests.

use crate::math::{Pose, Vec3};
use crate::scene::{Motion, Scene};

/// Adds `scale` times the gradient of `direction . point_world` over the tangent coordinates to
/// `gradient` (length `nv`); the point is fixed to `frame`.
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

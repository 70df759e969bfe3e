//! Computes a bound for translations without limits, by which any body can leave any other.

use super::bodies::{OncePerMesh, radius};
use super::loaded::LoadedRobot;
use crate::math::Pose;
use crate::robot::{Geometry, JointKind};
use crate::scene::Body;
use crate::scene::file::limits::LimitsEntry;

/// Returns twice the radius \[m\] of a ball about the world's origin, rounded up to 0.1 m. The ball
/// contains all geometry in every configuration, apart from the travel of joints without limits.
///
/// The radius is a bound, not the least one: it adds the lengths of all joint origins and travels,
/// and the radii of all shapes. A subtree that moves by twice this radius along any axis has left
/// everything that does not move with it. Half-spaces and height fields count with the distance of
/// their surfaces, so that it leaves them on one side only.
pub fn reach(robots: &[LoadedRobot], obstacles: &[Body]) -> f64 {
    let mut known = OncePerMesh::default();
    let mut shape = |pose: &Pose, geometry: &Geometry| pose.translation.norm() + known.of(geometry, radius);
    let of_obstacles: f64 =
        obstacles.iter().flat_map(|body| &body.parts).map(|part| shape(&part.pose_frame_part, &part.geometry)).sum();
    let of_robots: f64 = robots
        .iter()
        .map(|loaded| {
            let base: f64 = loaded.entry.pose.xyz.iter().map(|x| x.abs()).sum();
            let travel: f64 =
                loaded.entry.bounds.iter().flat_map(|b| b.min.iter().chain(&b.max)).map(|x| x.abs()).sum();
            let shapes = loaded.robot.links.iter().flat_map(|link| &link.collision);
            let shapes: f64 = shapes.map(|part| shape(&part.pose_link_geometry, &part.geometry)).sum();
            base + travel + shapes + (0..loaded.robot.joints.len()).map(|joint| span(loaded, joint)).sum::<f64>()
        })
        .sum();
    ((of_obstacles + of_robots) * 20.0).ceil() / 10.0
}

/// Returns the length of the joint's origin plus a bound on its limited travel \[m\].
fn span(loaded: &LoadedRobot, joint: usize) -> f64 {
    let joint = &loaded.robot.joints[joint];
    let slides = matches!(joint.kind, JointKind::Prismatic | JointKind::Planar | JointKind::Floating);
    let travel: f64 = match (slides, loaded.entry.limits.get(&joint.name), joint.limits) {
        (false, ..) => 0.0,
        (_, Some(LimitsEntry::Interval(limits)), _) => 3.0 * limits.iter().map(|x| x.abs()).sum::<f64>(),
        (_, Some(LimitsEntry::Bounds(bounds)), _) => bounds.min.iter().chain(&bounds.max).map(|x| x.abs()).sum(),
        (_, None, Some((lower, upper))) => 3.0 * (lower.abs() + upper.abs()),
        (_, None, None) => 0.0,
    };
    joint.pose_parent_joint.translation.norm() + travel
}

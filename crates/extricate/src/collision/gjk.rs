//! Distance between two convex shapes (Gilbert, Johnson and Keerthi).

use super::convex::ConvexShape;
use crate::math::{Pose, Vec3};

/// Signed distance and witness of two convex shapes, in the frame that both poses map to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// [m]; negative: the least translation that parts them.
    pub distance: f64,
    /// Nearest (deepest) point of the first shape.
    pub point_first: Vec3,
    /// Nearest (deepest) point of the second shape.
    pub point_second: Vec3,
    /// Unit, from the second toward the first.
    pub normal: Vec3,
}

/// Signed distance; `None` as soon as it is proved greater than `cutoff` [m].
pub fn separation(
    first: &ConvexShape,
    pose_first: &Pose,
    second: &ConvexShape,
    pose_second: &Pose,
    cutoff: f64,
) -> Option<Separation> {
    let _ = (first, pose_first, second, pose_second, cutoff);
    todo!()
}

/// Whether the signed distance is below `threshold` [m] (which may be 0), stopping as soon as that is decided.
pub fn nearer_than(
    first: &ConvexShape,
    pose_first: &Pose,
    second: &ConvexShape,
    pose_second: &Pose,
    threshold: f64,
) -> bool {
    let _ = (first, pose_first, second, pose_second, threshold);
    todo!()
}

//! Estimated contacts of overlapping surfaces: of one triangle with another, or with a convex
//! solid.

use super::sink::Near;
use crate::collision::narrow_phase::triangle::Triangle;
use crate::collision::shapes::ConvexSolid;
use crate::math::{Pose, Vec3};

/// Returns the contact with the least translation that parts two crossing triangles along a normal
/// of one of them. Triangles that bound solids push outward only.
pub fn crossing(first: &Triangle, first_closed: bool, second: &Triangle, second_closed: bool) -> Option<Near> {
    let mut best: Option<Near> = None;
    for (face, closed, other, sign) in [(second, second_closed, first, 1.0), (first, first_closed, second, -1.0)] {
        for side in [1.0, -1.0] {
            if face.normal == Vec3::zeros() || (closed && side < 0.0) {
                continue;
            }
            let heights = other.points.map(|p| side * face.height(&p));
            let lowest = (0..3).min_by(|i, j| heights[*i].total_cmp(&heights[*j])).expect("three corners");
            let distance = heights[lowest].min(0.0);
            if best.is_none_or(|near| distance > near.distance) {
                let point = other.points[lowest];
                let foot = point - face.normal * (side * heights[lowest]);
                let (point_first, point_second) = if sign > 0.0 { (point, foot) } else { (foot, point) };
                best = Some(Near { distance, point_first, point_second, normal: face.normal * (side * sign) });
            }
        }
    }
    best
}

/// Returns the contact of a triangle and a solid. A triangle of a closed component pushes the solid
/// outward, even if inward is shorter.
pub fn outward(found: Near, face: &Triangle, closed: bool, solid: &ConvexSolid, pose: &Pose) -> Near {
    let inward = closed && found.distance <= 0.0 && found.normal.dot(&face.normal) > 0.0;
    if inward { along(&-face.normal, face, solid, pose) } else { found }
}

/// Returns the contact that parts a triangle from a solid along `normal` (unit, from the solid to
/// the triangle).
fn along(normal: &Vec3, face: &Triangle, solid: &ConvexSolid, pose: &Pose) -> Near {
    let least = |p: &Vec3, q: &Vec3| normal.dot(p).total_cmp(&normal.dot(q));
    let lowest = face.points.into_iter().min_by(least).expect("three corners");
    let down = pose.inverse_vector(normal);
    let highest = pose.point(&(solid.shape.core.support(&down) + down * solid.shape.radius));
    let distance = normal.dot(&(lowest - highest)).min(0.0);
    Near { distance, point_first: lowest, point_second: lowest - normal * distance, normal: *normal }
}

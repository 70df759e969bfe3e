//! Convex shapes that stand for scenery. In proofs they lie inside it; in proposals they lie
//! roughly in the same place.

use super::half_space::HalfSpace;
use super::kinds::Scenery;
use super::nodes::{Approach, At, ENDLESS_HALF_SIDE_M};
use crate::collision::prepared::Placed;
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::math::{Mat3, Pose, Vec3};

/// Purpose of the stand-ins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stands {
    /// Proofs: each stand-in lies inside the scenery.
    Inside,
    /// Proposals: stand-ins lie roughly in the place of the scenery.
    Near,
}

/// Elements that may stand for many equal shapes: those with the deepest overlap of boxes.
const MAX_STAND_INS: usize = 4;

/// Calls `each` with the stand-ins of `scenery` (placed at `pose`) against `other`: convex shapes,
/// boxes around them in their frames, and their poses.
pub fn stand_ins(
    scenery: &Scenery,
    pose: &Pose,
    other: Placed,
    stands: Stands,
    stack: &mut Vec<(f64, u32)>,
    each: &mut dyn FnMut(&ConvexSolid, &Aabb, &Pose),
) {
    let relative = Relative::between(pose, other.pose);
    let (center, radius) = other.shape().ball;
    let center = relative.pose_a_b.point(&center);
    let mut each = |solid: &ConvexSolid, bounds: &Aabb, own: &Pose| each(solid, bounds, &pose.then(own));
    match scenery {
        Scenery::HalfSpace(half) => below_plane(half, &center, radius, &mut each),
        Scenery::Many(many) => {
            let approach = scenery.approach(&relative, &other.shape().bounds);
            for number in deepest(scenery, &approach).into_iter().flatten() {
                if let Some(element) = many.element(number) {
                    each(element.solid, element.bounds, &Pose::translation(element.place));
                }
            }
        }
        Scenery::Field(field) => {
            let rectangle = |reach: f64| ([0, 1].map(|k| center[k] - reach), [0, 1].map(|k| center[k] + reach));
            let (lower, upper) = rectangle(radius);
            let Some((_, highest)) = field.heights_in(lower, upper, stack) else { return };
            // Make the box so wide that moving aside is never shorter than moving up.
            let depth = (highest - center.z).max(0.0) + radius;
            let (lower, upper) = rectangle(2.0 * depth + radius);
            let Some((lower, upper)) = field.clipped(lower, upper) else { return };
            let Some((lowest, _)) = field.heights_in(lower, upper, stack) else { return };
            let top = if stands == Stands::Inside { lowest } else { highest };
            let bottom = (center.z - radius).min(top) - 2.0 * depth;
            let between = Aabb {
                center: Vec3::new(lower[0] + upper[0], lower[1] + upper[1], top + bottom) * 0.5,
                half: Vec3::new(upper[0] - lower[0], upper[1] - lower[1], top - bottom) * 0.5,
            };
            cuboid(between.half, &Pose::translation(between.center), &mut each);
        }
    }
}

fn cuboid(half_extents: Vec3, pose: &Pose, each: &mut dyn FnMut(&ConvexSolid, &Aabb, &Pose)) {
    let shape = ConvexShape { core: ConvexCore::Box { half_extents }, radius: 0.0 };
    each(&ConvexSolid::without_planes(shape), &Aabb::between(&-half_extents, &half_extents), pose);
}

/// Makes a box below a ball, with one face on the plane. The shortest exit of the ball is through
/// that face and as long as that from the half-space.
fn below_plane(half: &HalfSpace, center: &Vec3, radius: f64, each: &mut dyn FnMut(&ConvexSolid, &Aabb, &Pose)) {
    let height = half.height(center);
    let reach = (2.0 * (height.abs() + radius) + radius).min(ENDLESS_HALF_SIDE_M);
    let across = half.normal.cross(&Vec3::ith(half.normal.iamin(), 1.0)).normalize();
    let rotation = Mat3::from_columns(&[across, half.normal.cross(&across), half.normal]);
    let translation = center - half.normal * (height + reach);
    cuboid(Vec3::repeat(reach), &Pose { rotation, translation }, each);
}

/// Finds the elements whose boxes overlap that of the other shape deepest.
fn deepest(scenery: &Scenery, approach: &Approach) -> [Option<u32>; MAX_STAND_INS] {
    let (mut found, mut bounds) = ([None; MAX_STAND_INS], [0.0; MAX_STAND_INS]);
    // The stack never exceeds the depth of the tree times the children of a node, which is less
    // than this.
    let mut stack: arrayvec::ArrayVec<(f64, At), 256> = arrayvec::ArrayVec::new();
    stack.extend(scenery.root().map(|root| (f64::NEG_INFINITY, root)));
    while let Some((bound, at)) = stack.pop() {
        if bound >= bounds[MAX_STAND_INS - 1] {
            continue;
        }
        let Some(number) = at.as_element() else {
            scenery.open(at, approach, bounds[MAX_STAND_INS - 1], |bound, child| stack.push((bound, child)));
            continue;
        };
        let (mut bound, mut number) = (bound, Some(number));
        for (slot, known) in found.iter_mut().zip(&mut bounds) {
            if bound < *known {
                std::mem::swap(known, &mut bound);
                std::mem::swap(slot, &mut number);
            }
        }
    }
    found
}

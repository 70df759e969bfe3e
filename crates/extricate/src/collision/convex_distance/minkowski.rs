//! The Minkowski difference of two convex cores, which holds the origin if and only if the cores
//! meet.

use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::math::{Mat3, Pose, Vec3};

/// `{ a - b : a in first, b in second }` in the frame of the first core.
pub(crate) struct Difference<'a> {
    first: &'a ConvexCore,
    second: &'a ConvexCore,
    rotation: Mat3,
    translation: Vec3,
    /// Upper bound on every coordinate in the arithmetic \[m\].
    pub scale: f64,
    /// Bound on the rounding error of a support plane \[m\]: some ten operations on numbers up to
    /// `scale`, doubled.
    pub rounding: f64,
    /// Distance \[m\] below which the direction between two vertices is rounding noise (here to
    /// 1e-5). The planes of the expanding polytope are then better, with an error in the distance
    /// below this.
    pub touching: f64,
}

/// A point of the difference and the point of the first core that it came from (both in the first
/// core's frame) \[m\].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Vertex {
    pub point: Vec3,
    pub first: Vec3,
}

impl<'a> Difference<'a> {
    pub fn new(first: &'a ConvexShape, pose_first: &Pose, second: &'a ConvexShape, pose_second: &Pose) -> Self {
        let rotation = pose_first.rotation.tr_mul(&pose_second.rotation);
        let translation = pose_first.inverse_point(&pose_second.translation);
        let scale = first.core.reach() + second.core.reach() + translation.norm();
        Self {
            first: &first.core,
            second: &second.core,
            rotation,
            translation,
            scale,
            rounding: 16.0 * f64::EPSILON * scale,
            touching: 1e-10 * scale,
        }
    }

    /// Returns a point of the difference that lies farthest along `direction`.
    #[inline(always)]
    pub fn support(&self, direction: &Vec3) -> Vertex {
        let first = self.first.support(direction);
        let second = self.second.support(&-self.rotation.tr_mul(direction));
        Vertex { point: first - self.second_in_first(&second), first }
    }

    /// Maps a point of the second core to the frame of the first.
    #[inline(always)]
    pub fn second_in_first(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }

    /// Maps a point in the frame of the first core to that of the second.
    pub fn first_in_second(&self, point: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(point - self.translation))
    }

    /// Returns the vector from the middle of the second core to the middle of the first.
    pub fn center(&self) -> Vec3 {
        self.first.center() - self.second_in_first(&self.second.center())
    }

    /// Returns whether the boundary has smooth parts.
    pub fn is_curved(&self) -> bool {
        self.first.is_curved() || self.second.is_curved()
    }
}

//! A half-space: everything on one side of a plane. No pairs.

use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::math::Vec3;

/// Solid for all `x` with `normal . x <= offset`.
#[derive(Debug, Clone, Copy)]
pub struct HalfSpace {
    /// Outward unit normal of the plane.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal \[m\].
    pub offset: f64,
}

impl HalfSpace {
    /// Height \[m\] of a point above the plane.
    pub fn height(&self, point: &Vec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Lower bound \[m\] on the height of all points of a box. `relative` maps the frame of the box
    /// to this one.
    pub fn lower_bound(&self, relative: &Relative, bounds: &Aabb) -> f64 {
        let normal = relative.pose_a_b.inverse_vector(&self.normal);
        self.height(&relative.pose_a_b.point(&bounds.center)) - normal.abs().dot(&bounds.half)
    }
}

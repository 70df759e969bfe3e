//! All on one side of a plane. Against other shapes in closed form.

use crate::collision::bounds::{Aabb, Relative};
use crate::collision::gjk::Separation;
use crate::collision::shape::{Shape, ShapeKind};
use crate::math::Vec3;

/// Solid where `normal . x <= offset`.
#[derive(Debug, Clone, Copy)]
pub struct HalfSpace {
    /// Unit.
    pub normal: Vec3,
    /// \[m\]
    pub offset: f64,
}

impl HalfSpace {
    /// Height \[m\] of a point above the plane.
    pub fn height(&self, point: &Vec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Lower bound \[m\] on the height of what a box holds, given in a frame that `relative` maps
    /// to this one.
    pub fn lower_bound(&self, relative: &Relative, bounds: &Aabb) -> f64 {
        let normal = relative.pose_a_b.inverse_vector(&self.normal);
        self.height(&relative.pose_a_b.point(&bounds.center)) - normal.abs().dot(&bounds.half)
    }

    /// The signed distance of a shape, with the points that realise it: exact also below 0. `None`
    /// for scenery.
    pub fn separation(&self, relative: &Relative, other: &Shape) -> Option<Separation> {
        let pose = &relative.pose_a_b;
        let down = pose.inverse_vector(&-self.normal);
        let lowest = match &other.kind {
            ShapeKind::Convex(solid) => solid.shape.core.support(&down) + down * solid.shape.radius,
            ShapeKind::Mesh(mesh) => {
                let along = |v: &Vec3| down.dot(v);
                *mesh.vertices.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?
            }
            ShapeKind::Scenery(_) => return None,
        };
        let point_second = pose.point(&lowest);
        let distance = self.height(&point_second);
        let point_first = point_second - self.normal * distance;
        Some(Separation { distance, depth_lower: -distance, point_first, point_second, normal: -self.normal })
    }
}

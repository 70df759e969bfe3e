//! A convex solid for checks: its support function, and the depth of points in it. No bounding box,
//! no pairs.

use super::convex::{ConvexCore, ConvexShape};
use crate::collision::convex_distance;
use crate::math::elementary::hypot;
use crate::math::{Pose, Vec3};

/// A convex solid with the planes of its faces.
#[derive(Debug, Clone)]
pub struct ConvexSolid {
    /// Shape with its support function.
    pub shape: ConvexShape,
    /// Unit outward normals and offsets of a hull's faces: `normal . x <= offset` inside.
    planes: Vec<(Vec3, f64)>,
}

impl ConvexSolid {
    /// Makes a solid without planes. Depths of points in a hull need planes; support points do not.
    pub fn without_planes(shape: ConvexShape) -> Self {
        Self { shape, planes: Vec::new() }
    }

    /// Makes a hull with the planes of its faces.
    pub fn with_planes(shape: ConvexShape, planes: Vec<(Vec3, f64)>) -> Self {
        Self { shape, planes }
    }

    /// Unit outward normals and offsets of a hull's faces; empty for other shapes.
    pub fn planes(&self) -> &[(Vec3, f64)] {
        &self.planes
    }

    /// Whether depths have a closed form everywhere, without a loop.
    pub fn is_primitive(&self) -> bool {
        !matches!(self.shape.core, ConvexCore::Triangle(_) | ConvexCore::Hull(_) | ConvexCore::Prism { .. })
    }

    /// Signed depth \[m\] of `point`: positive inside, minus the distance outside. In closed form
    /// except outside a hull.
    pub fn depth(&self, point: &Vec3) -> f64 {
        let core = match &self.shape.core {
            ConvexCore::Point => -point.norm(),
            ConvexCore::Segment { half_length } => {
                -(point - Vec3::z() * point.z.clamp(-half_length, *half_length)).norm()
            }
            ConvexCore::Box { half_extents } => slab_depth(point.abs() - half_extents),
            ConvexCore::Cylinder { radius, half_length } => {
                slab_depth(Vec3::new(hypot(point.x, point.y) - radius, point.z.abs() - half_length, f64::NEG_INFINITY))
            }
            ConvexCore::Triangle(_) | ConvexCore::Hull(_) | ConvexCore::Prism { .. } => {
                let outside = self.planes.iter().map(|(n, offset)| n.dot(point) - offset).fold(f64::MIN, f64::max);
                if outside <= 0.0 { -outside } else { -self.distance_outside(point, outside) }
            }
        };
        core + self.shape.radius
    }

    /// Depth \[m\] of a point in a core below the nearest face, and the outward normal of that
    /// face. `None` outside, and if the faces are unknown.
    pub fn nearest_face(&self, point: &Vec3) -> Option<(f64, Vec3)> {
        let along = |axis: usize| Vec3::ith(axis, 1.0f64.copysign(point[axis]));
        let (depth, normal) = match &self.shape.core {
            ConvexCore::Box { half_extents } => {
                let below = half_extents - point.abs();
                let axis = below.imin();
                (below[axis], along(axis))
            }
            ConvexCore::Cylinder { radius, half_length } => {
                let across = hypot(point.x, point.y);
                let (side, end) = (radius - across, half_length - point.z.abs());
                let out = if across > 0.0 { Vec3::new(point.x, point.y, 0.0) / across } else { Vec3::x() };
                if side < end { (side, out) } else { (end, along(2)) }
            }
            ConvexCore::Hull(_) => {
                let mut nearest = (f64::INFINITY, Vec3::zeros());
                for (normal, offset) in &self.planes {
                    let below = offset - normal.dot(point);
                    if below < 0.0 {
                        return None;
                    }
                    nearest = if below < nearest.0 { (below, *normal) } else { nearest };
                }
                nearest
            }
            _ => return None,
        };
        (0.0..f64::INFINITY).contains(&depth).then_some((depth, normal))
    }

    fn distance_outside(&self, point: &Vec3, at_least: f64) -> f64 {
        let ball = ConvexShape { core: ConvexCore::Point, radius: 0.0 };
        let identity = Pose::identity();
        convex_distance::separation(&ball, &Pose::translation(*point), &self.shape, &identity, f64::INFINITY)
            .map_or(at_least, |separation| separation.distance.max(at_least))
    }
}

/// Depth of a point in a product of intervals; `beyond` is its distance past the end of each.
pub fn slab_depth(beyond: Vec3) -> f64 {
    let outside = beyond.sup(&Vec3::zeros()).norm();
    if outside > 0.0 { -outside } else { -beyond.max() }
}

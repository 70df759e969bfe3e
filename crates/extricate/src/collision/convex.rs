//! Convex shapes by their support functions: a polyhedral or smooth core, rounded by a radius.

use crate::math::Vec3;

/// A convex core in its own frame, swept by a ball of `radius` [m].
#[derive(Debug, Clone)]
pub struct ConvexShape {
    /// What is swept.
    pub core: ConvexCore,
    /// [m]
    pub radius: f64,
}

/// A convex set given by its support function.
#[derive(Debug, Clone)]
pub enum ConvexCore {
    /// The origin.
    Point,
    /// From `-half_length` to `half_length` along z.
    Segment {
        /// [m]
        half_length: f64,
    },
    /// A cuboid.
    Box {
        /// [m]
        half_extents: Vec3,
    },
    /// A cylinder along z.
    Cylinder {
        /// [m]
        radius: f64,
        /// [m]
        half_length: f64,
    },
    /// A triangle.
    Triangle([Vec3; 3]),
    /// The convex hull of points.
    Hull(HullPoints),
}

/// Points of a hull.
#[derive(Debug, Clone)]
pub struct HullPoints {
    /// Coordinates [m].
    pub points: Vec<Vec3>,
}

//! The shapes a link or an obstacle can have, with their volume moments. Not the structures that make checks fast.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::TriangleMesh;
pub use super::moments::Moments;
use crate::math::Vec3;

/// A shape in its own frame, centred as URDF does it: cylinders and capsules along z, origin at the middle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// A ball.
    Sphere {
        /// \[m\]
        radius: f64,
    },
    /// A cuboid.
    Box {
        /// Half of each side \[m\].
        half_extents: Vec3,
    },
    /// A solid cylinder along z.
    Cylinder {
        /// \[m\]
        radius: f64,
        /// Half of the length \[m\].
        half_length: f64,
    },
    /// A cylinder along z with a half ball on both ends.
    Capsule {
        /// \[m\]
        radius: f64,
        /// Half of the length of the cylindrical part \[m\].
        half_length: f64,
    },
    /// A triangle mesh as it is: closed components are solid, open ones are surfaces.
    Mesh(Arc<TriangleMesh>),
    /// The convex hull of the mesh's vertices, solid. The mesh is the hull itself: vertices and outward faces.
    ConvexHull(Arc<TriangleMesh>),
}

//! The shapes that a link or an obstacle can have. The structures that make checks fast are
//! elsewhere.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::TriangleMesh;
pub use super::mesh::moments::Moments;
use super::scenery::{HeightField, PointCloud, Voxels};

/// A shape in its own frame. As in URDF, cylinders and capsules lie along z, and the origin is in
/// their middle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Geometry {
    /// A solid ball around the origin.
    Sphere {
        /// Radius of the ball \[m\].
        radius: f64,
    },
    /// A solid cuboid around the origin.
    Box {
        /// Half of each side \[m\].
        half_extents: [f64; 3],
    },
    /// A solid cylinder along z.
    Cylinder {
        /// Radius of the cylinder \[m\].
        radius: f64,
        /// Half of the length \[m\].
        half_length: f64,
    },
    /// A cylinder along z with a half ball on both ends.
    Capsule {
        /// Radius of cylinder and balls \[m\].
        radius: f64,
        /// Half of the length of the cylindrical part \[m\].
        half_length: f64,
    },
    /// A triangle mesh as it is: closed components are solid, open ones are surfaces.
    Mesh(Arc<TriangleMesh>),
    /// The convex hull of the mesh's vertices, solid. The mesh is the hull itself: vertices and
    /// outward faces.
    ConvexHull(Arc<TriangleMesh>),
    // New variants come last: stored models and pickled scenes store variants as numbers.
    /// Occupied cells of a grid, which are solid; for obstacles only.
    Voxels(Arc<Voxels>),
    /// A ball around every point; for obstacles only.
    Points(Arc<PointCloud>),
    /// The unbounded solid `normal . x <= offset`; for obstacles only.
    HalfSpace {
        /// Unit normal, which points out of the solid.
        normal: [f64; 3],
        /// Signed distance of the plane from the origin, along `normal` \[m\].
        offset: f64,
    },
    /// The solid below a grid of heights; for obstacles only.
    HeightField(Arc<HeightField>),
}

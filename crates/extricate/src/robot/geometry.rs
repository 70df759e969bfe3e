//! The shapes a link or an obstacle can have, with their volume moments. Not the structures that
//! make checks fast.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::TriangleMesh;
pub use super::mesh::moments::Moments;
use super::scenery::{HeightField, PointCloud, Voxels};

/// A shape in its own frame, centred as URDF does it: cylinders and capsules along z, origin at the
/// middle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Geometry {
    /// A ball.
    Sphere {
        /// \[m\]
        radius: f64,
    },
    /// A cuboid.
    Box {
        /// Half of each side \[m\].
        half_extents: [f64; 3],
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
    /// The convex hull of the mesh's vertices, solid. The mesh is the hull itself: vertices and
    /// outward faces.
    ConvexHull(Arc<TriangleMesh>),
    // New variants come last: stored models and pickled scenes know them by their numbers.
    /// Solid cubes of a grid; obstacles only.
    Voxels(Arc<Voxels>),
    /// A ball about every point; obstacles only.
    Points(Arc<PointCloud>),
    /// Solid where `normal . x <= offset`, without end; obstacles only.
    HalfSpace {
        /// Unit.
        normal: [f64; 3],
        /// \[m\]
        offset: f64,
    },
    /// The ground below a grid of heights; obstacles only.
    HeightField(Arc<HeightField>),
}

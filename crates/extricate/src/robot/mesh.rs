//! Triangle meshes: welding, connected components, closedness. Not file formats (see `mesh_file`).

use serde::{Deserialize, Serialize};

use crate::math::Vec3;

/// Welded triangles, sorted into connected components.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Distinct points [m].
    pub vertices: Vec<Vec3>,
    /// Indices into `vertices`; triangles of one component are contiguous, in the order of `components`.
    pub triangles: Vec<[u32; 3]>,
    /// Connected components (triangles that share a vertex).
    pub components: Vec<Component>,
}

/// A connected part of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Component {
    /// Range of its triangles.
    pub triangles: std::ops::Range<usize>,
    /// Whether every edge is shared by exactly two triangles, in opposite directions or not: it bounds a solid.
    pub closed: bool,
}

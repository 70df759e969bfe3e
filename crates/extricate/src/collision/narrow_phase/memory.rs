//! Memory of the checks of a pair: reusable stacks and the features that decided the last check.

use super::{mesh_convex, mesh_mesh};
use crate::collision::shapes::bounds::Aabb;
use crate::math::Vec3;

/// Stacks and lists that searches reuse.
#[derive(Debug, Default)]
pub struct Buffers {
    /// Stack for two trees.
    pub pairs: Vec<mesh_mesh::Entry>,
    /// Stack for a tree and a convex solid.
    pub single: Vec<mesh_convex::Entry>,
    /// Stack for a tree and a point or a ray.
    pub nodes: Vec<(f64, u32)>,
    /// Stack for scenery and another shape.
    pub places: Vec<(f64, u32)>,
    /// Indices of the overlapping pieces of two shapes.
    pub pieces: [Vec<u32>; 2],
    /// Boxes around the places of scenery that overlap a shape.
    pub boxes: Vec<Aabb>,
}

/// Features that decided the last check of a pair. The next check tries them first; no answer
/// depends on them.
#[derive(Debug, Clone, Copy)]
pub struct SeparatingWitness {
    /// Indices of two triangles that were near. A convex solid leaves `second` unused; scenery
    /// stores its element in `second`.
    pub triangles: (u32, u32),
    /// Direction that separated two convex solids; zero if there is none.
    pub normal: Vec3,
}

impl Default for SeparatingWitness {
    fn default() -> Self {
        Self { triangles: (u32::MAX, u32::MAX), normal: Vec3::zeros() }
    }
}

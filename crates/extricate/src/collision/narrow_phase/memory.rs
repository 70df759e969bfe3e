//! What checks of a pair keep: stacks that descents reuse, and what decided the last check. No
//! search.

use super::{mesh_convex, mesh_mesh};
use crate::collision::shapes::bounds::Aabb;
use crate::math::Vec3;

/// Stacks that the descents reuse.
#[derive(Debug, Default)]
pub struct Buffers {
    /// Of two trees.
    pub pairs: Vec<mesh_mesh::Entry>,
    /// Of a tree and a convex solid.
    pub single: Vec<mesh_convex::Entry>,
    /// Of a tree and a point or ray.
    pub nodes: Vec<(f64, u32)>,
    /// Of scenery and another shape.
    pub places: Vec<(f64, u32)>,
    /// Of two shapes that overlap: which of their pieces do.
    pub pieces: [Vec<u32>; 2],
    /// Boxes around the places of scenery that overlap a shape.
    pub boxes: Vec<Aabb>,
}

/// What decided the last check of a pair, to be tried first in the next one. Never decides by
/// itself.
#[derive(Debug, Clone, Copy)]
pub struct SeparatingWitness {
    /// Indices of the triangles that were near (of the one triangle, in `first`, against a convex
    /// solid; of the element of scenery, in `second`).
    pub triangles: (u32, u32),
    /// A direction that parted two convex solids; zero where none did.
    pub normal: Vec3,
}

impl Default for SeparatingWitness {
    fn default() -> Self {
        Self { triangles: (u32::MAX, u32::MAX), normal: Vec3::zeros() }
    }
}

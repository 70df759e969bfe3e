//! Trees of boxes over the triangles of a mesh: eight children a node, eight triangles a leaf. No
//! pairs of trees.

mod assemble;
mod block;
mod boxes;
mod build;
mod triangle_tree;

pub use crate::math::simd::lanes_of;
pub use block::Probe;
pub use boxes::{Boxes, Cuboid, Lanes, Seen, View, below, rounded_up, rounding_at};
pub use build::build;
pub use triangle_tree::{Bvh, Nearest, Ref, TreeLayout, push_sorted};

#[cfg(test)]
mod tests;

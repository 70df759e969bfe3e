//! Geometry of a part, prepared for checks: a convex solid, a mesh or scenery, with a bounding box
//! and a bounding ball.

pub mod bounds;
pub(crate) mod bvh;
pub mod convex;
mod convex_solid;
pub mod inner_spheres;
pub mod mesh;
mod shape;

pub use convex_solid::{ConvexSolid, slab_depth};
pub use shape::{Shape, ShapeKind};

#[cfg(test)]
pub mod test_mesh;

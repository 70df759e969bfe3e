//! One shape against another: whether they keep a distance, and their signed distance. A body
//! inside a solid is in collision with it.

pub mod best_first;
pub mod containment;
mod memory;
pub mod mesh_convex;
pub mod mesh_mesh;
pub mod mesh_solid;
pub mod pair;
pub mod shape_pair;
pub mod triangle;

pub use memory::{Buffers, SeparatingWitness};
pub use pair::{convex_depth, lower_bound, nearer, proved_nearer, signed_distance};

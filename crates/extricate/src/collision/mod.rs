//! The exact checker: which pairs of a scene keep their clearance at a configuration, and signed
//! distances of bodies. Distances are in f64; boxes in f32 only rule pairs out, on the safe side.
//!
//! Pairs of convex shapes are measured in `convex_distance` (GJK and EPA). Meshes are trees of
//! triangles (`shapes::bvh`), which are descended down to exact distances of triangles. If no
//! triangles are near, `narrow_phase::containment` decides whether one solid holds the other.
//! Clouds, grids and the ground are in `scenery`.

mod answers;
mod broad_phase;
mod checker;
mod contacts;
mod convex_decomposition;
pub mod convex_distance;
mod narrow_phase;
mod overlap;
mod prepared;
mod scenery;
mod segment;
pub mod shapes;

pub use answers::{
    DistanceRow, StandIns, always_colliding, contacts_within, disable_list, misses_allowed, most_often_colliding,
    signed_distance_below, signed_distances, signed_distances_of,
};
pub use checker::{CheckScratch, Checker};
pub use contacts::{Contact, ContactQuery, ContactSearch};
pub use convex_decomposition::convex_parts;
pub use narrow_phase::shape_pair::PairScratch;
pub use overlap::{ConvexOverlap, ConvexPair, OverlappingPieces};
pub(crate) use prepared::shared_shape;
pub use prepared::{PieceArrays, PreparedShape, TreeArrays};
pub use segment::{LEAST_RESOLUTION, SegmentOptions, SegmentOutcome};
pub(crate) use segment::{SegmentBudget, prove};
pub use shapes::inner_spheres::largest_balls;

#[cfg(test)]
mod tests;

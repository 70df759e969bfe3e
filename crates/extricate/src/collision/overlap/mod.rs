//! Overlaps of convex shapes. Lower bounds on the depth rest on those with proved depths; overlaps
//! along directions propose how bodies may separate.

mod convex_overlap;
mod convex_pair;
mod inner_pair;
pub mod inner_pieces;
mod overlapping_pieces;

pub use convex_overlap::{ConvexOverlap, convex_overlaps};
pub use convex_pair::ConvexPair;
pub use inner_pair::inner_pairs;
pub use overlapping_pieces::{OverlappingPieces, overlapping_pieces};

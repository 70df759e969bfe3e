//! Overlaps of convex shapes: with proved depths, what lower bounds on the exit stand on; along
//! directions, where bodies may part.

mod convex_overlap;
mod convex_pair;
mod inner_pair;
pub mod inner_pieces;
mod overlapping_pieces;

pub use convex_overlap::{ConvexOverlap, convex_overlaps};
pub use convex_pair::ConvexPair;
pub use inner_pair::inner_pairs;
pub use overlapping_pieces::{OverlappingPieces, overlapping_pieces};

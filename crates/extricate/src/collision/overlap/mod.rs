//! Overlaps of convex shapes with proved depths: what lower bounds on the exit stand on.

mod convex_overlap;
mod convex_pair;
mod inner_pair;
pub mod inner_pieces;

pub use convex_overlap::{ConvexOverlap, convex_overlaps};
pub use convex_pair::{ConvexPair, convex_pairs};
pub use inner_pair::inner_pairs;

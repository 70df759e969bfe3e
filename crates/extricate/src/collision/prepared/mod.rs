//! Data that is prepared once for a scene and serves many checks: bodies with their shapes and
//! derived data, and their poses at a configuration. No pairs.

mod bodies;
mod piece_arrays;
mod placed;
mod shape;
mod tree_arrays;

pub use bodies::{Bodies, Placement, PreparedBody, PreparedPart, shared_shape};
pub use piece_arrays::{PieceArrays, kept_pieces, take_pieces};
pub use placed::Placed;
pub use shape::PreparedShape;
pub use tree_arrays::TreeArrays;

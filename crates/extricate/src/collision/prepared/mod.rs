//! What is prepared of a scene once and checked often: its bodies, with shapes and what is derived
//! from them, and where they are at a configuration. No pairs.

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

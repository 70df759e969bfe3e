//! Contacts of two shapes: where they are near, as local constraints for proposals. What decides is
//! elsewhere.

mod buffers;
mod by_elements;
mod by_pieces;
mod cache;
mod contact;
mod convex_convex;
mod gather;
mod mesh_convex;
mod mesh_mesh;
mod overlap;
mod sink;

pub use buffers::{BEYOND_NEAREST, ContactBuffers, PairPlace};
pub use by_pieces::{find_candidates, solid};
pub use contact::{Contact, ContactQuery, ContactSearch};
pub use gather::gather;

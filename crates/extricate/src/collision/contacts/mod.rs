//! Contacts of two shapes: points where they are near, as local constraints for proposals. Whether
//! shapes collide is decided in `narrow_phase`.

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

pub use buffers::{BEYOND_NEAREST_SHARE, ContactBuffers, PairPlace};
pub use by_pieces::{find_candidates, solid};
pub use contact::{Contact, ContactQuery, ContactSearch};
pub use gather::gather;

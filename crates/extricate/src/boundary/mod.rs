//! Verified boundary samples and the index over them.

pub mod clustering;
pub mod index;
pub mod lists;
pub mod projection;

//! Verified boundary samples and the index over them.

pub mod index;

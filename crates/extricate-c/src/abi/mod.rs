//! The functions of `include/extricate.h`. Each turns its pointers into references
//! ([`crate::raw`]), works inside [`crate::status::guarded`], which stops panics, and writes its
//! results to memory of the caller.
//!
//! Read `types` first, then `scene` and `solver`, which most programs use alone.
//!
//! # Safety
//! All functions share the contract of [`crate::raw`], which the head of the header states.

pub mod grasp_types;
pub mod motion_types;
pub mod types;

pub mod answer;
pub mod answer_to_c;
pub mod batch;
pub mod check;
pub mod geometry;
pub mod grasp;
pub mod handles;
pub mod motion;
pub mod motion_to_c;
pub mod roadmap;
pub mod scene;
pub mod scene_info;
pub mod solver;
pub mod stream;
pub mod world;

//! The functions of `include/extricate.h`. Each makes references of its pointers ([`crate::raw`]),
//! does its work behind the fence ([`crate::status::guarded`]), and writes what it found where the
//! caller said.
//!
//! Read `types` first, then `scene` and `solver`, which most programs use alone.
//!
//! # Safety
//! All functions share the contract of [`crate::raw`], which the head of the header tells callers.

pub mod types;

pub mod answer;
pub mod batch;
pub mod check;
pub mod describe;
pub mod handles;
pub mod names;
pub mod scene;
pub mod solver;
pub mod stream;
pub mod world;

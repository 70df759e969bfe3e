//! The C interface of `extricate`: a thin shell that C and C++ programs link against. No Rust
//! program needs it.
//!
//! Read `abi/mod.rs` first: its modules hold the functions of `include/extricate.h`, by subject.
//! Only `raw` dereferences pointers, and `status` reports failures. `options`, `motion_options`,
//! `load_options`, `rows` and `shapes` read the structures that callers fill in; `enum_constants`
//! maps enums of the library to constants of the header.

mod abi;
mod enum_constants;
mod load_options;
mod motion_options;
mod options;
mod raw;
mod rows;
mod shapes;
mod status;

//! The C interface of `extricate`: a thin shell that C and C++ programs link against. No Rust
//! program needs it.
//!
//! Read `abi/mod.rs` first: the functions of `include/extricate.h`, by what they are about. They
//! make references of pointers in `raw`, which alone dereferences any, and report in `status`.
//! `options` and `shapes` read what callers fill in; `numbers` are those of the library's choices.

mod abi;
mod numbers;
mod options;
mod raw;
mod shapes;
mod status;

//! The C interface of `extricate`: a thin shell that C and C++ programs link against. No Rust
//! program needs it.
//!
//! Read `abi/mod.rs` first: the functions of `include/extricate.h`, by what they are about. They
//! make references of pointers in `raw`, which alone dereferences any, and report in `status`.
//! `asked` is what a scene handle holds, `options` and `shapes` check what callers fill in.

mod abi;
mod asked;
mod options;
mod raw;
mod shapes;
mod status;

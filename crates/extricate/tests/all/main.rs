//! The integration tests of the library, in one binary.

mod analytic;
mod licences;
mod memory;
mod property;
mod tidy;

//! The integration tests of the library, in one binary.

mod adapting;
mod analytic;
mod budgets;
mod licences;
mod memory;
mod property;
mod tidy;

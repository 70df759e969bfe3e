//! The integration tests of the library, in one binary.

mod adapting;
mod analytic;
mod budgets;
mod licences;
mod memory;
mod property;
mod query;
mod query_elsewhere;
mod recheck;
mod soak;
mod tidy;

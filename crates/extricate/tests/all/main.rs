//! The integration tests of the library, in one binary.

mod adapting;
mod allocations;
mod analytic;
mod beyond_limits;
mod budgets;
mod components;
mod constraints;
mod judge;
mod learned_classifier;
mod licences;
mod memory;
mod meshes;
mod no_model;
mod other_robots;
mod property;
mod query;
mod query_changed;
mod query_elsewhere;
mod recheck;
mod rigid;
mod scene_edits;
mod soak;
mod spoiled;
mod tidy;
mod tightness;

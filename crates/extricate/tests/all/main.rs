//! The integration tests of the library, in one binary.

mod adapting;
mod allocations;
mod analytic;
mod beyond_limits;
mod budgets;
mod circles;
mod claims;
mod components;
mod constraints;
mod hostile;
mod judge;
mod learned_classifier;
mod licences;
mod memory;
mod meshes;
mod motions;
mod narrow_places;
mod no_model;
mod other_robots;
mod property;

mod proved;
mod public_api;
mod query;
mod query_changed;
mod query_elsewhere;
mod recheck;
mod repeatable;
mod rigid;
mod scene_edits;
mod scenery;
mod scenery_queries;
mod soak;
mod spoiled;
mod tidy;
mod tightness;

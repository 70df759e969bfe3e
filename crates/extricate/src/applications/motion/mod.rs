//! Motions: paths whose every edge is proved, from what queries and the exact checker say.
//!
//! Read in this order: `prover` (what is proved, counted and limited), `nodes` (configurations and
//! which are nearest), `rrt_connect`, `shortcut`, `path`; then the questions: `escape`, `roadmap`
//! with `plan`, and `repair`.
//!
//! An edge is the geodesic between two configurations ([`crate::ConfigSpace::interpolate`]). It is
//! proved free by [`crate::Checker::segment`]'s argument, never by samples. A *check* is one
//! configuration at which the exact checker evaluated anything: a label, contacts, or one stretch
//! of a proof. No smoothing, no time.

pub mod escape;
mod nodes;
pub mod path;
pub mod plan;
mod prover;
pub mod repair;
pub mod roadmap;
mod rrt_connect;
mod shortcut;
#[cfg(test)]
mod testing;

pub use escape::{Escape, EscapeMethod, EscapeOptions};
pub use plan::{Plan, PlanMethod, PlanOptions};
pub use repair::{RepairOptions, Repaired};
pub use roadmap::Roadmap;

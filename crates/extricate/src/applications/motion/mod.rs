//! Motions: paths whose every edge is proved, from queries and the exact checker.
//!
//! Read in this order: `prover` (proofs, counted and limited), `held` (links that are kept),
//! `nodes` (configurations and a search for the nearest), `rrt_connect`, `shortcut`, `path`; then
//! the applications: `escape`, `roadmap` with `plan`, and `repair`.
//!
//! An edge is the geodesic between two configurations ([`crate::ConfigSpace::interpolate`]). It is
//! proved free by the argument of [`crate::Checker::segment`], never by samples. A *check* is one
//! configuration at which the exact checker evaluated anything: a label, contacts, or one stretch
//! of a proof. Paths are not smoothed and have no times.

pub mod escape;
mod held;
mod nodes;
pub mod path;
pub mod plan;
pub(super) mod prover;
mod push_off;
pub mod repair;
pub mod roadmap;
pub(super) mod rrt_connect;
pub(super) mod shortcut;
mod slide;
#[cfg(test)]
pub mod testing;

pub use escape::{Escape, EscapeMethod, EscapeOptions};
pub use plan::{Plan, PlanMethod, PlanOptions};
pub use repair::{RepairOptions, Repaired};
pub use roadmap::Roadmap;

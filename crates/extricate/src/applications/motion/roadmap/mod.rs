//! A roadmap: free configurations, most of them in narrow places, and proved edges.
//!
//! Read in this order: `kept` (the roadmap), `components`, `yields` and `samplers` (where
//! configurations come from), `grower`, `islands` (trees), `grow` (batches: draw, join, measure
//! what each sampler yields), `solve` (a path).
//!
//! Free configurations drawn uniformly hardly ever lie in a narrow passage. The nearest free ones
//! to colliding ones do, but cost more checks each. The best sampler depends on the scene, so its
//! worth is measured: its share of the next batch is its share of *useful* nodes per check. A node
//! is useful if nothing known can be joined to it, or if it joins two components.
//!
//! # Source
//! The measure of use is that of T. Simeon, J.-P. Laumond and C. Nissoux, "Visibility-based
//! probabilistic roadmaps for motion planning", Advanced Robotics 14(6), 2000,
//! doi:10.1163/156855300741960. Deviation: useless nodes are kept too. Retraction: L. Zhang and D.
//! Manocha, "An efficient retraction-based RRT planner", ICRA 2008, doi:10.1109/ROBOT.2008.4543785.
//! Bridges: D. Hsu, T. Jiang, J. Reif and Z. Sun, "The bridge test for sampling narrow passages
//! with probabilistic roadmap planners", ICRA 2003, doi:10.1109/ROBOT.2003.1241662.

mod components;
mod context;
mod grow;
mod grower;
mod islands;
mod kept;
mod samplers;
mod solve;
mod yields;

pub use context::RoadmapContext;
pub(super) use grow::grow;
pub(super) use grower::Grower;
pub use kept::{Roadmap, RoadmapParts};

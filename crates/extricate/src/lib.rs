//! Globally nearest collision-free configuration of an articulated model: penetration depth in configuration space.
//!
//! Given a configuration `q` that is in collision, [`Model::query`] finds the nearest free one (the *witness*), verified
//! by an exact checker with clearance, with a proved lower bound on how near any free configuration can be.

pub mod boundary;
pub mod collision;
pub mod cspace;
pub mod error;
pub mod kinematics;
pub mod learning;
pub mod math;
pub mod metric;
pub mod model;
pub mod model_file;
pub mod penetration;
pub mod robot;
pub mod scene;
pub mod store;

pub use collision::{CheckScratch, Checker, Contact, SegmentOptions, SegmentOutcome};
pub use cspace::{Config, ConfigSpace, Label, Manifold};
pub use error::{Error, Result};
pub use learning::{LearnOptions, LearnProgress};
pub use model::learner::Learner;
pub use model::{Model, Statistics};
pub use penetration::{
    Answer, Answered, ChangedScene, Effort, Exit, QueryBudget, QueryOptions, QueryScratch, StartsPerDof, Stop, Stream,
    StreamOptions, Toward, Unproved, Way, World,
};
pub use scene::Scene;

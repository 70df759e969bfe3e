//! The globally nearest collision-free configuration of an articulated model: penetration depth in
//! configuration space.
//!
//! Given a configuration `q` that is in collision, a query finds the nearest one that is free (the
//! *witness*). An exact checker verified it, with clearance. The *depth* is its distance from `q`;
//! the *lower bound* is proved: no free configuration is nearer than that.
//!
//! ```
//! use extricate::{LearnOptions, Model, World, builtin};
//!
//! let world = World::new(builtin::scene("planar-arm")?);          // or load_scene("scene.toml")
//! let q = world.scene().config(&[0.0, 0.1, 0.2])?;
//! let answer = world.query(&q).expect("something is free");       // at once, nothing learned
//! println!("{} rad away, at least {}: {:?}", answer.depth, answer.lower_bound, answer.witness);
//!
//! let options = LearnOptions { labels: 20_000, ..LearnOptions::default() };
//! let model = Model::learn(builtin::scene("planar-arm")?, &options)?;
//! let learned = model.query(&q).expect("something is free");      // from stored samples too
//! assert!(answer.lower_bound <= learned.depth && learned.lower_bound <= answer.depth);
//! # extricate::Result::Ok(())
//! ```
//!
//! A [`Scene`] is a robot, obstacles and the pairs of bodies that are checked. A [`World`] is a
//! scene that is ready to be queried; a [`Model`] is what was learned of one. Both give a [`View`],
//! and a [`Solver`] that keeps options and memory. A [`Stream`] answers frames of one motion.
//! Scenes can be changed ([`Scene::moved`], [`Scene::with_obstacles`], [`Scene::attached`]) and a
//! model queried there ([`Model::in_scene`]).

mod applications;
mod collision;
mod cspace;
mod error;
mod io;
mod kinematics;
mod learning;
mod math;
mod metric;
mod model;
mod query;
mod robot;
mod samples;
mod scene;

pub use applications::grasp::{Grasp, GraspContact, GraspQuality, Hand, Keep, ReleaseOptions};
pub use applications::motion::{
    Escape, EscapeMethod, EscapeOptions, Plan, PlanMethod, PlanOptions, RepairOptions, Repaired, Roadmap,
};
pub use collision::{CheckScratch, Checker, Contact, SegmentOptions, SegmentOutcome};
pub use cspace::{Config, ConfigSpace, Label, Manifold, Rows};
pub use error::{Error, Result};
pub use io::{LoadOptions, load_model, load_scene, load_scene_with, load_scene_within, save_model};
pub use learning::{LearnOptions, LearnProgress};
pub use model::{Model, Statistics};
pub use query::{
    Answer, ChangedScene, Effort, Exit, QueryOptions, QueryScratch, Solver, Stop, StraightSegment, Stream,
    StreamOptions, Termination, Toward, Unproved, View, World,
};
pub use robot::{LoadLimit, LoadLimits};
pub use scene::{MetricKind, PairId, Scene, builtin};

/// Shapes and where they are, for scenes that are changed in code.
pub mod geometry {
    pub use crate::math::{Mat3, Pose, Vec3};
    pub use crate::robot::{Geometry, HeightField, PointCloud, TriangleMesh, Voxels};
    pub use crate::scene::Body;
}

/// What the command line, the Python package, benchmarks and tests reach into. No part of the
/// interface: it changes without notice.
#[doc(hidden)]
#[allow(missing_docs)]
pub mod internals {
    pub mod collision {
        pub use crate::collision::*;
    }
    pub mod cspace {
        pub use crate::cspace::*;
    }
    pub mod grasp {
        pub use crate::applications::grasp::*;
    }
    pub mod io {
        pub use crate::io::*;
    }
    pub mod kinematics {
        pub use crate::kinematics::*;
    }
    pub mod learning {
        pub use crate::learning::*;
    }
    pub mod samples {
        pub use crate::samples::*;
    }
    pub mod math {
        pub use crate::math::*;
    }
    pub mod metric {
        pub use crate::metric::*;
    }
    pub mod model {
        pub use crate::model::*;
    }
    pub mod motion {
        pub use crate::applications::motion::*;
    }
    pub mod query {
        pub use crate::query::*;
    }
    pub mod robot {
        pub use crate::robot::*;
    }
    pub mod scene {
        pub use crate::scene::*;
    }
}

/// The samples of README.md are doctests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

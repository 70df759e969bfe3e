//! The globally nearest collision-free configuration of an articulated model: penetration depth in
//! configuration space.
//!
//! Given a configuration `q` that is in collision, a query finds the nearest one that is free (the
//! *witness*). An exact checker verified it, with clearance. The *depth* is its distance from `q`;
//! the *lower bound* is proved: no free configuration is nearer than that.
//!
//! ```
//! use extricate::{LearnOptions, Model, Solver, builtin};
//!
//! let solver = Solver::new(builtin::scene("planar-arm")?);        // or load_scene("scene.toml")
//! let q = solver.scene().config(&[0.0, 0.1, 0.2])?;
//! let answer = solver.query(&q).expect("something is free");      // at once, nothing learned
//! println!("{} rad away, at least {}: {:?}", answer.depth, answer.lower_bound, answer.witness);
//!
//! let model = Model::learn(builtin::scene("planar-arm")?, &LearnOptions::default().labels(20_000))?;
//! let learned = solver.with_model(model)?.query(&q).expect("something is free"); // from stored samples too
//! assert!(answer.lower_bound <= learned.depth && learned.lower_bound <= answer.depth);
//! # extricate::Result::Ok(())
//! ```
//!
//! A [`Scene`] is a robot, obstacles and the pairs of bodies that are checked. A [`Solver`] answers
//! all questions about it: queries, batches, streams, checks, escapes, plans, repairs, releases. A
//! [`Model`] is what was learned of a scene; a solver may have one. Scenes can be changed
//! ([`Scene::moved`], [`Scene::with_obstacles`], [`Scene::attached`]); a solver of the changed
//! scene reuses what was prepared and learned before ([`Solver::with_scene`]).
//!
//! # Features
//!
//! All are on by default; programs that make their geometry in code turn them off. `meshes` reads
//! STL, OBJ, COLLADA, PLY and glTF, and XML that is not in UTF-8. `model-files` reads and writes
//! models, roadmaps and scenes as bytes, `moveit` worlds of MoveIt. Without both, [`files`] writes
//! none. Without `meshes`, the built-in scenes that have meshes are errors.

// What files alone need stays in without them, and is left out by the linker.
#![cfg_attr(
    not(all(feature = "meshes", feature = "model-files", feature = "moveit")),
    allow(dead_code, unused_imports)
)]

mod applications;
mod collision;
mod cspace;
mod error;
mod interface;
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
mod solver;

pub use applications::grasp::{Grasp, GraspContact, GraspQuality, Hand, Keep, ReleaseOptions, Released};
pub use applications::motion::{
    Escape, EscapeMethod, EscapeOptions, Plan, PlanMethod, PlanOptions, RepairOptions, Repaired, Roadmap,
};
pub use applications::signed_distance::SignedDistance;
pub use applications::stream::{Stream, StreamOptions};
pub use collision::{CheckScratch, Checker, Contact, DistanceRow, LEAST_RESOLUTION, SegmentOptions, SegmentOutcome};
pub use cspace::{Config, ConfigSpace, Label, Manifold, Rows};
pub use error::{Error, Result};
pub use io::{LoadOptions, load_scene, load_scene_with, load_scene_within};
#[cfg(feature = "model-files")]
pub use io::{load_model, save_model};
pub use learning::{LearnOptions, LearnProgress};
pub use metric::{Anchor, Metric, MetricScratch};
pub use model::evaluate::figures::{Density, Excess};
pub use model::{EndedBy, Model, Statistics};
pub use query::answer::TOUCHING;
pub use query::options::{OptionEntry, QUERY_OPTIONS};
pub use query::{
    Answer, AnswerRecord, ContactRecord, Effort, Exit, ExitRecord, KeptError, KeptLink, QueryOptions, Stop,
    StraightSegment, Termination, Toward, Unproved,
};
pub use robot::{LoadLimit, LoadLimits};
pub use scene::{MetricKind, PairId, Scene, builtin};
pub use solver::{Answered, Sampler, Solver};

/// Shapes and poses of bodies, for scenes that are changed in code.
pub mod geometry {
    pub use crate::math::Pose;
    pub use crate::robot::formats::octree::Octree;
    pub use crate::robot::{Geometry, HeightField, PointCloud, TriangleMesh, Voxels};
    pub use crate::scene::Body;
}

/// Parts of a [`Scene`], and records about them.
pub mod parts {
    pub use crate::collision::{StandIns, disable_list, misses_allowed};
    pub use crate::cspace::Factor;
    pub use crate::robot::formats::from_arrays;
    pub use crate::robot::mesh::Component;
    pub use crate::robot::packages::PackageSearch;
    pub use crate::scene::assemble::Visual;
    pub use crate::scene::drawing::Seated;
    pub use crate::scene::mesh_counts::MeshCount;
    pub use crate::scene::named_configs::NamedConfig;
    pub use crate::scene::{BodyPair, Frame, LinkAttachment, MotionRecord, Part, RigidJoint, SceneJoint};
}

/// The entries of scene files, for scenes that are described in code instead.
pub mod entries {
    pub use crate::io::{assemble_scene, assemble_world, read_obstacles};
    pub use crate::scene::clearances::{ClearanceEntry, SplitClearance};
    pub use crate::scene::file::limits::{BoundsEntry, LimitsEntry};
    pub use crate::scene::file::{
        AttachedEntry, BaseKind, GeometryKind, MetricEntry, ObstacleEntry, PairsEntry, PoseEntry, RobotEntry,
        RowsEntry, ScaleEntry, SceneFile, ShapeEntry, WeightEntry, parse,
    };
}

/// Input and output: worlds of other programs, roadmaps, and files that are whole or not there.
pub mod files {
    #[cfg(feature = "moveit")]
    pub use crate::io::worlds::{ImportReport, import_world, is_urdf};
    #[cfg(any(feature = "model-files", feature = "moveit"))]
    pub use crate::io::{
        GrowingFile, OutputLock, check_not_read, check_output, is_same_output, write_atomically, write_together,
    };
    #[cfg(feature = "model-files")]
    pub use crate::io::{check_model_output, check_roadmap_output, load_roadmap, save_roadmap};
    pub use crate::io::{check_regular, find_package, load_visuals, load_world, load_world_text};
    #[cfg(feature = "moveit")]
    pub use crate::scene::import::{Imported, import, is_foreign, joint_positions};
}

/// Internals for benchmarks and tests. They are no part of the interface and change without notice.
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

/// Runs the samples of README.md as doctests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

//! The structures behind the handles, which are opaque in the header.

use std::ffi::CString;
use std::sync::{Arc, OnceLock};

use extricate::{Answer, Config, Hand, Roadmap, Scene, Solver, Stream, StreamOptions};

use crate::abi::grasp_types::{ExtricateGraspContact, ExtricateGraspSummary};
use crate::abi::motion_types::{
    ExtricateEscapeSummary, ExtricatePairDistance, ExtricatePlanSummary, ExtricateRepairedSummary,
};
use crate::abi::types::{ExtricateContact, ExtricateExit, ExtricateKeptError, ExtricatePair, ExtricateSummary};
use crate::options::Weights;
use crate::status::{Result, c_string};

/// A scene, perhaps with a model that was learned from it or from a similar scene. It never
/// changes.
pub struct ExtricateScene {
    /// Solver with the default options.
    pub(crate) solver: Solver,
    names: OnceLock<Names>,
    statistics: OnceLock<Option<CString>>,
}

/// A scene with query options. Only extricate_solver_set_options() changes it.
pub struct ExtricateSolver {
    /// Solver of the scene, with the weights of the scene.
    pub(crate) base: Solver,
    /// Solver with the options and weights of the caller.
    pub(crate) solver: Solver,
    /// Whether configurations beyond the limits are refused.
    pub(crate) refuse_outside: bool,
    /// Weights in place of those of the scene.
    pub(crate) weights: Weights,
}

/// A sequence of queries that are near each other. Each query starts from the exit of the one
/// before.
pub struct ExtricateStream {
    /// Solver of the scene in which the stream began, with the options of its queries.
    pub(crate) first: ExtricateSolver,
    pub(crate) options: StreamOptions,
    /// Solver of the scene of the next frame.
    pub(crate) solver: Solver,
    /// `None` before the first frame, and after one that failed and may have left it half written.
    pub(crate) stream: Option<Stream>,
}

/// The answer to a query. It never changes, and pointers into it stay valid until it is freed.
pub struct ExtricateAnswer {
    pub(crate) summary: ExtricateSummary,
    pub(crate) colliding: Vec<ExtricatePair>,
    pub(crate) touching: Vec<ExtricatePair>,
    pub(crate) kept: Vec<ExtricateKeptError>,
    pub(crate) contacts: Vec<ExtricateContact>,
    /// Their witnesses point into `answer`.
    pub(crate) exits: Vec<ExtricateExit>,
    pub(crate) answer: Answer,
}

/// A path out of collision. It never changes, and pointers into it stay valid until it is freed.
pub struct ExtricateEscape {
    pub(crate) summary: ExtricateEscapeSummary,
    pub(crate) colliding: Vec<ExtricatePairDistance>,
    /// Number of configurations in `points`.
    pub(crate) count: usize,
    /// Configurations, one after the other.
    pub(crate) points: Vec<f64>,
}

/// A path between two configurations. It never changes, and pointers into it stay valid until it is
/// freed.
pub struct ExtricatePlan {
    pub(crate) summary: ExtricatePlanSummary,
    /// Escapes from the start and from the goal.
    pub(crate) escapes: [Option<ExtricateEscape>; 2],
    /// Number of configurations in `points`.
    pub(crate) count: usize,
    /// Configurations, one after the other.
    pub(crate) points: Vec<f64>,
}

/// A free path in place of one that collides. It never changes, and pointers into it stay valid
/// until it is freed.
pub struct ExtricateRepaired {
    pub(crate) summary: ExtricateRepairedSummary,
    /// Configurations, one after the other.
    pub(crate) points: Vec<f64>,
    /// The place of each configuration on the old path.
    pub(crate) places: Vec<f64>,
}

/// Free configurations and proved edges between them, which plans add to and reuse.
pub struct ExtricateRoadmap {
    pub(crate) roadmap: Roadmap,
}

/// A hand that can hold one obstacle of a scene. It never changes.
pub struct ExtricateHand {
    /// Solver without a model, with the weights of the hand.
    pub(crate) solver: Solver,
    pub(crate) hand: Hand,
}

/// A configuration of a hand that holds an object and penetrates nothing. It never changes, and
/// pointers into it stay valid until it is freed.
pub struct ExtricateGrasp {
    pub(crate) summary: ExtricateGraspSummary,
    /// Their names point into `_names`.
    pub(crate) contacts: Vec<ExtricateGraspContact>,
    pub(crate) touched: Vec<CString>,
    pub(crate) kept: Vec<CString>,
    pub(crate) config: Vec<f64>,
    pub(crate) _names: Vec<CString>,
}

/// The triangles of a body. It never changes, and pointers into it stay valid until it is freed.
pub struct ExtricateMesh {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Contacts of bodies that are near each other. They never change, and pointers to them stay valid
/// until they are freed.
pub struct ExtricateContacts {
    pub(crate) contacts: Vec<ExtricateContact>,
    /// Gradients of the distances, one after another; empty if they were not requested.
    pub(crate) gradients: Vec<f64>,
}

/// Positions by joint. They never change, and pointers to them stay valid until they are freed.
pub struct ExtricatePositions {
    pub(crate) joints: Vec<(CString, Vec<f64>)>,
}

/// Texts of a scene, each ended by a zero as in C.
pub struct Names {
    /// Names of the joints, in the order of coordinates.
    pub joints: Vec<CString>,
    /// Names of the bodies, in the order of their indices.
    pub bodies: Vec<CString>,
    pub warnings: Vec<CString>,
}

/// Checks at compile time that threads may share scenes and solvers, as the header promises.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<ExtricateScene>();
    is_shared::<ExtricateSolver>();
    is_shared::<ExtricateHand>();
};

impl ExtricateScene {
    /// Makes the handle of a solver that has the default options.
    pub fn new(solver: Solver) -> Self {
        Self { solver, names: OnceLock::new(), statistics: OnceLock::new() }
    }

    pub fn scene(&self) -> &Arc<Scene> {
        self.solver.scene()
    }

    /// Returns the statistics of the model as JSON; `None` if there is no model.
    pub fn statistics(&self) -> Option<&CString> {
        let text = || {
            let statistics = self.solver.model()?.statistics();
            serde_json::to_string(statistics).ok().map(|text| c_string(&text))
        };
        self.statistics.get_or_init(text).as_ref()
    }

    /// Returns the texts of the scene, which are converted on the first call.
    pub fn names(&self) -> &Names {
        self.names.get_or_init(|| Names {
            joints: self.scene().joints().iter().map(|joint| c_string(&joint.name)).collect(),
            bodies: self.scene().bodies().iter().map(|body| c_string(&body.name)).collect(),
            warnings: self.scene().warnings().iter().map(|warning| c_string(warning)).collect(),
        })
    }
}

impl ExtricateSolver {
    /// Reads a configuration to query.
    ///
    /// # Errors
    /// If it has the wrong length, is not finite, or is beyond limits and the options refuse that.
    pub fn config(&self, q: &[f64]) -> Result<Config> {
        let scene = self.solver.scene();
        Ok(if self.refuse_outside { scene.config(q) } else { scene.space().config_anywhere(q) }?)
    }
}

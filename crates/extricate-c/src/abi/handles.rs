//! What handles hold. To the header they are opaque.

use std::ffi::CString;
use std::sync::{Arc, OnceLock};

use extricate::{Answer, Config, Scene, Solver, Stream, StreamOptions};

use crate::abi::types::{ExtricateContact, ExtricateExit, ExtricatePair, ExtricateSummary};
use crate::status::{Result, c_string};

/// A scene, perhaps with a model that was learned of it or of a scene like it. It never changes.
pub struct ExtricateScene {
    /// With the usual options.
    pub(crate) solver: Solver,
    names: OnceLock<Names>,
}

/// A scene with options of queries. Only extricate_solver_set_options() changes it.
pub struct ExtricateSolver {
    /// With the options of the caller.
    pub(crate) solver: Solver,
    /// Whether configurations beyond the limits are refused.
    pub(crate) refuse_outside: bool,
}

/// Queries that follow each other closely, each of which begins with the exit of the one before.
pub struct ExtricateStream {
    /// The solver of the scene that the stream began in, with the options of its queries.
    pub(crate) first: ExtricateSolver,
    pub(crate) options: StreamOptions,
    /// The solver of the scene of the next frame.
    pub(crate) solver: Solver,
    /// None after a fault of this library, which may have left it half written.
    pub(crate) stream: Option<Stream>,
}

/// The answer to a query. It never changes, and what its functions point to lives as long as it.
pub struct ExtricateAnswer {
    pub(crate) summary: ExtricateSummary,
    pub(crate) colliding: Vec<ExtricatePair>,
    pub(crate) touching: Vec<ExtricatePair>,
    pub(crate) contacts: Vec<ExtricateContact>,
    /// They point into `answer`.
    pub(crate) exits: Vec<ExtricateExit>,
    pub(crate) answer: Answer,
}

/// Names as C reads them.
pub struct Names {
    /// Names of the joints, in the order of coordinates.
    pub joints: Vec<CString>,
    /// Names of the bodies, in the order of their indices.
    pub bodies: Vec<CString>,
    /// What the user should know.
    pub warnings: Vec<CString>,
}

/// Threads share scenes and solvers, as the header says.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<ExtricateScene>();
    is_shared::<ExtricateSolver>();
};

impl ExtricateScene {
    /// The handle of a solver with the usual options.
    pub fn new(solver: Solver) -> Self {
        Self { solver, names: OnceLock::new() }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.solver.scene()
    }

    /// Names of joints and bodies, and warnings.
    pub fn names(&self) -> &Names {
        self.names.get_or_init(|| Names {
            joints: self.scene().joints().iter().map(|joint| c_string(&joint.name)).collect(),
            bodies: self.scene().bodies().iter().map(|body| c_string(&body.name)).collect(),
            warnings: self.scene().warnings().iter().map(|warning| c_string(warning)).collect(),
        })
    }
}

impl ExtricateSolver {
    /// A configuration to query.
    ///
    /// # Errors
    /// If it is of the wrong length, not finite, or beyond limits while that is refused.
    pub fn config(&self, q: &[f64]) -> Result<Config> {
        let scene = self.solver.scene();
        Ok(if self.refuse_outside { scene.config(q) } else { scene.space().config_anywhere(q) }?)
    }
}

//! What is learned of a scene, and the two things to do with it: learn it, ask it.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::cspace::Config;
use crate::error::Result;
use crate::learning::{LearnOptions, LearnProgress};
use crate::penetration::{Answer, QueryOptions, QueryScratch};
use crate::scene::Scene;

/// All that a query needs: the scene with its geometry, verified boundary samples, their index, the classifier.
///
/// Immutable; share it between threads.
pub struct Model {}

/// How a model was learned and how good it measured itself to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Exact checks spent.
    pub labels: usize,
    /// Wall time of learning [s].
    pub seconds: f64,
    /// Seed.
    pub seed: u64,
    /// Verified boundary samples stored.
    pub boundary_samples: usize,
    /// Support vectors of the classifier.
    pub support_vectors: usize,
    /// Share of uniform configurations that collide.
    pub colliding_share: f64,
    /// Held-out accuracy on free configurations.
    pub accuracy_free: f64,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: f64,
    /// Every boundary sample has a colliding configuration within this distance, in the scene's metric.
    pub boundary_gap: f64,
    /// Whether the budget of seconds, not of labels, ended learning: then the result depends on the machine.
    pub ended_by_time: bool,
}

impl Model {
    /// Learns `scene` from nothing. `progress` is called a few times a second and may stop the run.
    pub fn learn(
        scene: Scene,
        options: &LearnOptions,
        progress: &mut dyn FnMut(&LearnProgress) -> ControlFlow<()>,
    ) -> Result<Model> {
        let _ = (scene, options, progress);
        todo!()
    }

    /// The scene it was learned for.
    pub fn scene(&self) -> &Scene {
        todo!()
    }

    /// How it was learned.
    pub fn statistics(&self) -> &Statistics {
        todo!()
    }

    /// The nearest free configuration to `q`.
    pub fn query(&self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Answer {
        let _ = (q, options, scratch);
        todo!()
    }
}

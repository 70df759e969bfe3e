//! What is learned of a scene, and the two things to do with it: learn it, ask it.
//!
//! Read in this order: `learn` (the steps), `near_miss`, `solve`, `evaluate`, `learned`.

mod advice;
pub mod evaluate;
mod learn;
mod learned;
mod near_miss;
mod solve;
mod statistics;

use std::ops::ControlFlow;

use crate::error::Result;
use crate::learning::{LearnOptions, LearnProgress};
use crate::scene::Scene;
pub use learned::Model;
pub use statistics::{EndedBy, FARTHEST_DISTANCE, Statistics};

impl Model {
    /// Learns `scene` from nothing.
    ///
    /// Without a limit in seconds the result depends on scene, labels and seed alone, whatever the
    /// number of threads.
    ///
    /// # Errors
    /// [`NothingFree`](crate::Error::NothingFree) where no free configuration was found.
    pub fn learn(scene: Scene, options: &LearnOptions) -> Result<Model> {
        Self::learn_with(scene, options, &mut |_| ControlFlow::Continue(()))
    }

    /// The same. `progress` is called after every batch of labels and may stop the run, which keeps
    /// what is learned by then.
    ///
    /// # Errors
    /// Those of [`Model::learn`], and [`Interrupted`](crate::Error::Interrupted) where the caller
    /// stopped before anything free was found.
    pub fn learn_with(
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        learn::learn(scene, options, progress)
    }
}

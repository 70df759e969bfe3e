//! The learned model of a scene: how it is made, measured and read.
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
    /// Learns a model of `scene` from nothing.
    ///
    /// Without a limit in seconds the result depends on scene, labels and seed alone, whatever the
    /// number of threads.
    ///
    /// # Errors
    /// [`NothingFree`](crate::Error::NothingFree) if no free configuration was found.
    pub fn learn(scene: Scene, options: &LearnOptions) -> Result<Model> {
        Self::learn_with(scene, options, &mut |_| ControlFlow::Continue(()))
    }

    /// Does the same as [`Model::learn`]. `progress` is called after every batch of labels and may
    /// stop the run, which keeps what is learned by then.
    ///
    /// # Errors
    /// Those of [`Model::learn`], and [`Interrupted`](crate::Error::Interrupted) if the caller
    /// stopped before anything free was found.
    pub fn learn_with(
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        learn::learn(scene, options, progress)
    }
}

//! What is learned of a scene, and the two things to do with it: learn it, ask it.

pub mod adapt;
pub mod baseline;
pub mod evaluate;
mod learned;
pub mod learner;
pub(crate) mod run;
pub mod solve;
mod statistics;

use std::ops::ControlFlow;

use crate::error::Result;
use crate::learning::{LearnOptions, LearnProgress};
use crate::scene::Scene;
pub use learned::Model;
use learner::Learner;
pub use statistics::{Adapted, EndedBy, FARTHEST_DISTANCE, Statistics};

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
        let mut learner = Learner::new(scene, options)?;
        while learner.step(progress) {}
        learner.finish(progress)
    }

    /// A model of `scene`, a changed variant of this model's, from what is known of the old one.
    ///
    /// # Errors
    /// [`crate::Error::Adapt`] where robots, limits or metric differ, and those of
    /// [`Model::learn`].
    pub fn adapt(&self, scene: Scene, options: &LearnOptions) -> Result<Model> {
        self.adapt_with(scene, options, &mut |_| ControlFlow::Continue(()))
    }

    /// The same with `progress`, as [`Model::learn_with`].
    ///
    /// # Errors
    /// Those of [`Model::adapt`] and [`Model::learn_with`].
    pub fn adapt_with(
        &self,
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        adapt::adapt(self, scene, options, progress)
    }
}

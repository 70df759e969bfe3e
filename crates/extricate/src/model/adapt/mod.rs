//! A model of a changed scene from the model of the old one: what still holds is kept, what changed
//! is learned.

mod adapter;
mod carried;
pub mod scene_change;
pub mod state;

use super::learned::Model;
use super::run::work::Report;
use crate::error::Result;
use crate::learning::LearnOptions;
use crate::scene::Scene;
pub use adapter::Adapter;
use carried::origin;

/// Labels that learning spent, over those that adapting the model spends where nothing else is
/// asked for.
const LEARNING_OVER_ADAPTING: usize = 5;

/// Labels that adapting `model` spends where nothing else is requested: a fifth of what it took to
/// learn from nothing, however often it was adapted since.
pub fn labels_to_adapt(model: &Model) -> usize {
    (origin(model.statistics()).learned_labels / LEARNING_OVER_ADAPTING).max(1)
}

/// Adapts `model` to `scene`, whose obstacles or pairs differ from those of the model's scene.
///
/// Stored samples that no changed pair comes near keep what is known of them: the pairs that are
/// checked there are those of before. The others are labelled anew. Tracing then starts from them,
/// and from random configurations that a changed pair affects, in turns with exploration. Where the
/// old model has exits, or the budget is large enough for some, random colliding configurations are
/// solved with the second half of what verifying left; else tracing goes on until the budget ends.
///
/// # Guarantee
/// Every sample is free in the new scene. Of samples that were kept, a colliding configuration
/// within the gap is expected, not proved: how far a step of the gap moves a body is measured, not
/// bounded. For the rest as [`Model::learn`], with the same dependence on the options.
///
/// # Errors
/// [`Error::Adapt`](crate::Error::Adapt) where robots, limits or metric differ;
/// [`Error::Interrupted`](crate::Error::Interrupted) where the caller stopped before every sample
/// was looked at; [`Error::NothingFree`](crate::Error::NothingFree) where nothing free is known of
/// the new scene.
pub fn adapt(model: &Model, scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let mut adapter = Adapter::new(model, scene, options)?;
    while adapter.step(report) {}
    adapter.finish()
}

//! A model of a changed scene from the model of the old one: what still holds is kept, what changed is learned.

mod adapter;
pub mod state;

use super::learner::Report;
use super::{Adapted, Model, Statistics};
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::error::Result;
use crate::learning::LearnOptions;
use crate::learning::explore::Exploration;
use crate::learning::union::UnionClassifier;
use crate::scene::Scene;
pub use adapter::Adapter;

/// Labels that learning spent, over those that adapting the model spends where nothing else is asked for.
const LEARNING_OVER_ADAPTING: usize = 5;

/// A changed pair is far where it is farther apart than twice what the boundary's gap typically moves any point.
const MARGIN: f64 = 2.0;
/// Uniform configurations that the classifier is judged by.
const JUDGED: usize = 2000;
/// Batches of stored samples that are looked at in one unit of work: a tenth of a second or so.
const BATCHES_A_UNIT: usize = 16;
/// Seeds below which more are looked for: a small pass, so that passes and exploration share the budget.
const FEW_SEEDS: usize = 256;
/// Turns the seed into another one: what is explored shall not be what the old model was learned from.
const STREAM: u64 = 0x61_64_61_70_74;

/// Labels that adapting `model` spends where nothing else is asked for: a fifth of what it took to learn from nothing, however often it was adapted since.
pub fn labels_to_adapt(model: &Model) -> usize {
    (origin(&model.statistics).learned_labels / LEARNING_OVER_ADAPTING).max(1)
}

/// Adapts `model` to `scene`, whose obstacles or pairs differ from those of the model's scene.
///
/// Stored samples that no changed pair comes near keep what is known of them: the pairs that are checked there are those of
/// before. The others are labelled anew. Tracing then starts from them, and from random configurations that a changed pair
/// affects, in turns with exploration. Where the old model has exits, or the budget is large enough for some, random colliding
/// configurations are solved with the second half of what verifying left; else tracing goes on until the budget ends.
///
/// # Guarantee
/// Every sample is free in the new scene. Of samples that were kept, a colliding configuration within the gap is expected,
/// not proved: how far a step of the gap moves a body is measured, not bounded. For the rest as [`Model::learn`], with the same
/// dependence on the options.
///
/// # Errors
/// [`Error::Adapt`](crate::Error::Adapt) where robots, limits or metric differ; [`Error::Interrupted`](crate::Error::Interrupted) where the
/// caller stopped before every sample was looked at; [`Error::NothingFree`](crate::Error::NothingFree) where nothing free is known of the new scene.
pub fn adapt(model: &Model, scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let mut adapter = Adapter::new(model, scene, options)?;
    while adapter.step(report) {}
    adapter.finish()
}

/// Where a model with these statistics comes from, itself if it was learned from nothing.
fn origin(statistics: &Statistics) -> Adapted {
    statistics.adapted.unwrap_or(Adapted { learned_labels: statistics.labels, times: 0 })
}

/// `count` low-discrepancy configurations from index `first` on, row major.
fn configs_at(scene: &Scene, halton: &Halton, first: u64, count: usize) -> Vec<f64> {
    let mut configs = vec![0.0; count * scene.space.nq()];
    let rows = configs.chunks_exact_mut(scene.space.nq()).enumerate();
    rows.for_each(|(i, q)| halton.config(&scene.space, first + i as u64, q));
    configs
}

fn sort_out(configs: &[f64], labels: Vec<Label>, known: &mut Exploration, nq: usize) {
    for (q, label) in configs.chunks_exact(nq).zip(labels) {
        if label == Label::Free { &mut known.free } else { &mut known.colliding }.extend_from_slice(q);
    }
}

/// The old classifier's machines of the pairs that the new scene has too. Each sees the pose of one body relative to the other, so
/// what it learned of an obstacle holds where that has moved.
fn carried_over(model: &Model, scene: &Scene) -> Option<UnionClassifier> {
    let number = |part: u32| {
        let names = model.scene().pair_names(part as usize);
        (0..scene.pairs.len()).find(|pair| scene.pair_names(*pair) == names).map(|pair| pair as u32)
    };
    model.classifier().map(|classifier| classifier.renumbered(number))
}

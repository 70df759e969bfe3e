//! A model from uniform samples alone, which bench/learning.py measures learning against.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::Result;
use extricate::LearnOptions;
use extricate::internals::io;
use extricate::internals::model::baseline::learn_uniform;

/// Learns `scene` with `labels` labels into the file `model`, which `extricate query` takes as any
/// other.
pub fn learn(scene: &str, labels: &str, seed: &str, model: &str) -> Result<()> {
    let options =
        LearnOptions { labels: labels.parse()?, seconds: None, seed: seed.parse()?, ..LearnOptions::default() };
    let scene = io::load_scene(Path::new(scene))?;
    let learned = learn_uniform(scene, &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(io::save_model(&learned, Path::new(model))?)
}

//! A model from uniform samples alone, to measure learning against: `uniform_learning SCENE.toml LABELS SEED THREADS MODEL`. Used by
//! bench/learning.py. The model file is one that `extricate query` takes.

use std::ops::ControlFlow;
use std::path::Path;

use extricate::model::uniform::learn_uniform;
use extricate::{LearnOptions, store};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, labels, seed, threads, model] = &args[..] else {
        return Err("expected: SCENE.toml LABELS SEED THREADS MODEL".into());
    };
    let options = LearnOptions {
        labels: labels.parse()?,
        seconds: None,
        seed: seed.parse()?,
        threads: threads.parse()?,
        ..LearnOptions::default()
    };
    let learned = learn_uniform(store::load_scene(Path::new(scene))?, &options, &mut |_| ControlFlow::Continue(()))?;
    store::save_model(&learned, Path::new(model))?;
    Ok(())
}

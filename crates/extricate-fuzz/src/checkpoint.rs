//! The target of checkpoints, of `learn` and of `adapt`: what can be read goes on for two units.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::OnceLock;

use extricate::internals::io::model_file::{adapt_checkpoint, checkpoint};
use extricate::{Adapter, LearnOptions, LearnProgress, Learner, Model, Scene};

use crate::container::Container;
use crate::model::query;
use crate::scenes;

/// Labels of the runs.
const LABELS: usize = 4_000;
/// Reports of a unit before it is stopped: a checkpoint may say that the run is to go on for ever.
const REPORTS: usize = 3;
/// Units that a run goes on for.
const UNITS: usize = 2;

/// Reads a checkpoint of either kind, and goes on with the run; panics where that does, or where a
/// model comes of it that does not keep its word.
pub fn run(bytes: &[u8]) {
    let sealed = Container::open(bytes).map(|file| file.sealed());
    let _ = read(sealed.as_deref().unwrap_or(bytes));
}

/// The same, of a checkpoint whose checksum is right.
///
/// # Errors
/// The message of a checkpoint that is refused.
pub fn read(bytes: &[u8]) -> Result<(), String> {
    let path = Path::new("f");
    let is_adapt = Container::open(bytes).is_some_and(|file| file.key.ends_with("adapt"));
    let model = if is_adapt {
        let _ = adapt_checkpoint::summary(path, bytes);
        let resumed = adapt_checkpoint::decode(path, bytes, old(), moved(), 1);
        let mut adapter = resumed.map_err(|error| error.to_string())?;
        step(&mut |report| adapter.step(report));
        assert!(!adapt_checkpoint::encode(&adapter).is_empty());
        adapter.finish()
    } else {
        let _ = checkpoint::summary(path, bytes);
        let resumed = checkpoint::decode(path, bytes, scenes::scene("few"), 1);
        let mut learner = resumed.map_err(|error| error.to_string())?;
        step(&mut |report| learner.step(report));
        assert!(!checkpoint::encode(&learner).is_empty());
        learner.finish(&mut |_| ControlFlow::Break(()))
    };
    model.iter().for_each(query);
    Ok(())
}

type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

/// Goes on for some units, each of which is stopped early.
fn step(unit: &mut dyn FnMut(&mut Report) -> bool) {
    for _ in 0..UNITS {
        let mut reports = 0;
        let go_on = unit(&mut |_| {
            reports += 1;
            if reports > REPORTS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if !go_on {
            return;
        }
    }
}

fn options() -> LearnOptions {
    LearnOptions { labels: LABELS, seconds: None, seed: 3, threads: 1, ..LearnOptions::default() }
}

/// The model that is adapted.
fn old() -> &'static Model {
    static OLD: OnceLock<Model> = OnceLock::new();
    OLD.get_or_init(|| Model::learn(scenes::scene("few"), &options()).expect("something is free"))
}

/// The scene that it is adapted to.
fn moved() -> Scene {
    let mut scene = scenes::scene("few");
    let obstacles = scene.bodies.iter_mut().filter(|body| body.robot.is_none());
    obstacles.flat_map(|body| &mut body.parts).for_each(|part| part.pose_frame_part.translation.x += 0.02);
    scene
}

/// Checkpoints after every unit of a run of each kind.
pub fn corpus() -> Vec<(String, Vec<u8>)> {
    let (mut all, mut unit) = (Vec::new(), 0);
    let mut learner = Learner::new(scenes::scene("few"), &options()).expect("sound options");
    loop {
        all.push((format!("learn-{unit}"), checkpoint::encode(&learner)));
        unit += 1;
        if !learner.step(&mut |_| ControlFlow::Continue(())) {
            break;
        }
    }
    unit = 0;
    let mut adapter = Adapter::new(old(), moved(), &options()).expect("the same robot");
    loop {
        all.push((format!("adapt-{unit}"), adapt_checkpoint::encode(&adapter)));
        unit += 1;
        if !adapter.step(&mut |_| ControlFlow::Continue(())) {
            return all;
        }
    }
}

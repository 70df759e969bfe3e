//! The checkpoint of a learning run: bytes to [`Learner`] and back. No file access (see `store`).
//!
//! A container as `run_file.rs` has them: `free`, `colliding` and `samples` (rows x nq) and
//! `classified` (postcard, u8), and beside them options, where the run stood, and the scene's hash.

use std::path::Path;

use safetensors::tensor::SafeTensors;
use serde::{Deserialize, Serialize};

pub use super::run_file::is_checkpoint;
use super::run_file::{self, KEY, Kind, numbers, scene_hash};
use crate::error::{Error, Result};
use crate::learning::LearnOptions;
use crate::learning::active_learning::Classified;
use crate::learning::exploration::Exploration;
use crate::metric::relative;
use crate::model::learner::Learner;
use crate::model::run::state::{RunState, Stage, UnitEnd};
use crate::scene::Scene;

/// Version of the layout, and of the steps of learning: a run goes on only with the program that
/// began it.
pub const FORMAT: u32 = 5;

const KIND: Kind = Kind { key: KEY, verb: "learn", format: FORMAT };
const LISTS: [&str; 3] = ["free", "colliding", "samples"];

#[derive(Serialize, Deserialize)]
struct Run {
    labels: usize,
    seconds: Option<f64>,
    seed: u64,
    memory: usize,
    target_excess: Option<f64>,
    target_disagreement: Option<f64>,
    scene: String,
    colliding_share: f64,
    mark: UnitEnd,
}

impl Run {
    fn options(&self, threads: usize) -> LearnOptions {
        let Run { labels, seconds, seed, memory, target_excess, target_disagreement, .. } = *self;
        LearnOptions { labels, seconds, seed, threads, memory, target_excess, target_disagreement }
    }
}

/// What a checkpoint says of its run, for messages and for defaults.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckpointSummary {
    /// The run's options; the number of threads is not among them.
    pub options: LearnOptions,
    /// Labels spent until then.
    pub labels: usize,
}

/// The bytes of a checkpoint: the run as it was at the end of its last whole unit of work.
pub fn encode(learner: &Learner) -> Vec<u8> {
    let in_memory = "plain data serialises into memory";
    let (state, options) = (learner.state(), learner.options());
    // A unit of training that was stopped may have left something; it is no part of the state at
    // the mark.
    let trained = !matches!(state.mark.stage, Stage::Exploring | Stage::Training);
    let classified = trained.then_some(&state.classified);
    let classified = postcard::to_stdvec(&classified).expect(in_memory);
    let mut mark = state.mark.clone();
    mark.lengths = state.lists_at_mark().map(<[f64]>::len);
    let run = Run {
        labels: options.labels,
        seconds: options.seconds,
        seed: options.seed,
        memory: options.memory,
        target_excess: options.target_excess,
        target_disagreement: options.target_disagreement,
        scene: scene_hash(learner.scene()),
        colliding_share: state.colliding_share,
        mark,
    };
    let run = serde_json::to_string(&run).expect(in_memory);
    let (nq, lists) = (learner.scene().space.nq(), state.lists_at_mark());
    let lists: Vec<(&str, &[f64])> = LISTS.into_iter().zip(lists).collect();
    run_file::encode(&KIND, run, nq, &lists, &[("classified", &classified)])
}

/// What a checkpoint says of its run; `path` is its name in messages.
///
/// # Errors
/// [`Error::Checkpoint`]: foreign, truncated, altered, or of another version.
pub fn summary(path: &Path, bytes: &[u8]) -> Result<CheckpointSummary> {
    let (run, _) = read(path, bytes)?;
    Ok(CheckpointSummary { options: run.options(0), labels: run.mark.spent.labels })
}

/// Goes on with the run that `bytes` are a checkpoint of, on `threads` threads; `path` is its name
/// in messages.
///
/// # Errors
/// [`Error::Checkpoint`]: foreign, truncated, altered, of another version or of another scene.
pub fn decode(path: &Path, bytes: &[u8], scene: Scene, threads: usize) -> Result<Learner> {
    let fault = |problem: &str| Error::Checkpoint { path: path.into(), problem: problem.into() };
    let (run, tensors) = read(path, bytes)?;
    if run.scene != scene_hash(&scene) {
        return Err(fault("it belongs to another scene, or the scene was changed since: learn it from the beginning"));
    }
    let [free, colliding, samples] =
        LISTS.map(|name| tensors.tensor(name).map(|t| numbers(t.data())).unwrap_or_default());
    let classified: Option<Classified> = tensors
        .tensor("classified")
        .ok()
        .and_then(|t| postcard::from_bytes(t.data()).ok())
        .ok_or_else(|| fault("altered or damaged: classifier"))?;
    let options = run.options(threads);
    options.check().map_err(|error| fault(&format!("altered or damaged: {error}")))?;
    let Run { colliding_share, mark, .. } = run;
    let known = Exploration { free, colliding, next: mark.next };
    let classified = classified.unwrap_or_default();
    let (checks_of_quality, solved) = (mark.checks_of_quality.clone(), mark.solved.clone());
    let state = RunState { known, samples, classified, colliding_share, checks_of_quality, solved, mark };
    let sound = state.check(&scene, relative::WIDTH);
    sound.map_err(|problem| fault(&format!("altered or damaged: {problem}")))?;
    Learner::resume(scene, &options, state)
}

fn read<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Run, SafeTensors<'a>)> {
    let (run, tensors) = run_file::decode(&KIND, path, bytes, &[&LISTS[..], &["classified"]].concat())?;
    let damaged = |e| Error::Checkpoint { path: path.into(), problem: format!("altered or damaged: {e}") };
    Ok((serde_json::from_str(&run).map_err(damaged)?, tensors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::model_file;
    use crate::model::EndedBy;
    use crate::model::run::work::Report;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn scene() -> Scene {
        builtin::scene("planar-arm").unwrap()
    }

    fn learner() -> Learner {
        Learner::new(scene(), &LearnOptions { labels: 8_000, seconds: None, seed: 3, ..LearnOptions::default() })
            .unwrap()
    }

    fn go_on(_: &crate::learning::LearnProgress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn ending_by_quality() -> Learner {
        let options = LearnOptions {
            labels: 200_000,
            seconds: None,
            seed: 3,
            target_excess: Some(0.1),
            target_disagreement: Some(0.2),
            ..LearnOptions::default()
        };
        Learner::new(scene(), &options).unwrap()
    }

    fn bytes_of_the_model(mut learner: Learner) -> Vec<u8> {
        while learner.step(&mut go_on) {}
        model_file::encode(&learner.finish(&mut go_on).unwrap())
    }

    #[test]
    fn a_run_stopped_after_any_unit_ends_with_the_same_bytes() {
        let whole = bytes_of_the_model(learner());
        let (mut learner, mut units) = (learner(), 0);
        loop {
            let bytes = encode(&learner);
            let resumed = decode(Path::new("c"), &bytes, scene(), 1 + units % 2).unwrap();
            assert!(encode(&resumed) == bytes, "unit {units}");
            // Also over and over, from what was itself resumed.
            learner = resumed;
            let more = learner.step(&mut go_on);
            units += 1;
            if !more {
                break;
            }
            let resumed = decode(Path::new("c"), &encode(&learner), scene(), 2).unwrap();
            assert!(units % 3 != 0 || bytes_of_the_model(resumed) == whole, "unit {units}");
        }
        // A batch of exploration, the training, and more than one pass.
        assert!(units >= 4, "{units}");
        assert!(model_file::encode(&learner.finish(&mut go_on).unwrap()) == whole);
    }

    #[test]
    fn a_run_that_ends_by_its_quality_ends_there_after_it_was_stopped_too() {
        let whole = bytes_of_the_model(ending_by_quality());
        let model = model_file::decode(Path::new("m"), &whole).unwrap();
        let (found, excess) = (model.statistics(), model.statistics().excess.unwrap());
        assert_eq!((found.ended_by, excess.queries), (EndedBy::Quality, 64));
        assert!(found.labels < 200_000, "{found:?}");
        // Fresh ones, of which more than one in twenty may be beyond by chance.
        assert!(excess.within_5pct > 0.8, "{excess:?}");
        let mut learner = ending_by_quality();
        while learner.step(&mut go_on) {
            learner = decode(Path::new("c"), &encode(&learner), scene(), 1).unwrap();
        }
        assert!(model_file::encode(&learner.finish(&mut go_on).unwrap()) == whole);
    }

    #[test]
    fn a_unit_that_is_interrupted_is_no_part_of_the_checkpoint() {
        let whole = bytes_of_the_model(learner());
        for most_reports in [1, 3, 5, 9, 24, 40] {
            let (mut learner, mut reports) = (learner(), 0);
            let report: &mut Report = &mut |_| {
                reports += 1;
                if reports >= most_reports { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            while learner.step(report) {}
            let resumed = decode(Path::new("c"), &encode(&learner), scene(), 2).unwrap();
            assert!(resumed.state().mark.spent.labels <= 8_000);
            assert!(bytes_of_the_model(resumed) == whole, "{most_reports} reports");
            // What was stopped is a model too, unless nothing free had been seen.
            let stopped = learner.finish(&mut go_on);
            assert!(stopped.is_ok() || most_reports < 3, "{most_reports} reports");
        }
    }

    #[test]
    fn damaged_and_foreign_checkpoints_are_refused() {
        let mut learner = learner();
        while learner.step(&mut go_on) && learner.state().samples.is_empty() {}
        let bytes = encode(&learner);
        let refused = |bytes: &[u8]| decode(Path::new("my.checkpoint"), bytes, scene(), 1).err().map(|e| e.to_string());
        for length in [0, 1, 7, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(refused(&bytes[..length]).expect("a truncated file is refused").contains("my.checkpoint"));
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 200) {
            let mut altered = bytes.clone();
            altered[at] ^= 0x10;
            assert!(refused(&altered).is_some(), "byte {at} altered without notice");
        }
        let other = decode(Path::new("c"), &bytes, builtin::scene("free-box").unwrap(), 1).err().unwrap();
        assert!(other.to_string().contains("another scene"), "{other}");
        let model = model_file::encode(&learner.finish(&mut go_on).unwrap());
        assert!(refused(&model).unwrap().contains("not a checkpoint"));
        assert!(model_file::decode(Path::new("m"), &bytes).is_err());
        assert!(is_checkpoint(&bytes) && !is_checkpoint(&model) && !model_file::is_model(&bytes));
    }
}

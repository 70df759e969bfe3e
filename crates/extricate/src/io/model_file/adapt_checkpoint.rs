//! The checkpoint of a run that adapts a model: bytes to [`Adapter`] and back. No file access (see
//! `store`).
//!
//! A container as `run_file.rs` has them, of the lists of the run's state, and beside them options,
//! where the run stood, and the hashes of the old model and the new scene, which have to be given
//! again.

use std::path::Path;

use safetensors::tensor::SafeTensors;
use serde::{Deserialize, Serialize};

use super::checkpoint::CheckpointSummary;
use super::run_file::{self, Kind, numbers, scene_hash};
use crate::error::{Error, Result};
use crate::learning::LearnOptions;
use crate::model::Model;
use crate::model::adapt::Adapter;
use crate::model::adapt::state::{AdaptMark, AdaptState, LISTS};
use crate::scene::Scene;

/// Version of the layout, and of the steps of adapting: a run goes on only with the program that
/// began it.
pub const FORMAT: u32 = 1;

const KIND: Kind = Kind { key: "extricate-checkpoint-adapt", verb: "adapt", format: FORMAT };

#[derive(Serialize, Deserialize)]
struct Run {
    labels: usize,
    seconds: Option<f64>,
    seed: u64,
    memory: usize,
    model: String,
    scene: String,
    mark: AdaptMark,
}

impl Run {
    fn options(&self, threads: usize) -> LearnOptions {
        let Run { labels, seconds, seed, memory, .. } = *self;
        LearnOptions { labels, seconds, seed, threads, memory, target_excess: None, target_disagreement: None }
    }
}

/// The bytes of a checkpoint: the run as it was at the end of its last whole unit of work.
pub fn encode(adapter: &Adapter) -> Vec<u8> {
    let (state, options) = (adapter.state(), adapter.options());
    let run = Run {
        labels: options.labels,
        seconds: options.seconds,
        seed: options.seed,
        memory: options.memory,
        model: super::identity(adapter.old()),
        scene: scene_hash(adapter.scene()),
        mark: state.mark.clone(),
    };
    let run = serde_json::to_string(&run).expect("plain data serialises into memory");
    let lists: Vec<(&str, &[f64])> = LISTS.into_iter().zip(state.lists_at_mark()).collect();
    run_file::encode(&KIND, run, adapter.scene().space.nq(), &lists, &[])
}

/// What a checkpoint says of its run; `path` is its name in messages.
///
/// # Errors
/// [`Error::Checkpoint`]: foreign, truncated, altered, or of another version.
pub fn summary(path: &Path, bytes: &[u8]) -> Result<CheckpointSummary> {
    let (run, _) = read(path, bytes)?;
    Ok(CheckpointSummary { options: run.options(0), labels: run.mark.spent.labels })
}

/// Goes on with the run of `old` and `scene` that `bytes` are a checkpoint of, on `threads`
/// threads; `path` is its name in messages.
///
/// # Errors
/// [`Error::Checkpoint`]: foreign, truncated, altered, of another version, model or scene; and
/// those of [`Adapter::new`].
pub fn decode<'a>(path: &Path, bytes: &[u8], old: &'a Model, scene: Scene, threads: usize) -> Result<Adapter<'a>> {
    let fault = |problem: &str| Error::Checkpoint { path: path.into(), problem: problem.into() };
    let (run, tensors) = read(path, bytes)?;
    for (then, now, what) in [(&run.model, super::identity(old), "model"), (&run.scene, scene_hash(&scene), "scene")] {
        if *then != now {
            let again = "or it was changed since: adapt from the beginning";
            return Err(fault(&format!("it belongs to another {what}, {again}")));
        }
    }
    let lists = LISTS.map(|name| tensors.tensor(name).map(|t| numbers(t.data())).unwrap_or_default());
    let options = run.options(threads);
    options.check().map_err(|error| fault(&format!("altered or damaged: {error}")))?;
    let state = AdaptState::at(run.mark, lists);
    let stored = old.boundary().len() - old.statistics().stand_ins;
    let sound = state.check(&scene.space, stored);
    sound.map_err(|problem| fault(&format!("altered or damaged: {problem}")))?;
    Adapter::resume(old, scene, &options, state)
}

fn read<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Run, SafeTensors<'a>)> {
    let (run, tensors) = run_file::decode(&KIND, path, bytes, &LISTS)?;
    let damaged = |e| Error::Checkpoint { path: path.into(), problem: format!("altered or damaged: {e}") };
    Ok((serde_json::from_str(&run).map_err(damaged)?, tensors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::model_file;
    use crate::learning::LearnProgress;
    use crate::model::EndedBy;
    use crate::model::adapt::state::AdaptStage;
    use crate::model::run::work::Report;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn go_on(_: &LearnProgress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn old() -> Model {
        let options = LearnOptions { labels: 90_000, seconds: None, seed: 3, ..LearnOptions::default() };
        Model::learn_with(builtin::scene("planar-arm").unwrap(), &options, &mut go_on).unwrap()
    }

    fn scene() -> Scene {
        let mut moved = builtin::scene("planar-arm").unwrap();
        let obstacle = moved.bodies.iter_mut().find(|body| body.robot.is_none()).unwrap();
        obstacle.parts.iter_mut().for_each(|part| part.pose_frame_part.translation.x += 0.03);
        moved
    }

    fn adapter(old: &Model) -> Adapter<'_> {
        let options = LearnOptions { labels: 18_000, seconds: None, seed: 3, ..LearnOptions::default() };
        Adapter::new(old, scene(), &options).unwrap()
    }

    fn bytes_of_the_model(mut adapter: Adapter) -> Vec<u8> {
        while adapter.step(&mut go_on) {}
        model_file::encode(&adapter.finish().unwrap())
    }

    #[test]
    fn a_run_stopped_after_any_unit_ends_with_the_same_bytes() {
        let old = old();
        let whole = bytes_of_the_model(adapter(&old));
        let (mut adapter, mut units, mut stages) = (adapter(&old), 0, Vec::new());
        loop {
            let bytes = encode(&adapter);
            // Also over and over, from what was itself resumed.
            let resumed = decode(Path::new("c"), &bytes, &old, scene(), 1 + units % 2).unwrap();
            assert!(encode(&resumed) == bytes, "unit {units}");
            stages.push(resumed.state().mark.stage.name());
            adapter = resumed;
            let more = adapter.step(&mut go_on);
            units += 1;
            if !more {
                break;
            }
            let resumed = decode(Path::new("c"), &encode(&adapter), &old, scene(), 2).unwrap();
            assert!(units % 3 != 0 || bytes_of_the_model(resumed) == whole, "unit {units}");
        }
        stages.dedup();
        assert_eq!(stages, ["verifying samples", "tracing what changed", "solving", "measuring"]);
        assert!(model_file::encode(&adapter.finish().unwrap()) == whole);
    }

    #[test]
    fn a_unit_that_is_interrupted_is_no_part_of_the_checkpoint() {
        let old = old();
        let whole = bytes_of_the_model(adapter(&old));
        for most_reports in [1, 3, 5, 9, 24, 40, 60] {
            let (mut adapter, mut reports) = (adapter(&old), 0);
            let report: &mut Report = &mut |_| {
                reports += 1;
                if reports >= most_reports { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            while adapter.step(report) {}
            let resumed = decode(Path::new("c"), &encode(&adapter), &old, scene(), 2).unwrap();
            assert!(bytes_of_the_model(resumed) == whole, "{most_reports} reports");
            // What was stopped is a model too, once every sample was looked at.
            let verified = adapter.state().mark.stage != AdaptStage::Verifying;
            let stopped = adapter.finish();
            assert_eq!(stopped.is_ok(), verified, "{most_reports} reports");
            if let Ok(model) = stopped {
                let ended = model.statistics().ended_by;
                assert!(
                    ended == EndedBy::Interruption || model_file::encode(&model) == whole,
                    "{most_reports} reports"
                );
            }
        }
    }

    #[test]
    fn a_run_ends_where_its_memory_is_full() {
        let old = old();
        let rows = old.boundary().len();
        for share in [0.1, 1.2] {
            let least = (rows as f64 * share) as usize * 8 * old.scene().space.nq();
            let options = LearnOptions { memory: 4 * least, ..adapter(&old).options().clone() };
            let mut adapter = Adapter::new(&old, scene(), &options).unwrap();
            while adapter.step(&mut go_on) {}
            let statistics = adapter.finish().unwrap().statistics().clone();
            assert_eq!(statistics.ended_by, EndedBy::Memory, "{share}");
            assert!(statistics.labels < options.labels && statistics.accuracy_free.is_some(), "{statistics:?}");
        }
    }

    #[test]
    fn damaged_and_foreign_checkpoints_are_refused() {
        let old = old();
        let mut adapter = adapter(&old);
        while adapter.step(&mut go_on) && adapter.state().mark.stage != AdaptStage::Solving {}
        let bytes = encode(&adapter);
        let refused =
            |bytes: &[u8]| decode(Path::new("my.checkpoint"), bytes, &old, scene(), 1).err().map(|e| e.to_string());
        assert_eq!(refused(&bytes), None);
        for length in [0, 1, 7, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(refused(&bytes[..length]).expect("a truncated file is refused").contains("my.checkpoint"));
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 200) {
            let mut altered = bytes.clone();
            altered[at] ^= 0x10;
            assert!(refused(&altered).is_some(), "byte {at} altered without notice");
        }
        let other = decode(Path::new("c"), &bytes, &old, builtin::scene("planar-arm").unwrap(), 1).err().unwrap();
        assert!(other.to_string().contains("another scene"), "{other}");
        let options = LearnOptions { labels: 2_000, seconds: None, ..LearnOptions::default() };
        let another = Model::learn_with(builtin::scene("planar-arm").unwrap(), &options, &mut go_on).unwrap();
        let other = decode(Path::new("c"), &bytes, &another, scene(), 1).err().unwrap();
        assert!(other.to_string().contains("another model"), "{other}");
        let of_learning = crate::model::learner::Learner::new(scene(), &options).unwrap();
        let of_learning = model_file::checkpoint::encode(&of_learning);
        assert!(refused(&of_learning).unwrap().contains("not a checkpoint of `adapt`"));
        let learn = model_file::checkpoint::summary(Path::new("c"), &bytes).unwrap_err().to_string();
        assert!(learn.contains("a checkpoint of another kind of run, but not a checkpoint of `learn`"), "{learn}");
    }
}

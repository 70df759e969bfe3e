//! A run that learns or adapts, with a progress bar, Ctrl-C and checkpoints.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::bail;
use clap::Args;
use extricate::internals::io::model_file::checkpoint::CheckpointSummary;
use extricate::internals::io::{self, OutputLock};
use extricate::internals::model::adapt::Adapter;
use extricate::{LearnProgress, Learner, Model};

use crate::args::seconds_or_zero;
use crate::interrupt::{self, StopOnInterrupt};
use crate::notice;
use crate::progress::Progress;
use crate::report::{count, percent};

/// Where a run is kept, on the command line.
#[derive(Args, Default)]
#[command(next_help_heading = "Checkpoint")]
pub struct KeepArgs {
    /// Go on with the run that the checkpoint was left by: the same files and options as then
    #[arg(long)]
    pub resume: bool,
    /// Where the run is stored while it lasts; removed at its end [default: the model to write with
    /// `.checkpoint` behind]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Least seconds between two checkpoints; 0 writes one after every unit of work
    #[arg(long, value_name = "T", default_value_t = 15.0, value_parser = seconds_or_zero, allow_negative_numbers = true)]
    checkpoint_every: f64,
}

impl KeepArgs {
    /// Where the run that reads `inputs` and writes `model` is kept.
    pub fn keep(&self, model: &Path, inputs: &[&PathBuf]) -> anyhow::Result<Keep> {
        let beside = || {
            let mut name = model.as_os_str().to_os_string();
            name.push(".checkpoint");
            name.into()
        };
        let path = self.checkpoint.clone().unwrap_or_else(beside);
        if io::is_same_output(model, &path) {
            bail!("--checkpoint: got {}, which is the model to write, expected another file", path.display());
        }
        for output in [model, &path] {
            io::check_not_read(output, inputs.iter().map(|input| input.as_path()))?;
        }
        io::check_checkpoint_output(&path)?;
        let locks = vec![OutputLock::take(model)?, OutputLock::take(&path)?];
        Ok(Keep { path, every: Duration::from_secs_f64(self.checkpoint_every), _locks: locks })
    }
}

/// Where a run is stored while it lasts.
pub struct Keep {
    /// The checkpoint file.
    pub path: PathBuf,
    /// Least time between two checkpoints.
    pub every: Duration,
    /// Of both files: two runs that share one would take turns in spoiling it.
    _locks: Vec<OutputLock>,
}

/// A model, and what its file does not hold because it differs from run to run.
pub struct Learned {
    /// The model.
    pub model: Model,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Whether the user ended it early; its checkpoint, if it is kept, was then written.
    pub interrupted: bool,
}

impl Keep {
    /// Warns where a run that was kept here will be lost; `summary` is what the file says, if it is
    /// a checkpoint of this kind of run.
    pub fn warn_of_another(&self, summary: extricate::Result<CheckpointSummary>) {
        if let Ok(left) = summary {
            notice::warning(format_args!(
                "{} holds an unfinished run of {} labels, which this one will replace; --resume goes on with it",
                self.path.display(),
                count(left.labels)
            ));
        }
    }

    /// Fails where an option that was given is not that with which the run was begun: its name,
    /// what was given, and what it was then.
    pub fn expect_as_begun<const N: usize>(&self, options: [(&str, Option<String>, String); N]) -> anyhow::Result<()> {
        for (name, given, then) in options {
            if let Some(given) = given.filter(|given| *given != then) {
                bail!("--{name}: got {given}, but the run in {} was begun with {then}", self.path.display());
            }
        }
        Ok(())
    }

    /// Returns whether the run is kept now; one that cannot be is worth going on with all the same.
    fn save(&self, run: &impl Run) -> bool {
        let saved = run.save(&self.path);
        if let Err(error) = &saved {
            notice::warning(format_args!("no checkpoint: {error}"));
        }
        saved.is_ok()
    }
}

/// A run in units of work.
pub trait Run {
    /// As progress names it.
    const TITLE: &'static str;
    /// Does a unit; whether there is more to do.
    fn step(&mut self, report: &mut Report) -> bool;
    /// Writes a checkpoint.
    fn save(&self, path: &Path) -> extricate::Result<()>;
    /// The model of what was found.
    fn finish(self, report: &mut Report) -> extricate::Result<Model>;
}

type Report<'a> = dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send + 'a;

impl Run for Learner {
    const TITLE: &'static str = "learning";

    fn step(&mut self, report: &mut Report) -> bool {
        self.step(report)
    }

    fn save(&self, path: &Path) -> extricate::Result<()> {
        io::save_checkpoint(self, path)
    }

    fn finish(self, report: &mut Report) -> extricate::Result<Model> {
        self.finish(report)
    }
}

impl Run for Adapter<'_> {
    const TITLE: &'static str = "adapting";

    fn step(&mut self, report: &mut Report) -> bool {
        self.step(report)
    }

    fn save(&self, path: &Path) -> extricate::Result<()> {
        io::save_adapt_checkpoint(self, path)
    }

    fn finish(self, _: &mut Report) -> extricate::Result<Model> {
        self.finish()
    }
}

/// Works to the end, or until Ctrl-C, which keeps what was found.
pub fn run_with_progress<R: Run>(mut run: R, keep: Option<&Keep>) -> anyhow::Result<Learned> {
    let started = Instant::now();
    let stop = StopOnInterrupt::new();
    let mut progress = Progress::new(R::TITLE);
    let mut report = |state: &LearnProgress| {
        progress.update(Some(state.fraction), || in_words(state));
        if stop.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut kept = Instant::now();
    while run.step(&mut report) {
        if let Some(keep) = keep
            && kept.elapsed() >= keep.every
        {
            keep.save(&run);
            kept = Instant::now();
        }
    }
    let is_saved = stop.asked() && keep.is_some_and(|keep| keep.save(&run));
    let model = run.finish(&mut report);
    drop(progress);
    let (model, interrupted) = match (model, keep) {
        (Err(error), Some(keep)) if is_saved => {
            return Err(anyhow::Error::from(error).context(kept_at(keep)));
        }
        (model, _) => (model?, stop.asked()),
    };
    if interrupted {
        let labels = count(model.statistics().labels);
        notice::warning(format_args!("stopped by the user; keeping the model learned so far ({labels} labels)"));
    }
    Ok(Learned { model, seconds: started.elapsed().as_secs_f64(), interrupted })
}

/// Writes the model, and removes the checkpoint of a run that is over.
pub fn save(learned: &Learned, model: &Path, keep: &Keep) -> extricate::Result<()> {
    interrupt::uninterrupted(|| {
        io::save_model(&learned.model, model)?;
        if learned.interrupted { Ok(()) } else { io::remove_checkpoint(&keep.path) }
    })
}

/// What to do with a run that was stopped.
pub fn kept_at(keep: &Keep) -> String {
    format!("wrote {}; the same command with --resume goes on from there", keep.path.display())
}

/// `, with 123 MiB at most`, where the system says how much memory it took.
pub fn memory_in_words() -> String {
    peak_memory().map_or(String::new(), |bytes| format!(", with {} MiB at most", count(bytes as usize >> 20)))
}

fn in_words(state: &LearnProgress) -> String {
    let accuracy = state.accuracy.map_or(String::new(), |a| format!(", accuracy {}", percent(a)));
    let (labels, samples) = (count(state.labels), count(state.boundary_samples));
    format!("{}: {labels} labels, {samples} boundary samples{accuracy}", state.stage)
}

/// The most memory that this process ever had \[bytes\]; `None` where the system does not say.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_reads_well() {
        let mut state =
            LearnProgress { stage: "exploring", fraction: 0.1, labels: 1500, boundary_samples: 30, accuracy: None };
        assert_eq!(in_words(&state), "exploring: 1,500 labels, 30 boundary samples");
        state.accuracy = Some(0.953);
        assert!(in_words(&state).ends_with("accuracy 95.3 %"));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn peak_memory_grows_with_use() {
        let before = peak_memory().unwrap();
        let used = std::hint::black_box(vec![1u8; 200 << 20]);
        assert!(peak_memory().unwrap() >= (used.len() as u64).max(before));
    }
}

//! Learning runs: the function `learn`, and adapting a model.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use extricate::internals::io::{self, OutputLock};
use extricate::internals::model::adapt::labels_to_adapt;
use extricate::{Error, LearnOptions, Learner};
use pyo3::exceptions::{PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;

use super::Model;
use super::progress::Listener;
use crate::error::{Seed, Whole, count, exception, threads};
use crate::long_call;
use crate::scene::Scene;

/// Most labels, most seconds, seed and threads, as all runs take them.
pub struct Budget {
    labels: Option<usize>,
    seconds: Option<f64>,
    seed: Option<u64>,
    threads: usize,
}

impl Budget {
    /// From arguments of Python.
    ///
    /// # Errors
    /// `ValueError` that says what was expected.
    pub fn new(labels: Option<Whole>, seconds: Option<f64>, seed: Option<Seed>, thread_count: i64) -> PyResult<Self> {
        if let Some(bad) = seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return Err(PyValueError::new_err(format!("seconds: got {bad}, expected more than 0")));
        }
        let labels = labels.map(|labels| count("labels", labels, 1)).transpose()?;
        Ok(Self { labels, seconds, seed: seed.map(|Seed(seed)| seed), threads: threads(thread_count)? })
    }
}

/// Learns a scene: all that queries need.
///
/// labels: most exact collision checks to spend; 500,000 where None.
/// seconds: most seconds to spend; where None, 90, or without limit where `labels` is given.
/// Without a limit in seconds the model depends on scene, seed and options alone.
/// seed: of all random numbers; 0 where None.
/// threads: 0 for one per core. The model does not depend on it.
/// memory: most memory for what is found [MiB], where learning ends; 4096 where None.
/// target_excess: ends learning where at least 95 % of 64 held-out queries are at most this much
/// farther than those of a search about ten times as long (0.05: 5 %).
/// target_disagreement: ends learning where the classifier is wrong on at most this share of what
/// was held out; with both, both have to hold.
/// progress: True for a bar (tqdm's, if it is installed), False for none, None for one if stderr is
/// a terminal, or a function that is called with a `Progress` about twenty times a second, on the
/// calling thread; where it returns False, learning ends early and what was learned is kept.
/// checkpoint: a file that keeps the run while it lasts, written anew now and then and where it is
/// ended early, removed at its own end.
/// checkpoint_every: least time between two of them [s]; 0: after every unit of work.
/// resume: go on with the run in `checkpoint`, to the same model as if it had never been stopped.
/// Options that are given have to be those of that run.
///
/// Ctrl-C ends learning with KeyboardInterrupt; what was learned is then lost, but for what
/// `checkpoint` keeps. Raises RuntimeError where no free configuration was found, ValueError for
/// options that make no sense, OSError where the checkpoint cannot be read or written.
#[pyfunction]
#[pyo3(signature = (scene, *, labels = None, seconds = None, seed = None, threads = 0, memory = None, target_excess = None,
    target_disagreement = None, progress = None, checkpoint = None, checkpoint_every = 15.0, resume = false))]
pub fn learn(
    py: Python<'_>,
    scene: &Scene,
    labels: Option<Whole>,
    seconds: Option<f64>,
    seed: Option<Seed>,
    threads: i64,
    memory: Option<Whole>,
    target_excess: Option<f64>,
    target_disagreement: Option<f64>,
    progress: Option<Bound<'_, PyAny>>,
    checkpoint: Option<PathBuf>,
    checkpoint_every: f64,
    resume: bool,
) -> PyResult<Model> {
    let budget = Budget::new(labels, seconds, seed, threads)?;
    let memory = memory.map(|mib| count("memory", mib, 1)).transpose()?.map(|mib| mib.saturating_mul(1 << 20));
    let wanted = Wanted { budget, memory, target_excess, target_disagreement };
    let keep = checkpoint.map(|path| Keep::new(path, checkpoint_every)).transpose()?;
    if resume && keep.is_none() {
        return Err(PyValueError::new_err("resume: got True without `checkpoint`, expected the file to go on from"));
    }
    let copy = (**scene.inner()).clone();
    let learner = long_call::pooled(py, || match &keep {
        Some(keep) if resume => wanted.go_on(copy, &keep.path),
        _ => Learner::new(copy, &wanted.options()).map_err(exception),
    })??;
    let listener = Listener::new(py, progress.as_ref())?;
    let hear = |py: Python<'_>, state| {
        keep.as_ref().map_or(Ok(()), |keep| keep.warn(py)).and_then(|()| listener.hear(py, state))
    };
    let learned = long_call::run(py, hear, |line| run(learner, keep.as_ref(), line, &listener));
    listener.close(py, learned.is_ok())?;
    let model = learned?.map_err(exception)?;
    keep.map_or(Ok(()), |keep| keep.warn(py))?;
    Ok(Model::of(model))
}

/// Steps a run to its end, or to where Python ends it.
fn run(
    mut learner: Learner,
    keep: Option<&Keep>,
    line: &long_call::Line<extricate::LearnProgress>,
    listener: &Listener,
) -> extricate::Result<extricate::Model> {
    let ended = || line.stopped() || listener.has_enough();
    let mut report = |state: &extricate::LearnProgress| {
        line.tell(state.clone());
        if ended() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut kept = Instant::now();
    while learner.step(&mut report) {
        if let Some(keep) = keep.filter(|keep| kept.elapsed() >= keep.every) {
            keep.save(&learner);
            kept = Instant::now();
        }
    }
    if let Some(keep) = keep.filter(|_| ended()) {
        keep.save(&learner);
    }
    // Nobody will see the model.
    if line.stopped() {
        return Err(Error::Interrupted);
    }
    let model = learner.finish(&mut report)?;
    if let Some(keep) = keep.filter(|_| !ended()) {
        io::remove_checkpoint(&keep.path)?;
    }
    Ok(model)
}

/// `model` for `scene`, see `Model.adapt`.
pub fn adapt(
    py: Python<'_>,
    model: &extricate::Model,
    scene: &Scene,
    budget: Budget,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Model> {
    let options = LearnOptions {
        labels: budget.labels.unwrap_or_else(|| labels_to_adapt(model)),
        seconds: budget.seconds,
        seed: budget.seed.unwrap_or_default(),
        threads: budget.threads,
        ..LearnOptions::default()
    };
    let copy = (**scene.inner()).clone();
    let (pool, listener) = (long_call::pool(options.threads)?, Listener::new(py, progress)?);
    let adapted = long_call::run(
        py,
        |py, state| listener.hear(py, state),
        |line| {
            let mut report = |state: &extricate::LearnProgress| {
                line.tell(state.clone());
                let ended = line.stopped() || listener.has_enough();
                if ended { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            // What changed is prepared before the run has a pool.
            pool.install(|| model.adapt_with(copy, &options, &mut report))
        },
    );
    listener.close(py, adapted.as_ref().is_ok_and(Result::is_ok))?;
    Ok(Model::of(adapted?.map_err(exception)?))
}

/// What `learn` was asked for; `None` where nothing was said.
struct Wanted {
    budget: Budget,
    /// Bytes.
    memory: Option<usize>,
    target_excess: Option<f64>,
    target_disagreement: Option<f64>,
}

impl Wanted {
    fn options(&self) -> LearnOptions {
        let (Self { budget, target_excess, target_disagreement, .. }, default) = (self, LearnOptions::default());
        LearnOptions {
            // Who counts labels wants a model that another machine learns too; a silent time limit
            // would break that.
            seconds: if budget.labels.is_some() { budget.seconds } else { budget.seconds.or(default.seconds) },
            labels: budget.labels.unwrap_or(default.labels),
            seed: budget.seed.unwrap_or(default.seed),
            threads: budget.threads,
            memory: self.memory.unwrap_or(default.memory),
            target_excess: *target_excess,
            target_disagreement: *target_disagreement,
        }
    }

    /// The run that the checkpoint at `path` was left by, where it is the one that is wanted.
    fn go_on(&self, scene: extricate::Scene, path: &Path) -> PyResult<Learner> {
        let begun = io::checkpoint_summary(path).map_err(exception)?.options;
        let whole = |number: usize| number.to_string();
        let real = |number: f64| number.to_string();
        let Self { budget, memory, .. } = self;
        for (name, given, then) in [
            ("labels", budget.labels.map(whole), Some(whole(begun.labels))),
            ("seconds", budget.seconds.map(real), begun.seconds.map(real)),
            ("seed", budget.seed.map(|seed| seed.to_string()), Some(begun.seed.to_string())),
            ("memory", memory.map(|bytes| whole(bytes >> 20)), Some(whole(begun.memory >> 20))),
            ("target_excess", self.target_excess.map(real), begun.target_excess.map(real)),
            ("target_disagreement", self.target_disagreement.map(real), begun.target_disagreement.map(real)),
        ] {
            if let Some(given) = given.filter(|given| Some(given) != then.as_ref()) {
                let (then, file) = (then.unwrap_or("None".into()), path.display());
                let message = format!("{name}: got {given}, expected {then}, with which the run in {file} was begun");
                return Err(PyValueError::new_err(message));
            }
        }
        io::load_checkpoint(path, scene, budget.threads).map_err(exception)
    }
}

/// Where a run is kept while it lasts.
struct Keep {
    path: PathBuf,
    /// Two runs that share the file would take turns in spoiling it.
    _lock: OutputLock,
    /// Least time between two checkpoints.
    every: Duration,
    /// What went wrong: a run that cannot be kept is worth going on with all the same.
    failure: Mutex<Option<String>>,
}

impl Keep {
    fn new(path: PathBuf, every: f64) -> PyResult<Self> {
        if !(0.0..1e9).contains(&every) {
            let message = format!("checkpoint_every: got {every}, expected a number of seconds, 0 or more");
            return Err(PyValueError::new_err(message));
        }
        io::check_checkpoint_output(&path).map_err(exception)?;
        let lock = OutputLock::take(&path).map_err(exception)?;
        Ok(Self { path, _lock: lock, every: Duration::from_secs_f64(every), failure: Mutex::default() })
    }

    fn save(&self, learner: &Learner) {
        if let Err(error) = io::save_checkpoint(learner, &self.path) {
            *self.failure.lock().expect(UNPOISONED) = Some(format!("no checkpoint: {error}"));
        }
    }

    /// Passes on what went wrong since the last call, as a warning.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let Some(failure) = self.failure.lock().expect(UNPOISONED).take() else { return Ok(()) };
        let text = std::ffi::CString::new(failure).unwrap_or_default();
        PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
    }
}

const UNPOISONED: &str = "never poisoned: nothing panics while it is held";

//! The function `learn`, with progress and Ctrl-C.

use std::ops::ControlFlow;

use extricate::{Error, LearnOptions};
use pyo3::prelude::*;

use super::Model;
use super::progress::Listener;
use crate::error::{Seed, Whole, count, exception, threads};
use crate::long_call;
use crate::scene::Scene;

/// Learns a scene: all that queries need.
///
/// labels: most exact collision checks to spend; 160,000 if None.
/// seconds: most seconds to spend; if None, 5, or without limit if `labels` is given.
/// Without a limit in seconds the model depends on scene, seed and labels alone.
/// seed: of all random numbers; 0 if None.
/// threads: 0 for one per core. The model does not depend on it.
/// progress: True for a bar (tqdm's, if it is installed), False for none, None for one if stderr is
/// a terminal, or a function that is called with a `Progress` about twenty times a second, on the
/// calling thread; if it returns False, learning ends early and what was learned is kept.
///
/// Ctrl-C ends learning with KeyboardInterrupt; what was learned is then lost. Raises RuntimeError
/// if no free configuration was found, ValueError for options that make no sense.
#[pyfunction]
#[pyo3(signature = (scene, *, labels = None, seconds = None, seed = None, threads = 0, progress = None))]
pub fn learn(
    py: Python<'_>,
    scene: &Scene,
    labels: Option<Whole>,
    seconds: Option<f64>,
    seed: Option<Seed>,
    threads: i64,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Model> {
    let options = options(labels, seconds, seed, threads)?;
    let copy = (**scene.inner()).clone();
    let listener = Listener::new(py, progress.as_ref())?;
    let learned = long_call::run(
        py,
        |py, state| listener.hear(py, state),
        |line| {
            let mut report = |state: &extricate::LearnProgress| {
                line.tell(state.clone());
                if listener.has_enough() { ControlFlow::Break(()) } else { line.flow() }
            };
            let model = extricate::Model::learn_with(copy, &options, &mut report)?;
            // A call that was stopped raises, so that nobody gets its model.
            if line.stopped() { Err(Error::Interrupted) } else { Ok(model) }
        },
    );
    listener.close(py, learned.is_ok())?;
    Ok(Model::of(learned?.map_err(exception)?.into()))
}

/// Reads the options of a run from the arguments of `learn`.
///
/// # Errors
/// `ValueError` that says what was expected.
fn options(
    labels: Option<Whole>,
    seconds: Option<f64>,
    seed: Option<Seed>,
    thread_count: i64,
) -> PyResult<LearnOptions> {
    let mut options = LearnOptions::default().threads(threads(thread_count)?);
    // A caller who gives `labels` wants the same model on every machine, which a default limit of
    // time would break.
    if labels.is_some() || seconds.is_some() {
        options.seconds = seconds;
    }
    if let Some(labels) = labels {
        options.labels = count("labels", labels, 1)?;
    }
    if let Some(Seed(seed)) = seed {
        options.seed = seed;
    }
    Ok(options)
}

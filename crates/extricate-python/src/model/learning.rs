//! The function `learn`, with progress and Ctrl-C.

use std::ops::ControlFlow;

use extricate::{Error, LearnOptions};
use pyo3::prelude::*;

use super::Model;
use super::progress::Listener;
use crate::error::{Seed, Whole, count, exception, threads};
use crate::long_call;
use crate::scene::Scene;

/// Learns a scene and returns its model, which holds all that queries need.
///
/// labels: most exact collision checks to spend; None is 160,000.
/// seconds: most seconds to spend; None is 5, or no limit if `labels` is given. Without a limit in
///     seconds the model depends on scene, seed and labels alone.
/// seed: seed of all random numbers; None is 0.
/// threads: 0 for one per core. The model does not depend on it.
/// progress: True shows a bar (tqdm's, if it is installed), False none, None a bar if stderr is a
///     terminal. A function is called with a `Progress` about twenty times a second, on the calling
///     thread; if it returns False, learning ends early and keeps what it learned.
///
/// Ctrl-C ends learning with KeyboardInterrupt and loses what it learned. Raises RuntimeError if no
/// free configuration was found, ValueError for options that make no sense.
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

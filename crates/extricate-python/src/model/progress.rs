//! Passes the progress of a learning run to Python.

use std::sync::atomic::{AtomicBool, Ordering};

use extricate::LearnProgress;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// The state of a learning run.
#[pyclass(frozen, get_all, module = "extricate._extricate")]
pub struct Progress {
    /// The current step: "exploring", "training", "tracing the boundary", "solving", "measuring".
    stage: &'static str,
    /// Share of the budget spent, 0 to 1.
    fraction: f64,
    /// Labels (exact checks) spent.
    labels: usize,
    /// Boundary samples found.
    boundary_samples: usize,
    /// Held-out balanced accuracy of the last classifier; None before the first.
    accuracy: Option<f64>,
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        let Self { stage, fraction, labels, boundary_samples, accuracy } = self;
        let accuracy = accuracy.map_or("None".into(), |accuracy| accuracy.to_string());
        format!(
            "Progress(stage={stage:?}, fraction={fraction}, labels={labels}, boundary_samples={boundary_samples}, accuracy={accuracy})"
        )
    }
}

impl From<LearnProgress> for Progress {
    fn from(state: LearnProgress) -> Self {
        let LearnProgress { stage, fraction, labels, boundary_samples, accuracy, .. } = state;
        Self { stage, fraction, labels, boundary_samples, accuracy }
    }
}

/// Receiver of the progress of a run: nobody, a bar, or a function that may end the run.
#[derive(Default)]
pub struct Listener {
    function: Option<Py<PyAny>>,
    /// Whether `function` is a bar of ours, which has to be closed.
    is_bar: bool,
    enough: AtomicBool,
}

impl Listener {
    /// Reads the argument `progress`: None (a bar if stderr is a terminal), a bool or a callable.
    ///
    /// # Errors
    /// `TypeError` for anything else.
    pub fn new(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let bar = |wanted: bool| {
            let bar = || py.import("extricate._progress")?.getattr("Bar")?.call0();
            let function = wanted.then(bar).transpose()?.map(Bound::unbind);
            Ok(Self { is_bar: function.is_some(), function, enough: AtomicBool::new(false) })
        };
        let Some(progress) = progress else {
            // `sys.stderr` may be None or lack `isatty`, and is no terminal then.
            let is_terminal = || py.import("sys")?.getattr("stderr")?.call_method0("isatty")?.extract::<bool>();
            return bar(is_terminal().unwrap_or(false));
        };
        if let Ok(wanted) = progress.cast::<PyBool>() {
            return bar(wanted.is_true());
        }
        if progress.is_callable() {
            return Ok(Self { function: Some(progress.clone().unbind()), ..Self::default() });
        }
        let found = progress.get_type().name()?;
        Err(PyTypeError::new_err(format!("progress: got {found}, expected True, False, None or a function")))
    }

    /// Passes `state` to the function, which ends the run if it returns False.
    pub fn hear(&self, py: Python<'_>, state: LearnProgress) -> PyResult<()> {
        let Some(function) = &self.function else { return Ok(()) };
        let said = function.call1(py, (Progress::from(state),))?;
        if said.extract::<bool>(py).is_ok_and(|go_on| !go_on) {
            self.enough.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Whether the function ended the run.
    pub fn has_enough(&self) -> bool {
        self.enough.load(Ordering::Relaxed)
    }

    /// Closes a bar after the run; `done` is false if an exception interrupted the run.
    pub fn close(&self, py: Python<'_>, done: bool) -> PyResult<()> {
        match &self.function {
            Some(bar) if self.is_bar => bar.call_method1(py, "close", (done,)).map(drop),
            _ => Ok(()),
        }
    }
}

//! The class `Stream`: queries that follow each other closely, as from a simulation.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Solver;
use super::handle::Handle;
use crate::error::exception;
use crate::long_call::Watch;
use crate::queries::answer;
use crate::queries::options::{Call, CallOptions};

/// Queries that follow each other closely: each is warm-started from the one before.
/// `Solver.stream`, `Scene.stream` and `Model.stream` make it.
///
/// A stream has a memory: its answers depend on the frames before. Threads that share one wait for
/// each other.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Stream {
    /// The solver that made the stream.
    solver: extricate::Solver,
    call: CallOptions,
    stream: Mutex<extricate::Stream>,
    watch: Watch,
    /// The thread that is using the stream.
    busy: Mutex<Option<ThreadId>>,
}

impl Stream {
    /// Makes a stream of `handle` with the keywords of the call.
    ///
    /// # Errors
    /// As [`Handle::call_options`] and [`Handle::solver_for`].
    pub fn new(py: Python<'_>, handle: &Handle, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut call = handle.call_options(py, given, Call::Stream)?;
        let watch = Watch::new();
        call.options.termination.stop = Some(watch.stop());
        let solver = handle.solver_for(py, &call)?;
        let stream = Mutex::new(solver.stream(call.stream.clone()).map_err(exception)?);
        Ok(Self { solver, call, stream, watch, busy: Mutex::default() })
    }

    /// Runs `work` once no other thread uses the stream; Ctrl-C ends it.
    ///
    /// # Errors
    /// `RuntimeError` if a signal handler uses the stream whose call it interrupted; the exception
    /// that a signal handler raised.
    fn with<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut extricate::Stream) -> T + Send) -> PyResult<T> {
        let me = Some(thread::current().id());
        if *unpoisoned(&self.busy) == me {
            return Err(PyRuntimeError::new_err("stream: got a call from a signal handler, during a call of its own"));
        }
        py.detach(|| {
            let mut stream = unpoisoned(&self.stream);
            *unpoisoned(&self.busy) = me;
            let result = self.watch.over(|| work(&mut stream));
            *unpoisoned(&self.busy) = None;
            result
        })
    }

    /// Returns the solver of one frame's scene, with the weights of the stream.
    fn of_frame(&self, py: Python<'_>, solver: &Solver) -> PyResult<extricate::Solver> {
        let solver = solver.handle().with_weights(py, &self.call.weights)?;
        if solver.scene().space() != self.solver.scene().space() {
            let expected = "expected a solver of the stream's joints, limits and weights";
            return Err(PyValueError::new_err(format!("scene: got one of other coordinates, {expected}")));
        }
        Ok(solver)
    }
}

#[pymethods]
impl Stream {
    /// Answers the next frame, as `Solver.query` does.
    ///
    /// q: float64 (nq,).
    /// scene: if obstacles have moved, a `Solver` of the scene of this frame, such as one by
    ///     `Solver.with_scene` or `Model.in_scene`. The options stay those of the stream.
    ///
    /// Returns None if nothing free was found.
    #[pyo3(signature = (q, *, scene = None))]
    fn query<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        scene: Option<&Bound<'py, Solver>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let py = q.py();
        let other = scene.map(|solver| self.of_frame(py, solver.get())).transpose()?;
        let scene = other.as_ref().unwrap_or(&self.solver).scene();
        let config = self.call.config(q, scene)?;
        let answer = self.with(py, |stream| match &other {
            Some(solver) => stream.query_in(solver, &config),
            None => Ok(stream.query(&config)),
        })?;
        let answer = answer.map_err(exception)?;
        answer.map(|answer| answer::object(py, &answer, scene)).transpose()
    }

    /// Forgets the frames so far: the stream answers the next one as a query on its own.
    fn restart(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, extricate::Stream::restart)
    }

    fn __repr__(&self) -> String {
        let hysteresis = self.call.stream.hysteresis;
        match self.solver.model().map(|model| model.statistics().boundary_samples) {
            Some(samples) => format!("<Stream of a model of {samples} boundary samples, hysteresis {hysteresis}>"),
            None => format!("<Stream of a scene, hysteresis {hysteresis}>"),
        }
    }
}

/// Locks also after a panic, which leaves no half-written state that the next frame would trust.
fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

//! The class `Stream`: queries that follow each other closely, as from a simulation.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

use extricate::{QueryOptions, StreamOptions};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::answer;
use crate::arrays::{bad_row, one_config};
use crate::changed::ChangedScene;
use crate::error::count;
use crate::long_call::Watch;
use crate::model::Model;

/// Queries that follow each other closely: each is warm-started from the one before. Made by `Model.stream`.
///
/// Has a memory: its answers depend on the frames before. Threads that share one take turns.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Stream {
    model: Py<Model>,
    stream: Mutex<extricate::Stream>,
    watch: Watch,
    hysteresis: f64,
    /// The thread that answers a frame.
    busy: Mutex<Option<ThreadId>>,
}

impl Stream {
    /// Of `model`.
    ///
    /// # Errors
    /// `ValueError` that says what was expected.
    pub fn new(model: Py<Model>, query: QueryOptions, hysteresis: f64, looks: i64) -> PyResult<Self> {
        if !(0.0..1.0).contains(&hysteresis) {
            return Err(PyValueError::new_err(format!("hysteresis: got {hysteresis}, expected at least 0, below 1")));
        }
        let watch = Watch::new();
        let query = QueryOptions { stop: Some(watch.stop()), ..query };
        let options = StreamOptions { query, hysteresis, looks: count("looks", looks, 0)? };
        let stream = Mutex::new(extricate::Stream::new(options));
        Ok(Self { model, stream, watch, hysteresis, busy: Mutex::default() })
    }

    /// Does `work` when no other thread is at it, ended by Ctrl-C.
    ///
    /// # Errors
    /// `RuntimeError` in a signal handler that a frame is waiting for; what a signal handler raised.
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
}

#[pymethods]
impl Stream {
    /// The answer for the next frame, as `Model.query`. q: float64 (nq,), within the limits.
    ///
    /// scene: where obstacles have moved, the scene of this frame, by `Model.in_scene`; None is then returned where nothing free was found.
    #[pyo3(signature = (q, *, scene = None))]
    fn query<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        scene: Option<Py<ChangedScene>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let py = q.py();
        if scene.as_ref().is_some_and(|scene| !scene.get().is_of(&self.model)) {
            return Err(PyValueError::new_err(
                "scene: got one of another model, expected one by in_scene of the stream's",
            ));
        }
        let model = self.model.get().inner();
        let changed = scene.as_ref().map(|scene| scene.get().inner());
        let space = &model.scene().space;
        let values = one_config("q", q, space)?;
        let config = space.config(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let answer = self.with(py, |stream| match changed {
            Some(changed) => model.query_next_in(changed, &config, stream),
            None => Some(model.query_next(&config, stream)),
        })?;
        let scene = changed.map_or(model.scene(), extricate::ChangedScene::scene);
        answer.map(|answer| answer::object(py, answer, scene)).transpose()
    }

    /// Forgets the frames so far: the next one is answered as a query on its own.
    fn restart(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, extricate::Stream::restart)
    }

    fn __repr__(&self) -> String {
        let samples = self.model.get().inner().statistics().boundary_samples;
        format!("<Stream of a model of {samples} boundary samples, hysteresis {}>", self.hysteresis)
    }
}

/// A frame that panicked leaves nothing half done that the next one would trust.
fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

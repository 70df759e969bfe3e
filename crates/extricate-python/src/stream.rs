//! The class `Stream`: queries that follow each other closely, as from a simulation.

use std::sync::Mutex;

use extricate::{QueryOptions, StreamOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::answer;
use crate::arrays::{bad_row, one_config};
use crate::error::count;
use crate::model::Model;

/// Queries that follow each other closely: each is warm-started from the one before. Made by `Model.stream`.
///
/// Has a memory: its answers depend on the frames before. Threads that share one take turns.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Stream {
    model: Py<Model>,
    stream: Mutex<extricate::Stream>,
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
        let options = StreamOptions { query, hysteresis, looks: count("looks", looks, 0)? };
        Ok(Self { model, stream: Mutex::new(extricate::Stream::new(options)) })
    }

    fn with<T>(&self, work: impl FnOnce(&mut extricate::Stream) -> T) -> T {
        // A frame that panicked leaves nothing half done that the next one would trust.
        work(&mut self.stream.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }
}

#[pymethods]
impl Stream {
    /// The answer for the next frame, as `Model.query`. q: float64 (nq,), within the limits.
    fn query<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let model = self.model.get().inner();
        let space = &model.scene().space;
        let values = one_config("q", q, space)?;
        let config = space.config(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let answer = py.detach(|| self.with(|stream| model.query_next(&config, stream)));
        answer::object(py, answer, model.scene())
    }

    /// Forgets the frames so far: the next one is answered as a query on its own.
    fn restart(&self, py: Python<'_>) {
        py.detach(|| self.with(extricate::Stream::restart));
    }
}

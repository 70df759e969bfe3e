//! The class `Stream`: queries that follow each other closely, as from a simulation.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

use extricate::{QueryOptions, StreamOptions, Termination, World};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Model;
use super::changed::ChangedScene;
use crate::error::{Whole, count};
use crate::long_call::Watch;
use crate::queries::options::{Asked, STREAM, Weighted};
use crate::queries::{Source, answer};
use crate::scene::Scene;

/// Queries that follow each other closely: each is warm-started from the one before. Made by
/// `Model.stream` and `Scene.stream`.
///
/// Has a memory: its answers depend on the frames before. Threads that share one take turns.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Stream {
    of: Of,
    asked: Asked,
    stream: Mutex<extricate::Stream>,
    watch: Watch,
    hysteresis: f64,
    /// The thread that answers a frame.
    busy: Mutex<Option<ThreadId>>,
}

/// What is asked.
enum Of {
    Model(Py<Model>),
    /// Of which nothing was learned.
    Scene(Py<Scene>),
    /// The same with other weights.
    World(Arc<World>),
}

impl Stream {
    /// Of `model`, with the keywords of the call.
    ///
    /// # Errors
    /// As [`Asked::read`].
    pub fn of_model(model: Py<Model>, py: Python<'_>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let asked = Asked::read(given, model.get().inner().scene(), STREAM)?;
        let source = Source::Model(model.get().inner());
        let of = match asked.other_weights(py, source, &Weighted::default())? {
            Some(world) => Of::World(world),
            None => Of::Model(model),
        };
        Self::new(of, asked)
    }

    /// Of a scene of which nothing was learned.
    ///
    /// # Errors
    /// As [`Stream::of_model`].
    pub fn of_scene(scene: Py<Scene>, py: Python<'_>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let asked = Asked::read(given, scene.get().inner(), STREAM)?;
        let source = Source::World(scene.get().ready(py)?);
        let of = match asked.other_weights(py, source, &Weighted::default())? {
            Some(world) => Of::World(world),
            None => Of::Scene(scene),
        };
        Self::new(of, asked)
    }

    fn new(of: Of, asked: Asked) -> PyResult<Self> {
        let (hysteresis, starts) = (asked.hysteresis, asked.starts_per_frame);
        if !(0.0..1.0).contains(&hysteresis) {
            return Err(PyValueError::new_err(format!("hysteresis: got {hysteresis}, expected at least 0, below 1")));
        }
        let watch = Watch::new();
        let query = QueryOptions {
            termination: Termination { stop: Some(watch.stop()), ..asked.options.termination.clone() },
            ..asked.options.clone()
        };
        let starts_per_frame = count("starts_per_frame", Whole::Number(starts), 0)?;
        let options = StreamOptions { query, hysteresis, starts_per_frame, continuous: asked.continuous };
        let stream = Mutex::new(extricate::Stream::new(options));
        Ok(Self { of, asked, stream, watch, hysteresis, busy: Mutex::default() })
    }

    /// Does `work` when no other thread is at it, ended by Ctrl-C.
    ///
    /// # Errors
    /// `RuntimeError` in a signal handler that a frame is waiting for; what a signal handler
    /// raised.
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
    /// The answer for the next frame, as `Model.query`. q: float64 (nq,).
    ///
    /// scene: where obstacles have moved, the scene of this frame, by `Model.in_scene`; None is
    /// then returned where nothing free was found.
    #[pyo3(signature = (q, *, scene = None))]
    fn query<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        scene: Option<Py<ChangedScene>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let py = q.py();
        let is_of = |scene: &Py<ChangedScene>| matches!(&self.of, Of::Model(model) if scene.get().is_of(model));
        if scene.as_ref().is_some_and(|scene| !is_of(scene)) {
            return Err(PyValueError::new_err(
                "scene: got one of another model, expected one by in_scene of the stream's",
            ));
        }
        let changed = scene.as_ref().map(|scene| scene.get().inner());
        let view = match (&self.of, changed) {
            (Of::Model(model), Some(changed)) => model.get().inner().in_scene(changed),
            (Of::Model(model), None) => model.get().inner().view(),
            (Of::Scene(scene), _) => scene.get().world()?.view(),
            (Of::World(world), _) => world.view(),
        };
        let scene = view.scene();
        let config = self.asked.config(q, scene)?;
        let answer = self.with(py, |stream| view.query_next(&config, stream))?;
        answer.map(|answer| answer::object(py, answer, scene)).transpose()
    }

    /// Forgets the frames so far: the next one is answered as a query on its own.
    fn restart(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, extricate::Stream::restart)
    }

    fn __repr__(&self) -> String {
        match &self.of {
            Of::Model(model) => {
                let samples = model.get().inner().statistics().boundary_samples;
                format!("<Stream of a model of {samples} boundary samples, hysteresis {}>", self.hysteresis)
            }
            Of::Scene(_) | Of::World(_) => format!("<Stream of a scene, hysteresis {}>", self.hysteresis),
        }
    }
}

/// A frame that panicked leaves nothing half done that the next one would trust.
fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

//! The class `Solver`, whose calls work with a model or without.

mod calls;
pub mod handle;
pub mod stream;

use std::sync::Arc;

use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::exception;
use crate::model::Model;
use crate::queries;
use crate::queries::options::Call;
use crate::rows;
use crate::scene::Scene;
use handle::Handle;

/// Answers queries about a scene: the nearest free configuration, checks, and motions.
///
/// A model adds stored samples as further starts of queries; answers mean the same with and without
/// one. The first call prepares the solver. A solver is immutable: threads may share it, and each
/// query runs without the interpreter lock. It pickles.
///
/// Solver(scene, model=None, **options)
///
/// scene: the `Scene` of the queries.
/// model: a `Model` of this scene, or of one with the same joints, limits, weights and metric:
///     obstacles, checked pairs and clearance may differ. It has no samples beside obstacles that
///     moved.
/// options: keywords of `Solver.query`, which become the defaults of `query`, `batch`, `stream` and
///     `show`. An `options` object of a call replaces all of them. Motions have keywords of their
///     own.
///
/// Raises ValueError if the model does not fit the scene, and for options that make no sense.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Solver {
    handle: Handle,
}

impl Solver {
    /// Makes a solver whose calls have these keywords as defaults.
    ///
    /// # Errors
    /// As [`Handle::call_options`], and for options that make no sense in the scene.
    pub fn new(py: Python<'_>, handle: Handle, defaults: Option<Arc<Py<PyDict>>>) -> PyResult<Self> {
        let given = defaults.as_ref().map(|defaults| defaults.bind(py));
        let call = handle.call_options(py, given, Call::Query)?;
        call.options.check().map_err(exception)?;
        handle.check_weights(&call.weights)?;
        Ok(Self { handle: handle.with_defaults(defaults) })
    }

    pub fn handle(&self) -> &Handle {
        &self.handle
    }
}

#[pymethods]
impl Solver {
    #[new]
    #[pyo3(signature = (scene, model = None, **options), text_signature = "(scene, model=None, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, keep=None, touch=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive')")]
    fn python_new<'py>(
        py: Python<'py>,
        scene: &Scene,
        model: Option<&Model>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        // Later changes of the options by the caller must not change the solver.
        let copy = |options: &Bound<'py, PyDict>| -> PyResult<Bound<'py, PyDict>> {
            Ok(py.import("copy")?.call_method1("deepcopy", (options,))?.cast_into::<PyDict>()?)
        };
        let options = options.map(copy).transpose()?;
        let handle = match model {
            Some(model) => model.handle_in(py, scene)?,
            None => scene.handle().clone(),
        };
        Self::new(py, handle, options.map(|options| Arc::new(options.unbind())))
    }

    /// The scene of the queries.
    #[getter]
    fn scene(&self) -> Scene {
        Scene::of_solver(self.handle.solver().without_model())
    }

    /// The model, or None.
    #[getter]
    fn model(&self) -> Option<Model> {
        self.handle.solver().model().map(|model| Model::of(Arc::clone(model)))
    }

    /// Returns a solver of the same model and options in another scene, such as one by
    /// `Scene.moved`. It shares prepared data of equal bodies.
    ///
    /// Raises ValueError if the model does not fit the scene, or if an option names what the scene
    /// does not have.
    fn with_scene(&self, py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let solver = py.detach(|| self.handle.solver().with_scene(Arc::clone(scene.inner()))).map_err(exception)?;
        Self::new(py, Handle::new(solver), self.handle.defaults().cloned())
    }

    /// Finds the witness of `query` alone, with the options of the solver. It proves only what
    /// effort "proved" or a gap requires, and so takes less time.
    ///
    /// q: float64 (nq,), as in `query`.
    ///
    /// Returns float64 (nq,), free by the exact checker: q itself if it is free; None if nothing
    /// free was found.
    fn nearest_exit<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        queries::nearest_exit(&self.handle, q)
    }

    /// Checks whether configurations are free, as `Scene.check` does.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits.
    /// threads: 0 for one per core.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn check<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        rows::check(&self.handle, Q, threads)
    }

    /// Pickles as the call that makes it again.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let options = self.handle.defaults().map(|defaults| defaults.bind(py));
        let partial = py.import("functools")?.getattr("partial")?;
        Ok((partial.call((py.get_type::<Self>(), self.scene(), self.model()), options)?, ()))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (scene, model) = (self.handle.scene(), self.handle.solver().model());
        let (bodies, pairs) = (scene.bodies().len(), scene.pairs().len());
        let mut told = format!("<Solver of {bodies} bodies, {pairs} checked pairs");
        if let Some(model) = model {
            told += &format!(", {} stored samples", model.statistics().boundary_samples);
        }
        for (name, value) in self.handle.defaults().iter().flat_map(|defaults| defaults.bind(py).iter()) {
            told += &format!(", {name}={}", value.repr()?);
        }
        Ok(told + ">")
    }
}

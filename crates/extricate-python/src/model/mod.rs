//! The class `Model`: what was learned of a scene.

pub mod learning;
pub mod progress;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use extricate::files::check_model_output;
use numpy::{PyArray2, PyArrayMethods, ToPyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::exception;
use crate::long_call;
use crate::scene::{Scene, edit};
use crate::solver::Solver;
use crate::solver::handle::Handle;

/// Name, in messages, of a model that comes from memory.
const IN_MEMORY: &str = "in memory";

/// What was learned of a scene: all that queries need, geometry included.
///
/// Its calls are those of a `Solver` of its scene and itself. A model is immutable: any number of
/// threads may query it at once, and each query runs without the interpreter lock. It pickles as
/// the bytes of its file.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Model {
    model: Arc<extricate::Model>,
    handle: Handle,
}

impl Model {
    pub fn of(model: Arc<extricate::Model>) -> Self {
        Self { handle: Handle::new(extricate::Solver::of_model(Arc::clone(&model))), model }
    }

    /// The handle for calls in the scene that the model was learned for.
    pub fn handle(&self) -> &Handle {
        &self.handle
    }

    /// Makes the handle for calls with this model in `scene`.
    ///
    /// # Errors
    /// `ValueError` if stored configurations or distances would mean something else there.
    pub fn handle_in(&self, py: Python<'_>, scene: &Scene) -> PyResult<Handle> {
        let with_model = || scene.handle().solver().clone().with_model(Arc::clone(&self.model));
        py.detach(with_model).map(Handle::new).map_err(exception)
    }

    fn read(
        py: Python<'_>,
        read: impl FnOnce() -> extricate::Result<extricate::Model> + Send + 'static,
    ) -> PyResult<Self> {
        Ok(Self::of(long_call::apart(py, read)?.map_err(exception)?.into()))
    }
}

#[pymethods]
impl Model {
    /// Loads a model file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::read(py, move || extricate::load_model(&path))
    }

    /// Writes a model file. A reader sees the old file or the whole new one. It replaces no file
    /// that is not a model.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let save = || check_model_output(&path).and_then(|()| extricate::save_model(&self.model, &path));
        py.detach(save).map_err(exception)
    }

    /// Makes the model from the bytes of its file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let data = data.to_vec();
        Self::read(py, move || extricate::Model::from_bytes(IN_MEMORY, &data))
    }

    /// Returns the bytes of the model's file; the same model gives the same bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| self.model.to_bytes());
        PyBytes::new(py, &bytes)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("from_bytes")?, (self.to_bytes(py),)))
    }

    /// The scene that the model was learned for.
    #[getter]
    fn scene(&self) -> Scene {
        Scene::of_solver(self.handle.solver().without_model())
    }

    /// Verified free configurations beside the boundary, from which queries start, float64
    /// (samples, nq).
    #[getter]
    fn boundary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let configs = self.model.boundary().configs();
        let nq = self.model.scene().space().nq();
        configs.to_pyarray(py).reshape([configs.len() / nq, nq])
    }

    /// Support vectors of the classifier, float64 (n, nq): free and colliding configurations on
    /// either side of the boundary that it predicts. Each occurs once; those of the pairs that
    /// collide most often come first. `Scene.check` reports which are free. `n` is 0 if learning
    /// saw only one label, and less than `statistics["support_vectors"]` if several pairs share
    /// one.
    #[getter]
    fn support_vectors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let nq = self.model.scene().space().nq();
        let (mut seen, mut rows) = (HashSet::new(), Vec::new());
        for q in self.model.support_configs().chunks_exact(nq) {
            if seen.insert(q.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()) {
                rows.extend_from_slice(q);
            }
        }
        rows.to_pyarray(py).reshape([rows.len() / nq, nq])
    }

    /// How the model was learned, and its measured quality. docs/reference/statistics.md describes
    /// the keys; a value is None if it was not measured.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let text = serde_json::to_string(self.model.statistics());
        let text = text.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        Ok(py.import("json")?.call_method1("loads", (text,))?.cast_into()?)
    }

    /// Returns a `Solver` of this model in another world.
    ///
    /// world: a list of obstacles, which replace those that the model knows; or a scene of the same
    ///     joints, such as one by `Scene.moved`. In the joint metric, that scene may also differ in
    ///     held objects, fingers, the place of the base and the geometry of links.
    ///
    /// Raises ValueError if the joints, their limits or the metric differ.
    fn in_world(&self, py: Python<'_>, world: &Bound<'_, PyAny>) -> PyResult<Solver> {
        if let Ok(scene) = world.cast::<Scene>() {
            return self.in_scene(py, scene.get());
        }
        let bare = self.model.scene().without_obstacles();
        self.in_scene(py, &Scene::of(edit::with_obstacles(py, &bare, world)?.into()))
    }

    /// Returns a `Solver` of this model in another scene of the same joints, as
    /// `Solver(scene, model)` does. Obstacles may be moved, added or gone, pairs and clearance may
    /// differ.
    ///
    /// Raises ValueError if the joints, their limits or the metric differ.
    fn in_scene(&self, py: Python<'_>, scene: &Scene) -> PyResult<Solver> {
        Solver::new(py, self.handle_in(py, scene)?, None)
    }

    fn __repr__(&self) -> String {
        let statistics = self.model.statistics();
        let (samples, labels) = (statistics.boundary_samples, statistics.labels);
        format!("<Model of {samples} boundary samples, {labels} labels>")
    }
}

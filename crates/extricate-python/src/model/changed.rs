//! The class `ChangedScene`: a model that is asked in another scene than the one it was learned
//! for.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Model;
use crate::error::exception;
use crate::long_call;
use crate::queries::page::{self, Shown};
use crate::queries::{self, Memory, Source};
use crate::scene::Scene;

/// A scene in which a model of another one is asked: obstacles moved, added or gone, other pairs or
/// clearance. Made by `Model.in_scene`.
///
/// Stored samples are checked anew as they are needed, and what is said of every answer holds in
/// this scene. Beside obstacles that moved, where the model has no samples, a near exit can be
/// missed more easily; a model learned anew there knows them.
///
/// Immutable; may be shared between threads, and pickled.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct ChangedScene {
    model: Py<Model>,
    changed: extricate::ChangedScene,
    memory: Memory,
}

impl ChangedScene {
    /// Of `model`, in `scene`.
    ///
    /// # Errors
    /// `ValueError` where stored configurations or distances would mean something else in `scene`.
    pub fn new(py: Python<'_>, model: Py<Model>, scene: &Scene) -> PyResult<Self> {
        let scene = Arc::clone(scene.inner());
        let learned = model.get().inner();
        // The convex pieces around meshes are made here, not in the first query, which has no pool.
        let prepare = || {
            let changed = extricate::ChangedScene::new(learned.world(), scene)?;
            changed.checker().prepare_proposals();
            Ok(changed)
        };
        let changed = long_call::pooled(py, prepare)?.map_err(exception)?;
        Ok(Self { changed, memory: Memory::default(), model })
    }

    pub fn inner(&self) -> &extricate::ChangedScene {
        &self.changed
    }

    /// Whether it was made by `model`.
    pub fn is_of(&self, model: &Py<Model>) -> bool {
        self.model.is(model)
    }
}

#[pymethods]
impl ChangedScene {
    /// The scene that is asked in.
    #[getter]
    fn scene(&self) -> Scene {
        Scene::of(Arc::clone(self.changed.checker().scene_arc()))
    }

    /// The model that is asked.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<Model> {
        self.model.clone_ref(py)
    }

    /// As `Model.query`, in this scene. None where nothing free was found, not even among 20,000
    /// configurations beside the samples; a warning as of `Scene.query`. `checks` and `seconds` do
    /// not end the search for the nearest stored sample that is still free, without which there is
    /// no answer.
    #[pyo3(signature = (q, **options), text_signature = "($self, q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive')")]
    fn query<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Self { model, changed, memory } = slf.get();
        queries::query(Source::Changed(model.get().inner(), changed), q, options, memory, slf)
    }

    /// Shows configurations and their answers as a page, in a browser; see `Scene.show`.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; 5 random ones in collision where None.
    /// path: the file that is written; a temporary one where None.
    /// open: whether a browser opens it; where None, unless this is a notebook, which shows the
    ///     page that is returned.
    /// live: whether joints can be dragged in the page.
    /// All other keywords: as in `Model.query`; exits is 3 where the effort finds several.
    #[pyo3(signature = (Q = None, *, path = None, open = None, live = false, **options))]
    #[allow(non_snake_case)]
    fn show<'py>(
        &self,
        py: Python<'py>,
        Q: Option<&Bound<'py, PyAny>>,
        path: Option<PathBuf>,
        open: Option<bool>,
        live: bool,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        page::show(
            py,
            Source::Changed(self.model.get().inner(), &self.changed),
            Q,
            options,
            (Shown { path, open, live }, &self.memory.weighted),
        )
    }

    /// As `Model.query_batch`, in this scene. Where nothing free was found, depth is inf, witness,
    /// gradient and max_displacement are nan, verified and free are False, and there are no exits.
    #[pyo3(signature = (Q, **options), text_signature = "($self, Q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive', errors='raise', threads=0)")]
    #[allow(non_snake_case)]
    fn query_batch<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let source = Source::Changed(self.model.get().inner(), &self.changed);
        queries::query_batch(source, Q, options, &self.memory)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Scene,))> {
        Ok((self.model.bind(py).getattr("in_scene")?, (self.scene(),)))
    }

    fn __repr__(&self) -> String {
        let scene = self.changed.scene();
        let (bodies, pairs) = (scene.bodies.len(), scene.pairs.len());
        format!("<ChangedScene of {bodies} bodies, {pairs} checked pairs>")
    }
}

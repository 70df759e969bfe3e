//! The class `Roadmap`, which the plans of one scene share.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use extricate::files;
use pyo3::prelude::*;

use crate::error::{Seed, exception};
use crate::scene::Scene;

/// Free configurations and proved edges between them, which `plan` adds to and reuses.
///
/// A roadmap belongs to the scene for which it was made. In another scene with the same coordinates
/// it is a guess that saves checks: `plan` proves every path that it returns in the scene that it
/// plans in.
///
/// Roadmap(scene, *, seed=0)
///
/// scene: the `Scene` that defines the coordinates.
/// seed: seed of all random numbers.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Roadmap(Mutex<Option<extricate::Roadmap>>);

impl Roadmap {
    fn of(roadmap: extricate::Roadmap) -> Self {
        Self(Mutex::new(Some(roadmap)))
    }

    fn inner(&self) -> MutexGuard<'_, Option<extricate::Roadmap>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the roadmap until [`Roadmap::give_back`]; `None` while another call has it.
    pub fn take(&self) -> Option<extricate::Roadmap> {
        self.inner().take()
    }

    pub fn give_back(&self, roadmap: extricate::Roadmap) {
        *self.inner() = Some(roadmap);
    }

    fn tell(&self, number: impl Fn(&extricate::Roadmap) -> usize) -> usize {
        self.inner().as_ref().map_or(0, number)
    }
}

#[pymethods]
impl Roadmap {
    #[new]
    #[pyo3(signature = (scene, *, seed = Seed(0)), text_signature = "(scene, *, seed=0)")]
    fn new(scene: &Scene, seed: Seed) -> Self {
        Self::of(extricate::Roadmap::new(scene.inner().space(), seed.0))
    }

    /// Reads a roadmap file for `scene`.
    ///
    /// Raises ValueError if it is no roadmap of the scene's coordinates.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, scene: &Scene) -> PyResult<Self> {
        let inner = scene.inner();
        Ok(Self::of(py.detach(|| files::load_roadmap(&path, inner)).map_err(exception)?))
    }

    /// Writes a roadmap file. A reader sees the old file or the whole new one. It replaces no file
    /// that is not a roadmap.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let kept = self.inner().clone();
        let Some(roadmap) = kept else { return Ok(()) };
        py.detach(|| files::save_roadmap(&roadmap, &path)).map_err(exception)
    }

    /// Number of configurations.
    fn __len__(&self) -> usize {
        self.tell(extricate::Roadmap::len)
    }

    /// Number of proved edges.
    #[getter]
    fn edges(&self) -> usize {
        self.tell(extricate::Roadmap::edges)
    }

    /// Number of configurations that were evaluated to make it.
    #[getter]
    fn checks(&self) -> usize {
        self.tell(extricate::Roadmap::checks)
    }

    fn __repr__(&self) -> String {
        format!("<Roadmap of {} configurations, {} edges>", self.__len__(), self.edges())
    }
}

//! Queries of a scene of which nothing was learned.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Scene;
use crate::model::stream::Stream;
use crate::queries::page::{self, Shown};
use crate::queries::{self, Source};

#[pymethods]
impl Scene {
    /// The nearest free configuration to q, at once: nothing has to be learned. A `Model` of the
    /// scene adds stored samples as starts; what is said of the answer holds alike.
    ///
    /// q and all keywords: as in `Model.query`. Every effort
    /// verifies its witness.
    ///
    /// None where nothing free was found, not even among 20,000 configurations. A warning names the
    /// pairs that collide wherever one looks, if some do. They are looked for once, whatever
    /// `max_checks` and `max_seconds` are. If warnings are errors, the warning is raised in place
    /// of all answers of a call.
    ///
    /// Raises ValueError for a wrong shape, values that are not finite.
    #[pyo3(signature = (q, **options), text_signature = "($self, q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive')")]
    fn query<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let scene = slf.get();
        let source = Source::World(scene.ready(q.py())?);
        queries::query(source, q, options, scene.memory(), slf)
    }

    /// Shows configurations and their answers as a page, in a browser or a notebook: robot, ghost
    /// of the query, contacts, the slider to each exit, the numbers and the proof, and a slice of
    /// the space.
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
            Source::World(self.ready(py)?),
            Q,
            options,
            (Shown { path, open, live }, &self.memory().weighted),
        )
    }

    /// The nearest free configuration to each of Q, on many threads, at once: nothing has to be
    /// learned.
    ///
    /// Q and all keywords: as in `Model.query_batch`, which tells what is returned. Where nothing
    /// free was found, depth is inf, witness, gradient and max_displacement are nan, verified and
    /// free are False, and there are no exits.
    #[pyo3(signature = (Q, **options), text_signature = "($self, Q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive', errors='raise', threads=0)")]
    #[allow(non_snake_case)]
    fn query_batch<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let source = Source::World(self.ready(Q.py())?);
        queries::query_batch(source, Q, options, self.memory())
    }

    /// For queries that follow each other closely, as from a simulation: each is warm-started from
    /// the one before.
    ///
    /// All keywords: as in `Model.stream`.
    #[pyo3(signature = (**options), text_signature = "($self, *, options=None, effort='refined', hysteresis=0.0, starts_per_frame=2, continuous=False, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, weights=None, free_radius=False, limits='forgive')")]
    fn stream(slf: Py<Self>, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Stream> {
        slf.get().ready(py)?;
        Stream::of_scene(slf, py, options)
    }
}

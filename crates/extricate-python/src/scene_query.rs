//! Queries of a scene of which nothing was learned.

use extricate::QueryOptions;
use pyo3::prelude::*;

use crate::answer;
use crate::arrays::{bad_row, one_config};
use crate::batch::answers;
use crate::long_call;
use crate::scene::Scene;
use crate::stream::Stream;

#[pymethods]
impl Scene {
    /// The nearest free configuration to q, at once: nothing has to be learned. A `Model` of the
    /// scene takes fewer checks; what is said of the answer holds alike.
    ///
    /// q, effort, exits, starts, checks, seconds, way, contacts: as in `Model.query`. Every effort
    /// verifies its witness.
    ///
    /// None where nothing free was found, not even among 20,000 configurations.
    ///
    /// Raises ValueError for a wrong shape, values that are not finite.
    #[pyo3(signature = (q, *, effort = "refined", exits = 1, starts = None, checks = None, seconds = None, way = false, contacts = false))]
    fn query<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        effort: &str,
        exits: i64,
        starts: Option<i64>,
        checks: Option<i64>,
        seconds: Option<f64>,
        way: bool,
        contacts: bool,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (py, scene) = (q.py(), &**self.inner());
        let options = answer::options(effort, exits, starts, checks, seconds, [way, contacts])?;
        let values = one_config("q", q, &scene.space)?;
        let config = scene.space.config_anywhere(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let world = self.ready(py)?;
        let watch = long_call::Watch::new();
        let options = QueryOptions { stop: Some(watch.stop()), ..options };
        let ask = || self.query_scratches().with(|scratch| world.query(&config, &options, scratch));
        py.detach(|| watch.over(ask))?.map(|answer| answer::object(py, answer, scene)).transpose()
    }

    /// The nearest free configuration to each of Q, on many threads, at once: nothing has to be
    /// learned.
    ///
    /// Q, effort, exits, starts, checks, seconds, way, contacts, threads: as in
    /// `Model.query_batch`, which tells what is returned. Where nothing free was found, depth is
    /// inf, witness, gradient and max_displacement are nan, verified and free are False, and there
    /// are no exits. coverage is nan.
    #[pyo3(signature = (Q, *, effort = "refined", exits = 1, starts = None, checks = None, seconds = None, way = false, contacts = false, threads = 0))]
    #[allow(non_snake_case)]
    fn query_batch<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        effort: &str,
        exits: i64,
        starts: Option<i64>,
        checks: Option<i64>,
        seconds: Option<f64>,
        way: bool,
        contacts: bool,
        threads: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let options = answer::options(effort, exits, starts, checks, seconds, [way, contacts])?;
        let world = self.ready(Q.py())?;
        answers(Q, self.inner(), threads, self.query_scratches(), options, &|q, options, scratch| {
            world.query(q, options, scratch)
        })
    }

    /// For queries that follow each other closely, as from a simulation: each is warm-started from
    /// the one before.
    ///
    /// effort, hysteresis, looks, starts, checks, seconds, way, contacts: as in `Model.stream`.
    #[pyo3(signature = (*, effort = "refined", hysteresis = 0.0, looks = 4, starts = None, checks = None, seconds = None, way = false, contacts = false))]
    fn stream(
        slf: Py<Self>,
        py: Python<'_>,
        effort: &str,
        hysteresis: f64,
        looks: i64,
        starts: Option<i64>,
        checks: Option<i64>,
        seconds: Option<f64>,
        way: bool,
        contacts: bool,
    ) -> PyResult<Stream> {
        slf.get().ready(py)?;
        let options = answer::options(effort, 1, starts, checks, seconds, [way, contacts])?;
        Stream::of_scene(slf, options, hysteresis, looks)
    }
}

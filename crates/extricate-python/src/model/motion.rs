//! Motions in the scene of a model, which saves checks of queries.

use pyo3::prelude::*;

use super::Model;
use crate::error::{Seed, Whole};
use crate::motion::roadmap::Roadmap;
use crate::motion::{escape, plan, repair};
use crate::queries::Source;

#[pymethods]
impl Model {
    /// A path out of collision, as `Scene.escape`, which says what all keywords mean.
    #[pyo3(signature = (q, *, aim = None, tolerance = 1e-3, exits = Whole::Number(6), resolution = 1e-4, tree_checks = Whole::Number(20_000), seed = Seed(0), max_checks = None, max_seconds = None), text_signature = "($self, q, *, aim=None, tolerance=1e-3, exits=6, resolution=1e-4, tree_checks=20000, seed=0, max_checks=None, max_seconds=None)")]
    fn escape<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        aim: Option<f64>,
        tolerance: f64,
        exits: Whole,
        resolution: f64,
        tree_checks: Whole,
        seed: Seed,
        max_checks: Option<Whole>,
        max_seconds: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let keywords = (aim, tolerance, exits, resolution, tree_checks, seed.0, max_checks, max_seconds);
        escape::escape(Source::Model(self.inner()), q, keywords, &self.memory.advice)
    }

    /// A path between two free configurations, as `Scene.plan`, which says what all keywords mean.
    #[pyo3(signature = (start, goal, *, roadmap = None, resolution = 1e-4, shortcut = true, seed = Seed(0), threads = 0, max_checks = Some(Whole::Number(1_000_000)), max_seconds = None), text_signature = "($self, start, goal, *, roadmap=None, resolution=1e-4, shortcut=True, seed=0, threads=0, max_checks=1000000, max_seconds=None)")]
    fn plan<'py>(
        &self,
        start: &Bound<'py, PyAny>,
        goal: &Bound<'py, PyAny>,
        roadmap: Option<Bound<'py, Roadmap>>,
        resolution: f64,
        shortcut: bool,
        seed: Seed,
        threads: i64,
        max_checks: Option<Whole>,
        max_seconds: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let keywords = (roadmap, resolution, shortcut, seed.0, threads, max_checks, max_seconds);
        plan::plan(Source::Model(self.inner()), (start, goal), keywords)
    }

    /// A path that collides as one that is proved free, as `Scene.repair`, which says what all
    /// keywords mean.
    #[pyo3(signature = (path, *, aim = None, max_deviation = None, resolution = 1e-4, seed = Seed(0), max_checks = Some(Whole::Number(100_000)), max_seconds = None), text_signature = "($self, path, *, aim=None, max_deviation=None, resolution=1e-4, seed=0, max_checks=100000, max_seconds=None)")]
    fn repair<'py>(
        &self,
        path: &Bound<'py, PyAny>,
        aim: Option<f64>,
        max_deviation: Option<f64>,
        resolution: f64,
        seed: Seed,
        max_checks: Option<Whole>,
        max_seconds: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let keywords = (aim, max_deviation, resolution, seed.0, max_checks, max_seconds);
        repair::repair(Source::Model(self.inner()), path, keywords)
    }
}

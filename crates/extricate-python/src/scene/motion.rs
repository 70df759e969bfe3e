//! Motions in a scene of which nothing was learned.

use pyo3::prelude::*;

use super::Scene;
use crate::error::{Seed, Whole};
use crate::motion::roadmap::Roadmap;
use crate::motion::{escape, plan, repair};
use crate::queries::Source;

#[pymethods]
impl Scene {
    /// A path out of collision: from q to a free configuration, such that on the way no pair of
    /// bodies collides that does not at q, and none that does gets deeper by more than `tolerance`.
    ///
    /// q: a configuration within its limits, (nq,).
    /// aim: clearance that the end is to keep [m]; a near end that keeps less, at least the
    ///     scene's, is preferred to a far one. None: the scene's and 1 mm.
    /// tolerance: by how much a pair that collides at q may get deeper [m].
    /// exits: how many exits straight edges are tried to.
    /// resolution: how finely edges are proved [m].
    /// tree_checks: checks of the trees that grow where nothing simpler leads out.
    /// seed: of all random numbers.
    /// max_checks, max_seconds: when to give up.
    ///
    /// Returns an `Escape`; its `points` are None where no path was found, with a warning as of
    /// `Scene.query`. All that it says of the path is proved for every configuration between, not
    /// for samples.
    ///
    /// Raises ValueError for a wrong shape, values beyond limits, options that make no sense.
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
        escape::escape(Source::World(self.ready(q.py())?), q, keywords, &self.memory().advice)
    }

    /// A path between two free configurations, every edge of it proved free: also through narrow
    /// passages.
    ///
    /// start, goal: configurations, (nq,).
    /// roadmap: a `Roadmap` of earlier calls, which this one adds to.
    /// resolution: how finely edges are proved [m].
    /// shortcut: whether to remove points that are not needed.
    /// seed: of all random numbers.
    /// threads: that grow the roadmap, 0 for one a core; the path is the same.
    /// max_checks, max_seconds: when to give up.
    ///
    /// Returns a `Plan`; its `points` are None where no path was found.
    ///
    /// Raises ValueError for a wrong shape, ends that are not free (start and goal are "from" and
    /// "to" in the message), options that make no sense.
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
        plan::plan(Source::World(self.ready(start.py())?), (start, goal), keywords)
    }

    /// A path that collides as one that is proved free, as near to the old one as is found: what of
    /// it is free stays.
    ///
    /// path: configurations one after the other, (n, nq).
    /// aim: clearance that configurations are pushed out to [m], or as much of it as is kept
    ///     nearby. None: the scene's and a tenth of the radius of the smallest moving body.
    /// max_deviation: most that the new path may be from the old one, and rows that are cut off
    ///     from the new one, in the scene's metric.
    /// resolution: how finely edges are proved [m].
    /// seed: of all random numbers.
    /// max_checks, max_seconds: when to give up.
    ///
    /// Returns a `Repaired`; its `points` are None where no path was found.
    ///
    /// Raises ValueError for a wrong shape, rows beyond limits, options that make no sense.
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
        repair::repair(Source::World(self.ready(path.py())?), path, keywords)
    }
}

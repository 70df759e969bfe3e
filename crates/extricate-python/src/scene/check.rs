//! Methods of `Scene` that check configurations and draw random ones.

use extricate::parts::misses_allowed;
use extricate::{Label, Sampler};
use numpy::{Ix2, PyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;

use super::Scene;
use crate::error::{Seed, Whole, count, exception, threads as thread_count};
use crate::long_call;
use crate::rows::arrays::{bad_row, configs, one_config};
use crate::rows::{self, segments, shaped};

/// Configurations that one call of the sampler draws.
const CONFIGS_PER_DRAW: usize = 4096;

#[pymethods]
impl Scene {
    /// Whether configurations are free: every checked pair keeps the clearance.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. Not copied if it is
    ///     C-contiguous.
    /// threads: 0 for one per core.
    /// Returns bool (n,), or of no dimension for one. Exact, see `Scene.distances`.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn check<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        rows::check(self.handle(), Q, threads)
    }

    /// Least signed distance [m] of any checked pair of bodies: negative if two overlap, inf
    /// if no pair is checked.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. Not copied if it is
    ///     C-contiguous.
    /// threads: 0 for one per core.
    /// Returns float64 (n,), or of no dimension for one. Exact if positive, and for convex
    /// shapes; for overlapping meshes an estimate of the overlap from below.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn distances<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = Q.py();
        let space = self.inner().space();
        let (q, nq) = (configs("Q", Q, space)?, space.nq());
        let distances =
            rows::map(self.handle(), py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
                for (q, out) in rows.chunks_exact(nq).zip(out) {
                    *out = checker.clearance(q, scratch);
                }
            })?;
        shaped(py, distances, q.single)
    }

    /// Whether the whole segment from each configuration of A to the one of B is free, along the
    /// geodesic that the scene's metric measures: thin obstacles included, nothing is sampled.
    ///
    /// A, B: float64 (n, nq), or (nq,) for one way; within the limits.
    /// resolution: how closely a first contact is enclosed, in metres of motion; at least 1e-5.
    ///     Bodies that come about as near as that to losing the clearance may leave a way
    ///     undecided.
    /// threads: 0 for one per core. Returns a structured array (n,) with the fields free (proved),
    /// contact (a collision was found; neither: undecided), free_until (fraction of the segment up
    /// to which it is proved free), at (fraction where a configuration collides, or nearly does
    /// if undecided; nan if free) and pair (index into `pairs` of what does; -1 if free).
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (A, B, *, resolution = 1e-4, threads = 0))]
    #[allow(non_snake_case)]
    fn check_segments<'py>(
        &self,
        A: &Bound<'py, PyAny>,
        B: &Bound<'py, PyAny>,
        resolution: f64,
        threads: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        segments::check(self, A, B, resolution, thread_count(threads)?)
    }

    /// The pairs of bodies that collide at one configuration, by their names.
    ///
    /// q: float64 (nq,), within the limits.
    ///
    /// Raises ValueError for a wrong shape, values that are not finite or beyond a limit.
    fn colliding_pairs(&self, q: &Bound<'_, PyAny>) -> PyResult<Vec<(&str, &str)>> {
        let (py, scene) = (q.py(), self.inner());
        let values = one_config("q", q, scene.space())?;
        let config = scene.config(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let solver = self.handle().for_checks(py)?;
        let pairs = py.detach(|| solver.colliding_pairs(&config));
        Ok(pairs.into_iter().map(|pair| scene.pair_names(pair).into()).collect())
    }

    /// Pairs of bodies that collide in every one of some random configurations: most likely links
    /// that overlap by design and belong in `disable`.
    ///
    /// n: how many configurations, 1 or more.
    /// seed: of the random numbers.
    /// share: of the configurations in which a pair has to collide; 0.95 for those that nearly
    ///     always do.
    #[pyo3(signature = (n = Whole::Number(100), *, seed = Seed(0), share = 1.0), text_signature = "($self, n=100, *, seed=0, share=1.0)")]
    fn always_colliding(&self, py: Python<'_>, n: Whole, seed: Seed, share: f64) -> PyResult<Vec<(&str, &str)>> {
        let n = count("n", n, 1)?;
        if !(share > 0.0 && share <= 1.0) {
            return Err(PyValueError::new_err(format!("share: got {share}, expected more than 0, at most 1")));
        }
        let misses = misses_allowed(n, share);
        let solver = self.handle().for_checks(py)?;
        let mut sampler = Sampler::new(solver, None, seed.0);
        let always = |line: &long_call::Line<()>| {
            let drawn = (0..n).map_while(|_| sampler.draw(1, &mut |_, _| line.flow()).ok()?.pop());
            solver.checker().nearly_always_colliding(drawn, misses)
        };
        let pairs = long_call::run(py, |_, ()| Ok(()), always)?;
        Ok(pairs.into_iter().map(|(pair, _)| self.inner().pair_names(pair).into()).collect())
    }

    /// Uniformly random configurations within the limits.
    ///
    /// n: how many, 0 or more.
    /// seed: of the random numbers; the same configurations for the same seed.
    /// colliding: True for configurations in collision only, False for free ones only, None for
    ///     any.
    /// threads: 0 for one per core. The configurations do not depend on it.
    /// Returns float64 (n, nq).
    ///
    /// Raises RuntimeError if a million in a row are not of that kind, MemoryError if n are
    /// too many to hold.
    #[pyo3(
        signature = (n, *, seed = Seed(0), colliding = None, threads = 0),
        text_signature = "($self, n, *, seed=0, colliding=None, threads=0)"
    )]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        n: Whole,
        seed: Seed,
        colliding: Option<bool>,
        threads: i64,
    ) -> PyResult<Bound<'py, PyArray<f64, Ix2>>> {
        let (n, pool) = (count("n", n, 0)?, long_call::pool(thread_count(threads)?)?);
        let wanted = colliding.map(|colliding| if colliding { Label::Colliding } else { Label::Free });
        let (mut found, nq) = (Vec::new(), self.inner().space().nq());
        let reserved = n.checked_mul(nq).map(|len| found.try_reserve_exact(len));
        if !matches!(reserved, Some(Ok(()))) {
            return Err(PyMemoryError::new_err(format!("n: {n} configurations are more than memory holds")));
        }
        let mut sampler = Sampler::new(self.handle().for_checks(py)?, wanted, seed.0);
        let draw = |line: &long_call::Line<()>| {
            while found.len() < n * nq {
                let missing = n - found.len() / nq;
                let drawn = pool.install(|| sampler.draw(missing.min(CONFIGS_PER_DRAW), &mut |_, _| line.flow()))?;
                drawn.iter().for_each(|q| found.extend_from_slice(q));
            }
            Ok(found)
        };
        let drawn = long_call::run(py, |_, ()| Ok(()), draw)?.map_err(exception)?;
        PyArray1::from_vec(py, drawn).reshape([n, nq])
    }
}

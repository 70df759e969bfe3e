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
    /// Checks whether configurations are free: every checked pair keeps the clearance.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. A C-contiguous array is not copied.
    /// threads: 0 for one per core.
    /// Returns bool (n,), or without dimensions for one. It is exact, see `Scene.distances`.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn check<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        rows::check(self.handle(), Q, threads)
    }

    /// Computes the least signed distance [m] of any checked pair of bodies: negative if two
    /// overlap, inf if no pair is checked.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. A C-contiguous array is not copied.
    /// threads: 0 for one per core.
    /// Returns float64 (n,), or without dimensions for one. It is exact if positive, and for convex
    /// shapes; for overlapping meshes it estimates the overlap from below.
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

    /// Checks whether the whole segment from each configuration of A to that of B is free, along
    /// the geodesic of the scene's metric. It takes no samples, so that it finds thin obstacles
    /// too.
    ///
    /// A, B: float64 (n, nq), or (nq,) for one segment; within the limits.
    /// resolution: how closely a first contact is enclosed, in metres of motion; at least 1e-5.
    ///     Bodies that come about as near as that to losing the clearance may leave a segment
    ///     undecided.
    /// threads: 0 for one per core.
    /// Returns a structured array (n,) with the fields free (proved), contact (a collision was
    /// found), free_until (fraction of the segment up to which it is proved free), at (fraction at
    /// which a configuration collides, or nearly does if undecided; nan if free) and pair (index
    /// into `pairs` of the pair that does; -1 if free). A segment that is neither free nor has a
    /// contact is undecided.
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

    /// Returns the pairs of bodies that collide at one configuration, by their names.
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

    /// Returns the pairs of bodies that collide in every one of some random configurations. Most
    /// likely they are links that overlap by design and belong in `disable`.
    ///
    /// n: number of configurations, 1 or more.
    /// seed: seed of the random numbers.
    /// share: share of the configurations in which a pair has to collide; 0.95 also finds pairs
    ///     that nearly always do.
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

    /// Draws uniformly random configurations within the limits.
    ///
    /// n: number of configurations, 0 or more.
    /// seed: seed of the random numbers; the same seed gives the same configurations.
    /// colliding: True draws configurations in collision only, False free ones only, None any.
    /// threads: 0 for one per core. The configurations do not depend on it.
    /// Returns float64 (n, nq).
    ///
    /// Raises RuntimeError if a million in a row are not of that kind, MemoryError if memory
    /// cannot hold n.
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

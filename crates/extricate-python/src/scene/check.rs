//! Checks of configurations of a scene, and random ones.

use extricate::Label;
use extricate::internals::collision::misses_allowed;
use extricate::internals::scene::units;
use numpy::{Ix2, PyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use super::{Scene, sampling};
use crate::error::{Seed, Whole, count, threads as thread_count};
use crate::long_call;
use crate::rows::arrays::{bad_row, configs};
use crate::rows::{GROUP, segments, shaped};

#[pymethods]
impl Scene {
    /// Whether configurations are free: every checked pair keeps the clearance.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. Not copied where it is
    ///     C-contiguous.
    /// threads: 0 for one per core.
    /// Returns bool (n,), or of no dimension for one. Exact, see `Scene.distances`.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn check<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let py = Q.py();
        let q = configs("Q", Q, &self.inner().space)?;
        let free = self.map_rows(py, &q, (thread_count(threads)?, GROUP), |checker, rows, free, scratch| {
            if let [free] = free {
                // The kernel for eight would do the work of eight.
                *free = checker.label(rows, scratch) == Label::Free;
                return;
            }
            let mut labels = vec![Label::Free; free.len()];
            checker.label_batch_serial(rows, &mut labels, scratch);
            for (free, label) in free.iter_mut().zip(labels) {
                *free = label == Label::Free;
            }
        })?;
        shaped(py, free, q.single)
    }

    /// Least signed distance [m] of any checked pair of bodies: negative where two overlap, inf
    /// where no pair is checked.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits. Not copied where it is
    ///     C-contiguous.
    /// threads: 0 for one per core.
    /// Returns float64 (n,), or of no dimension for one. Exact where positive, and for convex
    /// shapes; for overlapping meshes an estimate of the overlap from below.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn distances<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = Q.py();
        let q = configs("Q", Q, &self.inner().space)?;
        let nq = self.inner().space.nq();
        let distances = self.map_rows(py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
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
    /// where undecided; nan where free) and pair (index into `pairs` of what does; -1 where free).
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
        let values = crate::rows::arrays::one_config("q", q, &self.inner().space)?;
        let config = units::config(self.inner(), values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let mut pairs = Vec::new();
        q.py().detach(|| {
            let checker = self.checker()?;
            self.scratches().with(|scratch| checker.colliding_pairs(&config, scratch, &mut pairs));
            Ok::<_, PyErr>(())
        })?;
        Ok(pairs.into_iter().map(|pair| self.inner().pair_names(pair).into()).collect())
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
        let always = |line: &long_call::Line<()>| {
            Ok::<_, PyErr>(sampling::always(self.checker()?, n, seed.0, misses, || line.stopped()))
        };
        let pairs = long_call::run(py, |_, ()| Ok(()), always)??;
        Ok(pairs.into_iter().map(|pair| self.inner().pair_names(pair).into()).collect())
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
    /// Raises RuntimeError where a million in a row are not of that kind, MemoryError where n are
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
        let mut found = Vec::new();
        let reserved = n.checked_mul(self.inner().space.nq()).map(|len| found.try_reserve_exact(len));
        if !matches!(reserved, Some(Ok(()))) {
            return Err(PyMemoryError::new_err(format!("n: {n} configurations are more than memory holds")));
        }
        let drawn = long_call::run(
            py,
            |_, ()| Ok(()),
            |line| {
                let checker = self.checker()?;
                Ok::<_, PyErr>(pool.install(|| sampling::sample(checker, n, seed.0, wanted, found, || line.stopped())))
            },
        )??;
        let drawn = drawn.map_err(PyRuntimeError::new_err)?.unwrap_or_default();
        PyArray1::from_vec(py, drawn).reshape([n, self.inner().space.nq()])
    }
}

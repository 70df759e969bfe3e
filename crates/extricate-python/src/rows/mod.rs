//! Computes one value for each of many configurations, on many threads.

pub mod arrays;
pub mod segments;

use extricate::{CheckScratch, Checker, Label};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::threads as thread_count;
use crate::long_call;
use crate::solver::handle::Handle;
use arrays::{Configs, bad_row, configs};

/// Rows that a thread takes at once: with fewer, handing them out takes too large a share.
const CHUNK_ROWS: usize = 64;
/// Rows that the batch kernel checks at once.
pub const KERNEL_ROWS: usize = 8;
/// Rows of about a microsecond each between two polls for a stop.
pub const POLL_ROWS: usize = 4096;
/// Up to this many rows are not worth starting threads for.
const MAX_SERIAL_ROWS: usize = 64;

/// Computes one value for each row, on `threads` threads. `one` gets at most `at_once` rows, which
/// were checked. A stop is polled before each call of it: some rows take a tenth of a second.
///
/// # Errors
/// `ValueError` for a row that is no configuration within the limits; the exceptions of
/// [`long_call::run`].
pub fn map<T: Send + Default + Clone>(
    handle: &Handle,
    py: Python<'_>,
    q: &Configs<'_>,
    (threads, at_once): (usize, usize),
    one: impl Fn(&Checker, &[f64], &mut [T], &mut CheckScratch) + Sync,
) -> PyResult<Vec<T>> {
    let (values, rows, single, scene) = (q.values(), q.rows, q.single, handle.scene());
    let nq = scene.space().nq();
    let mut found = vec![T::default(); rows];
    let solver = handle.for_checks(py)?;
    let group = |first: usize, values: &[f64], found: &mut [T], scratch: &mut CheckScratch| -> PyResult<()> {
        let mut checked = Vec::with_capacity(values.len());
        for (row, q) in values.chunks_exact(nq).enumerate() {
            let q = scene.config(q).map_err(|error| bad_row("Q", first + row, single, error))?;
            checked.extend_from_slice(&q);
        }
        one(solver.checker(), &checked, found, scratch);
        Ok(())
    };
    let chunk = |first: usize, values: &[f64], found: &mut [T], stop: &dyn Fn() -> bool| {
        solver.with_scratch(|scratch| {
            let mut groups = values.chunks(at_once * nq).zip(found.chunks_mut(at_once)).enumerate();
            groups.try_for_each(|(at, (values, found))| match stop() {
                true => Ok(()),
                false => group(first + at * at_once, values, found, scratch),
            })
        })
    };
    if rows <= at_once {
        py.detach(|| chunk(0, values, &mut found, &|| false))?;
        return Ok(found);
    }
    if rows <= MAX_SERIAL_ROWS {
        let watch = long_call::Watch::new();
        let stop = watch.stop();
        py.detach(|| watch.over(|| chunk(0, values, &mut found, &|| stop.is_asked())))??;
        return Ok(found);
    }
    let pool = long_call::pool(threads)?;
    let all = |line: &long_call::Line<()>| {
        let chunks = values.par_chunks(CHUNK_ROWS * nq).zip(found.par_chunks_mut(CHUNK_ROWS)).enumerate();
        let one = |(at, (values, found)): (usize, (&[f64], &mut [T]))| {
            chunk(at * CHUNK_ROWS, values, found, &|| line.stopped())
        };
        pool.install(|| chunks.try_for_each(one))
    };
    long_call::run(py, |_, ()| Ok(()), all)??;
    Ok(found)
}

/// Returns whether configurations are free, as `Scene.check` documents.
///
/// # Errors
/// As [`map`].
pub fn check<'py>(
    handle: &Handle,
    queries: &Bound<'py, PyAny>,
    threads: i64,
) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
    let py = queries.py();
    let q = configs("Q", queries, handle.scene().space())?;
    let free = map(handle, py, &q, (thread_count(threads)?, KERNEL_ROWS), |checker, rows, free, scratch| {
        if let [free] = free {
            // The batch kernel would do the work of a whole group.
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

/// Returns an array without dimension if a `single` configuration was given, else a flat one.
pub fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    single: bool,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = PyArray1::from_vec(py, values);
    if single { array.reshape(Vec::new()) } else { Ok(array.to_dyn().clone()) }
}

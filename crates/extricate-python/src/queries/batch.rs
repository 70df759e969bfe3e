//! Answers many queries on many threads, from the rows of one array into those of another.

use std::sync::atomic::{AtomicBool, Ordering};

use extricate::parts::Factor;
use extricate::{ConfigSpace, Manifold, Scene};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use super::layout::Layout;
use super::options::{Call, CallOptions};
use crate::error::{threads, warn};
use crate::long_call;
use crate::rows::POLL_ROWS;
use crate::rows::arrays::{Configs, bad_row, configs};
use crate::solver::handle::Handle;

/// Queries that a thread takes at once.
const CHUNK_QUERIES: usize = 32;

/// Returns the limits of every coordinate if all values between them are configurations; `None` if
/// there is a rotation. They accept most rows in a few nanoseconds, which counts because rows of
/// free space are answered in a few microseconds.
fn plain_limits(space: &ConfigSpace) -> Option<Vec<[f64; 2]>> {
    let limits = |factor: &Factor| match factor.manifold {
        Manifold::Interval { lower, upper } => Some([lower, upper]),
        Manifold::Circle => Some([f64::MIN, f64::MAX]),
        Manifold::Rotation => None,
    };
    space.factors().iter().map(limits).collect()
}

/// Checks all rows before any is answered, so that a wrong last row does not fail the call after an
/// hour. Warns if a row seems to be in degrees.
///
/// # Errors
/// The error of the first wrong row, unless wrong rows are masked; `KeyboardInterrupt`.
fn check_rows(py: Python<'_>, scene: &Scene, call: &CallOptions, q: &Configs) -> PyResult<()> {
    let (rows, single) = (q.values(), q.single);
    let limits = plain_limits(scene.space());
    let plain = |q: &[f64]| limits.iter().flatten().zip(q).all(|([lower, upper], x)| lower <= x && x <= upper);
    let watch = long_call::Watch::new();
    let stop = watch.stop();
    let look = || {
        let mut degrees = None;
        for (row, values) in rows.chunks_exact(scene.space().nq()).enumerate() {
            if row % POLL_ROWS == 0 && stop.is_asked() {
                break;
            }
            if limits.is_some() && plain(values) {
                continue;
            }
            if degrees.is_none() {
                degrees = scene.degrees_hint(values).map(|hint| (row, hint));
            }
            if !call.masks {
                call.config_of(values, scene).map_err(|error| bad_row("Q", row, single, error))?;
            }
        }
        Ok::<_, PyErr>(degrees)
    };
    let degrees = py.detach(|| watch.over(look))??;
    match degrees.filter(|_| !call.refuses) {
        Some((row, hint)) => warn(py, &format!("Q[{row}]: {hint}")),
        None => Ok(()),
    }
}

/// Answers all rows, in a structured array of [`Layout`]. If a row has no answer,
/// [`Handle::advise`] may warn.
///
/// # Errors
/// `ValueError` for a shape or a row that is no configuration, before any row is answered;
/// `MemoryError` if the answers cannot be kept; the exceptions of [`long_call::run`].
pub fn answers<'py>(
    handle: &Handle,
    queries: &Bound<'py, PyAny>,
    given: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (queries.py(), handle.scene());
    let call = handle.call_options(py, given, Call::Batch)?;
    let q = configs("Q", queries, scene.space())?;
    let pool = long_call::pool(threads(call.threads)?)?;
    let solver = handle.solver_for(py, &call)?;
    check_rows(py, scene, &call, &q)?;
    let layout = Layout::new(scene, &call.options);
    let is_kept = |size: &usize| size.checked_mul(q.rows).is_some_and(|bytes| bytes <= isize::MAX as usize);
    let size = layout.size().filter(is_kept);
    let size = size.ok_or_else(|| PyMemoryError::new_err("the answers are more than can be addressed"))?;
    // Bytes, because no Rust type has the layout of a row; Python reads them through a view.
    let answers = py.import("numpy")?.call_method1("zeros", (q.rows * size, "u1"))?.cast_into::<PyArray1<u8>>()?;
    let batch = Batch { call: &call, scene, layout, size, lacks_answers: AtomicBool::new(false) };
    {
        let mut answers = answers.readwrite();
        let answers = answers.as_slice_mut().expect("contiguous: it was just made");
        let (values, single, nq) = (q.values(), q.single, scene.space().nq());
        let mut fill = |line: &long_call::Line<()>| {
            let solver = call.stopped_by(&solver, line.stop());
            let answers = answers.par_chunks_mut(CHUNK_QUERIES * size);
            let chunks = values.par_chunks(CHUNK_QUERIES * nq).zip(answers).enumerate();
            chunks.try_for_each(|(at, (values, answers))| {
                let place = (at * CHUNK_QUERIES, single);
                batch.fill(&solver, values, answers, place, &|| line.stopped())
            })
        };
        long_call::run(py, |_, ()| Ok(()), |line| pool.install(|| fill(line)))??;
    }
    if batch.lacks_answers.into_inner() {
        handle.advise(py)?;
    }
    answers.call_method1("view", (layout.dtype(py, size)?,))
}

/// Shared data of the threads that fill the rows of a batch.
struct Batch<'a> {
    call: &'a CallOptions,
    scene: &'a Scene,
    layout: Layout,
    /// Size of a row of answers \[bytes\].
    size: usize,
    /// Whether nothing free was found for some row.
    lacks_answers: AtomicBool,
}

impl Batch<'_> {
    /// Answers some rows, the first of which has the index `first`. `single` says that the call has
    /// one configuration, which messages name without an index.
    fn fill(
        &self,
        solver: &extricate::Solver,
        values: &[f64],
        answers: &mut [u8],
        (first, single): (usize, bool),
        stopped: &dyn Fn() -> bool,
    ) -> PyResult<()> {
        let rows = values.chunks_exact(self.scene.space().nq()).zip(answers.chunks_exact_mut(self.size));
        for (row, (q, row_of_answer)) in rows.enumerate().take_while(|_| !stopped()) {
            match self.call.config_of(q, self.scene) {
                Ok(config) => {
                    let answer = solver.query(&config);
                    if answer.is_none() {
                        self.lacks_answers.store(true, Ordering::Relaxed);
                    }
                    self.layout.write(answer.as_ref(), row_of_answer);
                }
                Err(_) if self.call.masks => self.layout.write_no_query(row_of_answer),
                Err(error) => return Err(bad_row("Q", first + row, single, error)),
            }
        }
        Ok(())
    }
}

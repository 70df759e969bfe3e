//! Many queries: from the rows of one array into the rows of another, on many threads.

use std::sync::Mutex;

use extricate::internals::cspace::Factor;
use extricate::internals::scene::units;
use extricate::{Answer, Config, ConfigSpace, Manifold, QueryOptions, QueryScratch, Scene, Termination};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use rayon::prelude::*;

use super::layout::Layout;
use super::options::Asked;
use crate::error::{threads, warn};
use crate::long_call;
use crate::rows::LOOK;
use crate::rows::arrays::{Configs, bad_row, configs};

/// Queries handed to a thread at once.
const CHUNK: usize = 32;

/// Memory that queries or checks reuse: one for each thread that was ever at it at the same time.
#[derive(Default)]
pub struct Scratches<Scratch = QueryScratch>(Mutex<Vec<Scratch>>);

impl<Scratch: Default> Scratches<Scratch> {
    /// Does `work` with one that nobody else uses meanwhile.
    pub fn with<T>(&self, work: impl FnOnce(&mut Scratch) -> T) -> T {
        let poisoned = "never poisoned: nothing panics while it is held";
        let mut scratch = self.0.lock().expect(poisoned).pop().unwrap_or_default();
        let result = work(&mut scratch);
        self.0.lock().expect(poisoned).push(scratch);
        result
    }
}

/// Limits of every coordinate, where all that is between them is a configuration: rows of free
/// space are answered in a few microseconds, and this tells most of them right in a few
/// nanoseconds. `None` where a rotation is among the coordinates.
fn plain_limits(space: &ConfigSpace) -> Option<Vec<[f64; 2]>> {
    let limits = |factor: &Factor| match factor.manifold {
        Manifold::Interval { lower, upper } => Some([lower, upper]),
        Manifold::Circle => Some([f64::MIN, f64::MAX]),
        Manifold::Rotation => None,
    };
    space.factors().iter().map(limits).collect()
}

/// Answers one query; `None` where nothing free was found.
pub type Ask<'a> = dyn Fn(&Config, &QueryOptions, &mut QueryScratch) -> Option<Answer> + Sync + 'a;

/// Looks at all rows before any is answered: nobody wants to hear after an hour that the last one
/// was wrong. Warns if one looks like degrees.
///
/// # Errors
/// That of the first wrong row, unless wrong rows are masked; `KeyboardInterrupt`.
fn look_over(py: Python<'_>, scene: &Scene, asked: &Asked, q: &Configs) -> PyResult<()> {
    let (rows, single) = (q.values(), q.single);
    let limits = plain_limits(&scene.space);
    let plain = |q: &[f64]| limits.iter().flatten().zip(q).all(|([lower, upper], x)| lower <= x && x <= upper);
    let watch = long_call::Watch::new();
    let stop = watch.stop();
    let look = || {
        let mut degrees = None;
        for (row, values) in rows.chunks_exact(scene.space.nq()).enumerate() {
            if row % LOOK == 0 && stop.is_asked() {
                break;
            }
            if limits.is_some() && plain(values) {
                continue;
            }
            if degrees.is_none() {
                degrees = units::degrees_hint(scene, values).map(|hint| (row, hint));
            }
            if !asked.masks {
                asked.config_of(values, scene).map_err(|error| bad_row("Q", row, single, error))?;
            }
        }
        Ok::<_, PyErr>(degrees)
    };
    let degrees = py.detach(|| watch.over(look))??;
    match degrees.filter(|_| !asked.refuses) {
        Some((row, hint)) => warn(py, &format!("Q[{row}]: {hint}")),
        None => Ok(()),
    }
}

/// What `ask`, given the options, says of each row of `queries`, configurations of `scene`, as a
/// structured array of [`Layout`].
///
/// # Errors
/// `ValueError` for a shape or a row that is no configuration, before anything is asked;
/// `MemoryError` where the answers cannot be kept; what [`long_call::run`] raises.
pub fn answers<'py>(
    queries: &Bound<'py, PyAny>,
    scene: &Scene,
    scratches: &Scratches,
    asked: Asked,
    ask: &Ask,
) -> PyResult<Bound<'py, PyAny>> {
    let py = queries.py();
    let (space, layout) = (&scene.space, Layout::new(scene, &asked.options));
    let nq = space.nq();
    let q = configs("Q", queries, space)?;
    let (values, rows, single) = (q.values(), q.rows, q.single);
    let pool = long_call::pool(threads(asked.threads)?)?;
    let config = |row: usize, q: &[f64]| asked.config_of(q, scene).map_err(|error| bad_row("Q", row, single, error));
    look_over(py, scene, &asked, &q)?;
    let size = layout.size().filter(|size| size.checked_mul(rows).is_some_and(|bytes| bytes <= isize::MAX as usize));
    let size = size.ok_or_else(|| PyMemoryError::new_err("query_batch: the answers are more than can be addressed"))?;
    // Written by the byte, because no type of Rust has the layout of a row; read through a view.
    let answers = py.import("numpy")?.call_method1("zeros", (rows * size, "u1"))?.cast_into::<PyArray1<u8>>()?;
    {
        let mut answers = answers.readwrite();
        let answers = answers.as_slice_mut().expect("contiguous: it was just made");
        let chunk = |line: &long_call::Line<()>,
                     options: &QueryOptions,
                     at: usize,
                     values: &[f64],
                     answers: &mut [u8]|
         -> PyResult<()> {
            scratches.with(|scratch| {
                let rows = values.chunks_exact(nq).zip(answers.chunks_exact_mut(size));
                for (row, (q, answer)) in rows.enumerate().take_while(|_| !line.stopped()) {
                    match config(at * CHUNK + row, q) {
                        Ok(config) => layout.write(ask(&config, options, scratch).as_ref(), answer),
                        Err(_) if asked.masks => layout.write_no_query(answer),
                        Err(error) => return Err(error),
                    }
                }
                Ok(())
            })
        };
        long_call::run(
            py,
            |_, ()| Ok(()),
            |line| {
                let options = QueryOptions {
                    termination: Termination { stop: Some(line.stop()), ..asked.options.termination.clone() },
                    ..asked.options.clone()
                };
                let answers = || {
                    let answers = answers.par_chunks_mut(CHUNK * size);
                    let chunks = values.par_chunks(CHUNK * nq).zip(answers).enumerate();
                    chunks.try_for_each(|(at, (values, answers))| chunk(line, &options, at, values, answers))
                };
                pool.install(answers)
            },
        )??;
    }
    answers.call_method1("view", (layout.dtype(py, size)?,))
}

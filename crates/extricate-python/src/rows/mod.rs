//! One value for each of many configurations, on many threads.

pub mod arrays;
pub mod segments;

use extricate::internals::scene::units;
use extricate::{CheckScratch, Checker};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::long_call;
use crate::scene::Scene;
use arrays::{Configs, bad_row};

/// Configurations handed to a thread at once: the least work that is worth the handing out.
const CHUNK: usize = 64;
/// Rows that the kernel for many checks at once.
pub const GROUP: usize = 8;
/// Rows, of which each takes about a microsecond, after which a call looks whether to stop.
pub const LOOK: usize = 4096;
/// Fewer configurations than this are not worth starting threads for.
const FEW: usize = 64;

impl Scene {
    /// Fills one value for each row, on `threads` threads. `one` sees rows that were checked, at
    /// most `at_once`, after which a call looks whether to stop: some rows take a tenth of a
    /// second.
    pub fn map_rows<T: Send + Default + Clone>(
        &self,
        py: Python<'_>,
        q: &Configs<'_>,
        (threads, at_once): (usize, usize),
        one: impl Fn(&Checker, &[f64], &mut [T], &mut CheckScratch) + Sync,
    ) -> PyResult<Vec<T>> {
        let (values, rows, single, nq) = (q.values(), q.rows, q.single, self.inner().space.nq());
        let mut found = vec![T::default(); rows];
        let checker = py.detach(|| self.checker())?;
        let group = |first: usize, values: &[f64], found: &mut [T], scratch: &mut CheckScratch| -> PyResult<()> {
            let mut checked = Vec::with_capacity(values.len());
            for (row, q) in values.chunks_exact(nq).enumerate() {
                let q = units::config(self.inner(), q).map_err(|error| bad_row("Q", first + row, single, error))?;
                checked.extend_from_slice(&q);
            }
            one(checker, &checked, found, scratch);
            Ok(())
        };
        let chunk =
            |first: usize, values: &[f64], found: &mut [T], scratch: &mut CheckScratch, stop: &dyn Fn() -> bool| {
                let mut groups = values.chunks(at_once * nq).zip(found.chunks_mut(at_once)).enumerate();
                groups.try_for_each(|(at, (values, found))| match stop() {
                    true => Ok(()),
                    false => group(first + at * at_once, values, found, scratch),
                })
            };
        if rows <= at_once {
            py.detach(|| self.scratches().with(|scratch| group(0, values, &mut found, scratch)))?;
            return Ok(found);
        }
        if rows <= FEW {
            let watch = long_call::Watch::new();
            let stop = watch.stop();
            let few = || self.scratches().with(|scratch| chunk(0, values, &mut found, scratch, &|| stop.is_asked()));
            py.detach(|| watch.over(few))??;
            return Ok(found);
        }
        let pool = long_call::pool(threads)?;
        let result = long_call::run(
            py,
            |_, ()| Ok(()),
            |line| {
                let results = || {
                    values
                        .par_chunks(CHUNK * nq)
                        .zip(found.par_chunks_mut(CHUNK))
                        .enumerate()
                        .try_for_each_init(CheckScratch::default, |scratch, (at, (values, found))| {
                            chunk(at * CHUNK, values, found, scratch, &|| line.stopped())
                        })
                };
                pool.install(results)
            },
        )?;
        result?;
        Ok(found)
    }
}

/// One value for `(nq,)`, a list of them for `(n, nq)`.
pub fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    single: bool,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = PyArray1::from_vec(py, values);
    if single { array.reshape(Vec::new()) } else { Ok(array.to_dyn().clone()) }
}

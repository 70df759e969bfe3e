//! `signed_distance` and `free_radius`: how far configurations are from the boundary of the free
//! ones.

use extricate::SignedDistance;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;

use super::options::{Call, termination};
use crate::error::{Whole, exception, threads as thread_count};
use crate::long_call;
use crate::rows::arrays::{bad_row, configs};
use crate::solver::handle::Handle;

/// Keywords of `signed_distance`, in the order of its signature.
pub type Keywords = (Option<f64>, Option<Whole>, Option<f64>, i64);

/// Returns the signed distances of all rows, in a structured array.
///
/// # Errors
/// `ValueError` for a shape, a row or an option that makes no sense; the exceptions of
/// [`long_call::run`].
pub fn signed_distance<'py>(
    handle: &Handle,
    queries: &Bound<'py, PyAny>,
    (within, max_checks, max_seconds, threads): Keywords,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (queries.py(), handle.scene());
    let q = configs("Q", queries, scene.space())?;
    let mut call = handle.call_options(py, None, Call::Batch)?;
    let limits = termination(max_checks, max_seconds)?;
    let own = &mut call.options.termination;
    (own.max_checks, own.max_seconds) = (limits.max_checks.or(own.max_checks), limits.max_seconds.or(own.max_seconds));
    let solver = handle.solver_for(py, &call)?;
    let pool = long_call::pool(thread_count(threads)?)?;
    let (values, single, nq) = (q.values(), q.single, scene.space().nq());
    let all = |line: &long_call::Line<()>| {
        let solver = call.stopped_by(&solver, line.stop());
        let one = |(row, q): (usize, &[f64])| -> PyResult<Option<SignedDistance>> {
            if line.stopped() {
                return Ok(None);
            }
            let config = call.config_of(q, scene).map_err(|error| bad_row("Q", row, single, error))?;
            solver.signed_distance(&config, within).map_err(exception)
        };
        pool.install(|| values.par_chunks_exact(nq).enumerate().map(one).collect::<PyResult<Vec<_>>>())
    };
    let found = long_call::run(py, |_, ()| Ok(()), all)??;
    if found.iter().any(Option::is_none) {
        handle.advise(py)?;
    }
    array(py, &found, (nq, scene.space().nv()), single)
}

/// Returns the proved free radii of all rows, float64 (n,), or a float for one.
///
/// # Errors
/// Those of [`signed_distance`].
pub fn free_radius<'py>(handle: &Handle, queries: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (queries.py(), handle.scene());
    let q = configs("Q", queries, scene.space())?;
    let solver = handle.ready(py)?;
    let pool = long_call::pool(thread_count(threads)?)?;
    let (values, single, nq) = (q.values(), q.single, scene.space().nq());
    let all = |line: &long_call::Line<()>| {
        let one = |(row, q): (usize, &[f64])| -> PyResult<f64> {
            if line.stopped() {
                return Ok(0.0);
            }
            let config = scene.space().config_anywhere(q).map_err(|error| bad_row("Q", row, single, error))?;
            Ok(solver.free_radius(&config))
        };
        pool.install(|| values.par_chunks_exact(nq).enumerate().map(one).collect::<PyResult<Vec<_>>>())
    };
    let radii = long_call::run(py, |_, ()| Ok(()), all)??;
    match radii[..] {
        [radius] if single => Ok(radius.into_pyobject(py)?.into_any()),
        _ => Ok(PyArray1::from_vec(py, radii).into_any()),
    }
}

fn array<'py>(
    py: Python<'py>,
    found: &[Option<SignedDistance>],
    (nq, nv): (usize, usize),
    single: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let fields = (
        ("distance", "f8"),
        ("bound", "f8"),
        ("witness", "f8", nq),
        ("gradient", "f8", nv),
        ("pair", "i8"),
        ("checks", "i8"),
        ("cut_short", "?"),
    );
    let fields: Bound<'_, PyTuple> = fields.into_pyobject(py)?;
    let rows = py.import("numpy")?.call_method1("zeros", (found.len(), fields.to_list()))?;
    let numbers = |of: &dyn Fn(&SignedDistance) -> f64| {
        PyArray1::from_iter(py, found.iter().map(|row| row.as_ref().map_or(f64::NAN, of)))
    };
    let table = |width: usize, of: &dyn Fn(&SignedDistance) -> Option<Vec<f64>>| {
        let rows = found.iter().map(|row| row.as_ref().and_then(of).unwrap_or_else(|| vec![f64::NAN; width]));
        PyArray1::from_iter(py, rows.flatten()).reshape([found.len(), width])
    };
    rows.set_item("distance", numbers(&|row| row.distance))?;
    rows.set_item("bound", numbers(&|row| row.bound))?;
    rows.set_item("witness", table(nq, &|row| row.witness.as_ref().map(|witness| witness.to_vec()))?)?;
    rows.set_item("gradient", table(nv, &|row| Some(row.gradient.clone()))?)?;
    let pair = |row: &Option<SignedDistance>| row.as_ref()?.pairs.first().map(|pair| pair.index() as i64);
    rows.set_item("pair", PyArray1::from_iter(py, found.iter().map(|row| pair(row).unwrap_or(-1))))?;
    let checks = found.iter().map(|row| row.as_ref().map_or(0, |row| row.checks as i64));
    rows.set_item("checks", PyArray1::from_iter(py, checks))?;
    let cut = found.iter().map(|row| row.as_ref().is_some_and(|row| row.cut_short));
    rows.set_item("cut_short", PyArray1::from_iter(py, cut))?;
    if single { rows.get_item(0) } else { Ok(rows) }
}

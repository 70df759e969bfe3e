//! `repair`: replaces paths that collide by paths near them that are proved free.

use extricate::{RepairOptions, Repaired, Rows};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::{PYTHON_MODULE, rows};
use crate::error::{Whole, exception};
use crate::long_call;
use crate::queries::options::{kept_links, termination};
use crate::rows::arrays::configs;
use crate::solver::handle::Handle;

static REPAIRED: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `repair`, in the order of its signature.
pub type Keywords<'py> = (
    Option<f64>,
    Option<f64>,
    Option<Bound<'py, PyAny>>,
    bool,
    Option<f64>,
    Option<f64>,
    f64,
    u64,
    Option<Whole>,
    Option<f64>,
);

pub fn repair<'py>(handle: &Handle, path: &Bound<'py, PyAny>, keywords: Keywords<'py>) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene, space) = (path.py(), handle.scene(), handle.scene().space());
    let (aim, max_deviation, keep, frames, max_step, touch, resolution, seed, max_checks, max_seconds) = keywords;
    let old = configs("path", path, space)?.values().to_vec();
    let watch = long_call::Watch::new();
    let termination = termination(max_checks, max_seconds)?.stop(watch.stop());
    let mut options = RepairOptions::default().resolution(resolution).seed(seed).termination(termination);
    (options.aim, options.max_deviation) = (aim, max_deviation);
    options.keep = kept_links(keep, scene)?;
    (options.frames, options.max_step, options.touch) = (frames, max_step, touch);
    let solver = handle.ready(py)?;
    let repair = || solver.repair(Rows::new(&old, space.nq())?, &options);
    let found = py.detach(|| watch.over(repair))?.map_err(exception)?;
    let Repaired { points, places, deviation, length, length_before, stretches, gaps, touched, kept, checks, .. } =
        found;
    let places = PyArray1::from_vec(py, places);
    let points = rows(py, &points)?;
    let fields = (points, places, deviation, length, length_before, stretches, gaps, touched, kept, checks);
    REPAIRED.import(py, PYTHON_MODULE, "Repaired")?.call1(fields)
}

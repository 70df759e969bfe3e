//! `repair`: paths that collide, as proved ones near them.

use extricate::{RepairOptions, Repaired, Rows, Termination};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::{HOME, rows, termination};
use crate::error::{Whole, exception};
use crate::long_call;
use crate::queries::Source;
use crate::rows::arrays::configs;

static REPAIRED: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `repair`, in the order of its signature.
pub type Keywords = (Option<f64>, Option<f64>, f64, u64, Option<Whole>, Option<f64>);

/// See `Scene.repair`.
pub fn repair<'py>(source: Source, path: &Bound<'py, PyAny>, keywords: Keywords) -> PyResult<Bound<'py, PyAny>> {
    let (py, space) = (path.py(), &source.scene().space);
    let (aim, max_deviation, resolution, seed, max_checks, max_seconds) = keywords;
    let old = configs("path", path, space)?.values().to_vec();
    let watch = long_call::Watch::new();
    let termination = Termination { stop: Some(watch.stop()), ..termination(max_checks, max_seconds)? };
    let options = RepairOptions { aim, max_deviation, resolution, seed, termination };
    let repair = || source.view().repair(Rows::new(&old, space.nq())?, &options);
    let found = py.detach(|| watch.over(repair))?.map_err(exception)?;
    let Repaired { points, places, deviation, length, length_before, stretches, gaps, checks } = found;
    let points = if points.is_empty() { None } else { Some(rows(py, &points)?) };
    let places = PyArray1::from_vec(py, places);
    let fields = (points, places, deviation, length, length_before, stretches, gaps, checks);
    REPAIRED.import(py, HOME, "Repaired")?.call1(fields)
}

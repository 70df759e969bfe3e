//! Implements the calls for motions and grasps.

pub mod escape;
pub mod plan;
pub mod release;
pub mod repair;
pub mod roadmap;

use extricate::{Config, Scene};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::rows::arrays::{bad_row, one_config};

/// Python module with the classes that motions return.
const PYTHON_MODULE: &str = "extricate._motion";

/// Reads a configuration within its limits from the argument `name`.
fn config(name: &str, value: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<Config> {
    let q = one_config(name, value, scene.space())?;
    scene.config(q.values()).map_err(|error| bad_row(name, 0, true, error))
}

/// Returns the points of a path, `(n, nq)`; `None` if there is no path.
fn rows<'py>(py: Python<'py>, points: &[Vec<f64>]) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
    Ok(if points.is_empty() { None } else { Some(PyArray2::from_vec2(py, points)?) })
}

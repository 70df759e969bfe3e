//! Motions of a scene, a model, or a model in another scene: the calls that they share.

pub mod escape;
pub mod plan;
pub mod repair;
pub mod roadmap;

use extricate::internals::scene::units;
use extricate::{Config, Scene, Termination};
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Whole, count};
use crate::rows::arrays::{bad_row, one_config};

/// Where the classes of Python's half are.
const HOME: &str = "extricate._motion";

/// A configuration within its limits; `name` is the argument's.
fn config(name: &str, value: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<Config> {
    let q = one_config(name, value, &scene.space)?;
    units::config(scene, q.values()).map_err(|error| bad_row(name, 0, true, error))
}

/// When to give up.
fn termination(max_checks: Option<Whole>, max_seconds: Option<f64>) -> PyResult<Termination> {
    if let Some(bad) = max_seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
        return Err(PyValueError::new_err(format!("max_seconds: got {bad}, expected more than 0")));
    }
    let max_checks = max_checks.map(|checks| count("max_checks", checks, 0)).transpose()?;
    Ok(Termination { max_checks, max_seconds, stop: None })
}

/// Points of a path, `(n, nq)`.
fn rows<'py>(py: Python<'py>, points: &[Vec<f64>]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    Ok(PyArray2::from_vec2(py, points)?)
}

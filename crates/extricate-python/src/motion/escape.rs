//! `escape`: paths out of collision.

use extricate::{Escape, EscapeMethod, EscapeOptions, Scene};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::{PYTHON_MODULE, config, rows};
use crate::error::{Whole, count, exception};
use crate::long_call;
use crate::queries::options::{kept_links, termination};
use crate::solver::handle::Handle;

static ESCAPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `escape`, in the order of its signature.
pub type Keywords<'py> = (
    Option<f64>,
    f64,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Whole,
    f64,
    Whole,
    u64,
    Option<Whole>,
    Option<f64>,
);

pub fn escape<'py>(handle: &Handle, q: &Bound<'py, PyAny>, keywords: Keywords<'py>) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (q.py(), handle.scene());
    let (aim, tolerance, keep, toward, exits, resolution, tree_checks, seed, max_checks, max_seconds) = keywords;
    let q = config("q", q, scene)?;
    let watch = long_call::Watch::new();
    let mut options = EscapeOptions::default()
        .tolerance(tolerance)
        .exits(count("exits", exits, 0)?)
        .resolution(resolution)
        .tree_checks(count("tree_checks", tree_checks, 0)?)
        .seed(seed)
        .termination(termination(max_checks, max_seconds)?.stop(watch.stop()));
    options.aim = aim;
    options.keep = kept_links(keep, scene)?;
    options.toward = toward.map(|goal| config("toward", &goal, scene)).transpose()?;
    let solver = handle.ready(py)?;
    let found = py.detach(|| watch.over(|| solver.escape(&q, &options)))?.map_err(exception)?;
    if !found.is_found() {
        handle.advise(py)?;
    }
    object(py, scene, found)
}

/// Makes the Python object for an escape.
pub fn object<'py>(py: Python<'py>, scene: &Scene, escape: Escape) -> PyResult<Bound<'py, PyAny>> {
    let Escape { points, free_from, method, colliding, deepening, length, max_displacement, checks, .. } = escape;
    let colliding: Vec<((&str, &str), f64)> =
        colliding.into_iter().map(|(pair, depth)| (scene.pair_names(pair).into(), depth)).collect();
    let (points, method, needed) = (rows(py, &points)?, method.map(EscapeMethod::name), escape.needed_tolerance);
    let fields = (points, free_from, method, colliding, deepening, needed, length, max_displacement, checks);
    ESCAPE.import(py, PYTHON_MODULE, "Escape")?.call1(fields)
}

//! `escape`: paths out of collision.

use extricate::{Escape, EscapeMethod, EscapeOptions, Termination};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::{HOME, config, rows, termination};
use crate::error::{Advice, Whole, count, exception};
use crate::long_call;
use crate::queries::Source;

static ESCAPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `escape`, in the order of its signature.
pub type Keywords = (Option<f64>, f64, Whole, f64, Whole, u64, Option<Whole>, Option<f64>);

/// See `Scene.escape`.
pub fn escape<'py>(
    source: Source,
    q: &Bound<'py, PyAny>,
    keywords: Keywords,
    advice: &Advice,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (q.py(), source.scene());
    let (aim, tolerance, exits, resolution, tree_checks, seed, max_checks, max_seconds) = keywords;
    let (exits, tree_checks) = (count("exits", exits, 0)?, count("tree_checks", tree_checks, 0)?);
    let q = config("q", q, scene)?;
    let watch = long_call::Watch::new();
    let termination = Termination { stop: Some(watch.stop()), ..termination(max_checks, max_seconds)? };
    let options = EscapeOptions { aim, tolerance, exits, resolution, tree_checks, seed, termination };
    let found = py.detach(|| watch.over(|| source.view().escape(&q, &options)))?.map_err(exception)?;
    let Escape { points, free_from, method, colliding, deepening, length, max_displacement, checks } = found;
    let colliding: Vec<((&str, &str), f64)> =
        colliding.into_iter().map(|(pair, depth)| (scene.pair_names(pair).into(), depth)).collect();
    if points.is_empty() {
        advice.warn(py, source.view().checker())?;
    }
    let points = if points.is_empty() { None } else { Some(rows(py, &points)?) };
    let method = method.map(EscapeMethod::name);
    let fields = (points, free_from, method, colliding, deepening, length, max_displacement, checks);
    ESCAPE.import(py, HOME, "Escape")?.call1(fields)
}

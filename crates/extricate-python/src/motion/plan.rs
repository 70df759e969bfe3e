//! `plan`: proved paths between free configurations.

use extricate::{Plan, PlanMethod, PlanOptions, Termination};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::roadmap::Roadmap;
use super::{HOME, config, rows, termination};
use crate::error::{Whole, exception, threads as thread_count};
use crate::long_call;
use crate::queries::Source;

static PLAN: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `plan`, in the order of its signature.
pub type Keywords<'py> = (Option<Bound<'py, Roadmap>>, f64, bool, u64, i64, Option<Whole>, Option<f64>);

/// See `Scene.plan`.
pub fn plan<'py>(
    source: Source,
    (from, to): (&Bound<'py, PyAny>, &Bound<'py, PyAny>),
    keywords: Keywords<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (from.py(), source.scene());
    let (roadmap, resolution, shortcut, seed, threads, max_checks, max_seconds) = keywords;
    let (from, to) = (config("start", from, scene)?, config("goal", to, scene)?);
    let (threads, termination) = (thread_count(threads)?, termination(max_checks, max_seconds)?);
    let busy = || PyValueError::new_err("roadmap: got one that another thread is using, expected one for each");
    let kept = roadmap.as_ref().map(|roadmap| roadmap.get());
    let mut inner = match kept {
        Some(kept) => kept.take().ok_or_else(busy)?,
        None => extricate::Roadmap::new(&scene.space, seed),
    };
    let found = long_call::run(
        py,
        |_, ()| Ok(()),
        |line| {
            let termination = Termination { stop: Some(line.stop()), ..termination };
            let options = PlanOptions { resolution, shortcut, seed, threads, termination };
            source.view().plan_with(&from, &to, &options, &mut inner)
        },
    );
    if let Some(kept) = kept {
        kept.give_back(inner);
    }
    let Plan { points, method, length, checks, nodes } = found?.map_err(exception)?;
    let points = if points.is_empty() { None } else { Some(rows(py, &points)?) };
    PLAN.import(py, HOME, "Plan")?.call1((points, method.map(PlanMethod::name), length, checks, nodes))
}

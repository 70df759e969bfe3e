//! `plan`: proved paths between free configurations.

use extricate::{Plan, PlanMethod, PlanOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::roadmap::Roadmap;
use super::{PYTHON_MODULE, config, escape, rows};
use crate::error::{Whole, exception, threads as thread_count};
use crate::long_call;
use crate::queries::options::{kept_links, termination};
use crate::solver::handle::Handle;

static PLAN: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Keywords of `plan`, in the order of its signature.
pub type Keywords<'py> = (
    Option<Bound<'py, Roadmap>>,
    f64,
    f64,
    Option<Bound<'py, PyAny>>,
    Option<f64>,
    bool,
    u64,
    i64,
    Option<Whole>,
    Option<f64>,
);

pub fn plan<'py>(
    handle: &Handle,
    (from, to): (&Bound<'py, PyAny>, &Bound<'py, PyAny>),
    keywords: Keywords<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (from.py(), handle.scene());
    let (roadmap, resolution, tolerance, keep, clearance, shortcut, seed, threads, max_checks, max_seconds) = keywords;
    let (from, to) = (config("start", from, scene)?, config("goal", to, scene)?);
    let mut options = PlanOptions::default()
        .resolution(resolution)
        .tolerance(tolerance)
        .shortcut(shortcut)
        .seed(seed)
        .threads(thread_count(threads)?)
        .termination(termination(max_checks, max_seconds)?);
    options.clearance = clearance;
    options.keep = kept_links(keep, scene)?;
    let solver = handle.ready(py)?;
    let busy = || PyValueError::new_err("roadmap: got one that another thread is using, expected one for each");
    let kept = roadmap.as_ref().map(|roadmap| roadmap.get());
    let mut inner = match kept {
        Some(kept) => kept.take().ok_or_else(busy)?,
        None => extricate::Roadmap::new(scene.space(), seed),
    };
    let found = long_call::run(
        py,
        |_, ()| Ok(()),
        |line| {
            let termination = options.termination.clone().stop(line.stop());
            solver.plan_with(&from, &to, &options.termination(termination), &mut inner)
        },
    );
    if let Some(kept) = kept {
        kept.give_back(inner);
    }
    let Plan { points, free_from, free_to, start_escape, goal_escape, method, length, checks, nodes, .. } =
        found?.map_err(exception)?;
    let [start, goal] =
        [start_escape, goal_escape].map(|escape| escape.map(|found| escape::object(py, scene, found)).transpose());
    let (points, method) = (rows(py, &points)?, method.map(PlanMethod::name));
    let fields = (points, free_from, free_to, start?, goal?, method, length, checks, nodes);
    PLAN.import(py, PYTHON_MODULE, "Plan")?.call1(fields)
}

//! Answers of queries as objects, and the options of what is asked.

use extricate::penetration::options::MOST_WAYS_OUT;
use extricate::{Effort, QueryBudget, QueryOptions, Scene};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyTuple, PyType};

use crate::error::count;

/// Where the classes of Python's half are.
const HOME: &str = "extricate._answer";
static ANSWER: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONTACT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static EXIT: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// `answer` as an object of the class `Answer`, with the names that `scene` gives pairs.
pub fn object<'py>(py: Python<'py>, answer: extricate::Answer, scene: &Scene) -> PyResult<Bound<'py, PyAny>> {
    let pair = |pair: usize| -> (&str, &str) { scene.pair_names(pair).into() };
    let named = |pairs: &[usize]| -> Vec<(&str, &str)> { pairs.iter().map(|&index| pair(index)).collect() };
    let contact = |contact: &extricate::Contact| {
        let points = [contact.point_first, contact.point_second].map(|point| point.iter().copied().collect());
        let points = PyArray2::from_vec2(py, &points)?;
        let normal = PyArray1::from_iter(py, contact.normal.iter().copied());
        CONTACT.import(py, HOME, "Contact")?.call1((pair(contact.pair), contact.distance, points, normal))
    };
    let exit = |exit: &extricate::Exit| {
        let witness = PyArray1::from_slice(py, &exit.witness);
        EXIT.import(py, HOME, "Exit")?.call1((exit.depth, witness, named(&exit.touching)))
    };
    let fields: [Bound<'_, PyAny>; 17] = [
        answer.depth.into_pyobject(py)?.into_any(),
        answer.lower_bound.into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, &answer.witness).into_any(),
        answer.verified.into_pyobject(py)?.to_owned().into_any(),
        answer.coverage.into_pyobject(py)?.into_any(),
        answer.unseen.into_pyobject(py)?.into_any(),
        answer.max_displacement.into_pyobject(py)?.into_any(),
        named(&answer.colliding).into_pyobject(py)?.into_any(),
        scene.joints_of(&answer.outside).into_pyobject(py)?.into_any(),
        named(&answer.touching).into_pyobject(py)?.into_any(),
        answer.contacts.iter().map(contact).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, &answer.gradient).into_any(),
        answer.unique.into_pyobject(py)?.to_owned().into_any(),
        answer.exits.iter().map(exit).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        answer.way.map(|way| (way.colliding_until, way.free_from)).into_pyobject(py)?.into_any(),
        answer.checks.into_pyobject(py)?.into_any(),
        name(answer.effort).into_pyobject(py)?.into_any(),
    ];
    ANSWER.import(py, HOME, "Answer")?.call1(PyTuple::new(py, fields)?)
}

/// The options of a query, checked.
///
/// # Errors
/// `ValueError` that says what was expected.
pub fn options(
    effort: &str,
    exits: i64,
    starts: Option<i64>,
    checks: Option<i64>,
    seconds: Option<f64>,
    [way, contacts]: [bool; 2],
) -> PyResult<QueryOptions> {
    let known = [Effort::Nearest, Effort::Refined, Effort::Exhaustive];
    let found = known.into_iter().find(|known| name(*known) == effort).ok_or_else(|| {
        PyValueError::new_err(format!("effort: got \"{effort}\", expected \"nearest\", \"refined\" or \"exhaustive\""))
    })?;
    let wanted = usize::try_from(exits).ok().filter(|wanted| (1..=MOST_WAYS_OUT).contains(wanted));
    let wrong = || PyValueError::new_err(format!("exits: got {exits}, expected 1 to {MOST_WAYS_OUT}"));
    let exits = wanted.ok_or_else(wrong)?;
    if exits > 1 && found == Effort::Nearest {
        let message = format!("exits: got {exits} with effort \"nearest\", expected 1: others are found by refinement");
        return Err(PyValueError::new_err(message));
    }
    if let Some(bad) = seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
        return Err(PyValueError::new_err(format!("seconds: got {bad}, expected more than 0")));
    }
    let starts = starts.map(|starts| count("starts", starts, 1)).transpose()?;
    if let Some(starts) = starts.filter(|_| found == Effort::Nearest) {
        let message = format!("starts: got {starts} with effort \"nearest\", expected None: it refines nothing");
        return Err(PyValueError::new_err(message));
    }
    let checks = checks.map(|checks| count("checks", checks, 0)).transpose()?;
    let budget = QueryBudget { checks, seconds };
    Ok(QueryOptions { effort: found, exits, starts, budget, stop: None, way, contacts })
}

fn name(effort: Effort) -> &'static str {
    match effort {
        Effort::Nearest => "nearest",
        Effort::Refined => "refined",
        Effort::Exhaustive => "exhaustive",
    }
}

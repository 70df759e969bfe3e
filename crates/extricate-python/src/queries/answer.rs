//! Answers of queries as objects.

use extricate::{Effort, PairId, Scene};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyTuple, PyType};

/// Where the classes of Python's half are.
const HOME: &str = "extricate._answer";
static ANSWER: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONTACT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static EXIT: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// `answer` as an object of the class `Answer`, with the names that `scene` gives pairs.
pub fn object<'py>(py: Python<'py>, answer: extricate::Answer, scene: &Scene) -> PyResult<Bound<'py, PyAny>> {
    let pair = |pair: PairId| -> (&str, &str) { scene.pair_names(pair).into() };
    let named = |pairs: &[PairId]| -> Vec<(&str, &str)> { pairs.iter().map(|&index| pair(index)).collect() };
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
    let fields: [Bound<'_, PyAny>; 22] = [
        answer.depth.into_pyobject(py)?.into_any(),
        answer.lower_bound.into_pyobject(py)?.into_any(),
        answer.gap.into_pyobject(py)?.into_any(),
        answer.unproved.map(extricate::Unproved::name).into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, &answer.witness).into_any(),
        answer.verified.into_pyobject(py)?.to_owned().into_any(),
        answer.clearance.into_pyobject(py)?.into_any(),
        answer.unseen.into_pyobject(py)?.into_any(),
        answer.max_displacement.into_pyobject(py)?.into_any(),
        named(&answer.colliding).into_pyobject(py)?.into_any(),
        scene.joints_of(&answer.outside).into_pyobject(py)?.into_any(),
        named(&answer.touching).into_pyobject(py)?.into_any(),
        answer.contacts.iter().map(contact).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, &answer.gradient).into_any(),
        answer.unique.into_pyobject(py)?.to_owned().into_any(),
        answer.cut_short.into_pyobject(py)?.to_owned().into_any(),
        answer.exits.iter().map(exit).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        answer.segment.map(|segment| (segment.colliding_until, segment.free_from)).into_pyobject(py)?.into_any(),
        answer.free_radius.into_pyobject(py)?.into_any(),
        answer.nearest.into_pyobject(py)?.into_any(),
        answer.checks.into_pyobject(py)?.into_any(),
        effort_name(answer.effort).into_pyobject(py)?.into_any(),
    ];
    ANSWER.import(py, HOME, "Answer")?.call1(PyTuple::new(py, fields)?)
}

/// What Python calls an effort.
pub fn effort_name(effort: Effort) -> &'static str {
    effort.name()
}

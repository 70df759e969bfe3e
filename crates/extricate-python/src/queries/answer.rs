//! Converts answers of queries to Python objects.

use extricate::{Answer, ContactRecord, ExitRecord, Scene, Unproved};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyTuple, PyType};

/// Python module with the classes of answers.
const PYTHON_MODULE: &str = "extricate._answer";
static ANSWER: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONTACT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static EXIT: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Converts `answer` to the Python class `Answer`; `scene` has the names of pairs.
pub fn object<'py>(py: Python<'py>, answer: &Answer, scene: &Scene) -> PyResult<Bound<'py, PyAny>> {
    let answer = answer.record(scene);
    let contact = |contact: &ContactRecord| {
        let points = PyArray2::from_vec2(py, &[contact.point_first, contact.point_second].map(Vec::from))?;
        let normal = PyArray1::from_slice(py, &contact.normal);
        CONTACT.import(py, PYTHON_MODULE, "Contact")?.call1((pair(contact.pair), contact.distance, points, normal))
    };
    let exit = |exit: &ExitRecord| {
        let witness = PyArray1::from_slice(py, exit.witness);
        EXIT.import(py, PYTHON_MODULE, "Exit")?.call1((exit.depth, witness, pairs(&exit.touching)))
    };
    let fields: [Bound<'_, PyAny>; 25] = [
        answer.depth.into_pyobject(py)?.into_any(),
        answer.lower_bound.into_pyobject(py)?.into_any(),
        answer.gap.into_pyobject(py)?.into_any(),
        answer.unproved.map(Unproved::name).into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, answer.witness).into_any(),
        answer.verified.into_pyobject(py)?.to_owned().into_any(),
        answer.clearance.into_pyobject(py)?.into_any(),
        answer.unseen.into_pyobject(py)?.into_any(),
        answer.max_displacement.into_pyobject(py)?.into_any(),
        pairs(&answer.colliding).into_pyobject(py)?.into_any(),
        answer.outside.into_pyobject(py)?.into_any(),
        answer.off.to_vec().into_pyobject(py)?.into_any(),
        answer.kept.iter().map(|kept| (kept.position, kept.rotation)).collect::<Vec<_>>().into_pyobject(py)?.into_any(),
        pairs(&answer.touching).into_pyobject(py)?.into_any(),
        answer.contacts.iter().map(contact).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, answer.gradient).into_any(),
        answer.unique.into_pyobject(py)?.to_owned().into_any(),
        answer.cut_short.into_pyobject(py)?.to_owned().into_any(),
        answer.exits.iter().map(exit).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any(),
        answer.segment.map(|segment| (segment.colliding_until, segment.free_from)).into_pyobject(py)?.into_any(),
        answer.free_radius.into_pyobject(py)?.into_any(),
        answer.nearest.into_pyobject(py)?.into_any(),
        answer.detour.into_pyobject(py)?.to_owned().into_any(),
        answer.checks.into_pyobject(py)?.into_any(),
        answer.effort.name().into_pyobject(py)?.into_any(),
    ];
    ANSWER.import(py, PYTHON_MODULE, "Answer")?.call1(PyTuple::new(py, fields)?)
}

fn pair([first, second]: [&str; 2]) -> (&str, &str) {
    (first, second)
}

fn pairs<'a>(named: &[[&'a str; 2]]) -> Vec<(&'a str, &'a str)> {
    named.iter().map(|&[first, second]| (first, second)).collect()
}

//! Answers of queries: one as an object, many as rows of a structured array.

use extricate::{Effort, QueryBudget, QueryOptions, Scene};
use numpy::{PyArray1, PyArray2, PyArrayDescr};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};

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
    let fields: [Bound<'_, PyAny>; 15] = [
        answer.depth.into_pyobject(py)?.into_any(),
        answer.lower_bound.into_pyobject(py)?.into_any(),
        PyArray1::from_slice(py, &answer.witness).into_any(),
        answer.verified.into_pyobject(py)?.to_owned().into_any(),
        answer.coverage.into_pyobject(py)?.into_any(),
        answer.max_displacement.into_pyobject(py)?.into_any(),
        named(&answer.colliding).into_pyobject(py)?.into_any(),
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
    let exits = count("exits", exits, 1)?;
    if exits > 1 && found == Effort::Nearest {
        let message = format!("exits: got {exits} with effort \"nearest\", expected 1: others are found by refinement");
        return Err(PyValueError::new_err(message));
    }
    if let Some(bad) = seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
        return Err(PyValueError::new_err(format!("seconds: got {bad}, expected more than 0")));
    }
    let starts = starts.map(|starts| count("starts", starts, 1)).transpose()?;
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

/// Numbers of a row before the witness.
const FRONT: usize = 5;

/// How an answer is laid out in a row of a structured array: numbers of eight bytes, then truth values.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    nq: usize,
    nv: usize,
}

impl Layout {
    /// Of answers with witnesses of `nq` coordinates and gradients of `nv`.
    pub fn new(nq: usize, nv: usize) -> Self {
        Self { nq, nv }
    }

    /// Bytes of a row.
    pub fn size(self) -> usize {
        8 * (FRONT + self.nq + self.nv) + 8
    }

    /// The NumPy type of a row.
    pub fn dtype(self, py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        let numpy = py.import("numpy")?;
        let format = |text: &str| numpy.call_method1("dtype", (text,));
        let vector = |length: usize| numpy.call_method1("dtype", (("f8", (length,)),));
        let (witness, after) = (8 * FRONT, self.size() - 8);
        let names = [
            "depth",
            "lower_bound",
            "max_displacement",
            "coverage",
            "checks",
            "witness",
            "gradient",
            "verified",
            "free",
            "unique",
        ];
        let formats = [
            format("f8")?,
            format("f8")?,
            format("f8")?,
            format("f8")?,
            format("i8")?,
            vector(self.nq)?,
            vector(self.nv)?,
            format("?")?,
            format("?")?,
            format("?")?,
        ];
        let fields = PyDict::new(py);
        fields.set_item("names", names)?;
        fields.set_item("formats", formats)?;
        let gradient = witness + 8 * self.nq;
        fields.set_item("offsets", [0, 8, 16, 24, 32, witness, gradient, after, after + 1, after + 2])?;
        fields.set_item("itemsize", self.size())?;
        Ok(numpy.call_method1("dtype", (fields,))?.cast_into()?)
    }

    /// Writes an answer into the bytes of its row; where there is none, an infinite depth and no numbers.
    pub fn write(self, answer: Option<&extricate::Answer>, row: &mut [u8]) {
        let mut words = row.chunks_exact_mut(8);
        let mut put = |bytes: [u8; 8]| words.next().expect("a row is as long as its layout").copy_from_slice(&bytes);
        let Some(answer) = answer else {
            [f64::INFINITY, 0.0, f64::NAN, f64::NAN].iter().for_each(|x| put(x.to_ne_bytes()));
            put(0i64.to_ne_bytes());
            (0..self.nq + self.nv).for_each(|_| put(f64::NAN.to_ne_bytes()));
            return put([0; 8]);
        };
        let coverage = answer.coverage.unwrap_or(f64::NAN);
        let front = [answer.depth, answer.lower_bound, answer.max_displacement, coverage];
        front.iter().for_each(|x| put(x.to_ne_bytes()));
        put((answer.checks as i64).to_ne_bytes());
        answer.witness.iter().chain(&answer.gradient).for_each(|x| put(x.to_ne_bytes()));
        put([answer.verified.into(), answer.colliding.is_empty().into(), answer.unique.into(), 0, 0, 0, 0, 0]);
    }
}

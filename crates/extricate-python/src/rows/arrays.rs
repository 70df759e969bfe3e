//! Reads configurations from Python; arrays are used as they are if possible, else converted once.

use extricate::ConfigSpace;
use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::error::exception;

/// Configurations borrowed from NumPy, aligned and row by row.
pub struct Configs<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    pub rows: usize,
    /// Whether one configuration was given, not a list of them.
    pub single: bool,
}

impl Configs<'_> {
    /// All coordinates, `rows x nq`.
    pub fn values(&self) -> &[f64] {
        self.array.as_slice().expect("checked to be contiguous and aligned")
    }
}

/// Reads numbers of any shape; contiguous `float64` arrays are not copied. Messages say `name`.
///
/// # Errors
/// `TypeError` if `value` is no array of real numbers.
pub fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if let Ok(array) = value.cast::<PyArrayDyn<f64>>() {
        // An unaligned array, or one in Fortran's order, cannot be read row by row.
        let array = array.readonly();
        if array.is_c_contiguous() && array.as_slice().is_ok() {
            return Ok(array);
        }
    }
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|error| {
        // Errors that the value did not cause, as Ctrl-C or a lack of memory, are passed on.
        let py = value.py();
        if !error.is_instance_of::<PyTypeError>(py) && !error.is_instance_of::<PyValueError>(py) {
            return error;
        }
        PyTypeError::new_err(format!("{name}: expected an array of numbers ({})", error.value(py)))
    })?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let kind = array.dtype().kind();
    if !matches!(kind, b'f' | b'i' | b'u' | b'b') && array.len() > 0 {
        return Err(PyTypeError::new_err(format!("{name}: got an array of {}, expected numbers", array.dtype())));
    }
    let array = numpy.call_method1("require", (array, "f8", ["C", "A"]))?;
    Ok(array.cast_into::<PyArrayDyn<f64>>()?.readonly())
}

/// Reads one configuration, shape `(nq,)`, or `n` of them, `(n, nq)`. Callers check the values.
///
/// # Errors
/// `ValueError` that names the shape found and the one expected.
pub fn configs<'py>(name: &str, value: &Bound<'py, PyAny>, space: &ConfigSpace) -> PyResult<Configs<'py>> {
    let array = numbers(name, value)?;
    let nq = space.nq();
    let (rows, single) = match array.shape() {
        &[width] if width == nq => (1, true),
        &[rows, width] if width == nq => (rows, false),
        shape => return Err(wrong_shape(name, shape, &format!("({nq},) or (n, {nq})"), nq)),
    };
    Ok(Configs { array, rows, single })
}

fn wrong_shape(name: &str, shape: &[usize], expected: &str, nq: usize) -> PyErr {
    let found = tuple(shape);
    PyValueError::new_err(format!("{name}: got shape {found}, expected {expected}: the scene has {nq} coordinates"))
}

/// Reads one configuration, shape `(nq,)`; callers check its values.
///
/// # Errors
/// `ValueError` that names the shape found and the one expected.
pub fn one_config<'py>(name: &str, value: &Bound<'py, PyAny>, space: &ConfigSpace) -> PyResult<Configs<'py>> {
    let (array, nq) = (numbers(name, value)?, space.nq());
    match array.shape() {
        &[width] if width == nq => Ok(Configs { array, rows: 1, single: true }),
        shape => Err(wrong_shape(name, shape, &format!("({nq},)"), nq)),
    }
}

/// Reads a number, or a flat sequence of them.
///
/// # Errors
/// `TypeError` if `value` is no array of numbers, `ValueError` for another shape.
pub fn floats(element: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = numbers(element, value)?;
    match array.shape() {
        [] | [_] => Ok(array.as_slice().expect("checked to be contiguous").to_vec()),
        shape => Err(PyValueError::new_err(format!("{element}: got shape {}, expected a flat list", tuple(shape)))),
    }
}

/// Makes the `ValueError` for a row of `name`; without its number if it is a `single` one.
pub fn bad_row(name: &str, row: usize, single: bool, error: extricate::Error) -> PyErr {
    let message = exception(error);
    let place = if single { name.to_string() } else { format!("{name}[{row}]") };
    Python::attach(|py| PyValueError::new_err(format!("{place}: {}", message.value(py))))
}

/// Formats a shape as Python does.
pub fn tuple(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

//! Lists of names and of folders. A text in the place of a list is refused: Python would take it
//! for a list of its letters.

use std::path::PathBuf;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::kind;

/// An argument that is a list of names.
#[derive(Default)]
pub struct Names(pub Vec<String>);

/// An argument that is a list of folders.
#[derive(Default)]
pub struct Folders(pub Vec<PathBuf>);

impl<'py> FromPyObject<'_, 'py> for Names {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        listed(&value, "names").map(Self)
    }
}

impl<'py> FromPyObject<'_, 'py> for Folders {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        listed(&value, "folders").map(Self)
    }
}

/// What `value` lists; messages call the elements `what`.
fn listed<'py, T: for<'a> FromPyObject<'a, 'py>>(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Vec<T>> {
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.repr()?;
        return Err(PyTypeError::new_err(format!("got the text {text}, expected a list of {what}, such as [{text}]")));
    }
    let found = kind(value);
    let elements = value.try_iter();
    let elements = elements.map_err(|_| PyTypeError::new_err(format!("got {found}, expected a list of {what}")))?;
    let wrong = |element: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!("got a list with {}, expected a list of {what}", kind(element)))
    };
    let read = |element: PyResult<Bound<'py, PyAny>>| {
        let element = element?;
        element.extract::<T>().map_err(|_| wrong(&element))
    };
    elements.map(read).collect()
}

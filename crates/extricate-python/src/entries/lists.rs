//! Reads lists of names and of folders. A text in place of a list is refused, because Python would
//! iterate over its letters.

use std::path::PathBuf;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::kind;

/// A list of names, or the message that says why the argument is none.
pub struct Names(Result<Vec<String>, String>);

/// A list of folders, or the message that says why the argument is none.
pub struct Folders(Result<Vec<PathBuf>, String>);

impl Default for Names {
    fn default() -> Self {
        Self(Ok(Vec::new()))
    }
}

impl Default for Folders {
    fn default() -> Self {
        Self(Ok(Vec::new()))
    }
}

impl Names {
    /// Returns the names.
    ///
    /// # Errors
    /// `TypeError` that names the argument, if it is no list of names.
    pub fn of(self, argument: &str) -> PyResult<Vec<String>> {
        self.0.map_err(|problem| PyTypeError::new_err(format!("{argument}: {problem}")))
    }
}

impl Folders {
    /// Returns the folders; errors as of [`Names::of`].
    pub fn of(self, argument: &str) -> PyResult<Vec<PathBuf>> {
        self.0.map_err(|problem| PyTypeError::new_err(format!("{argument}: {problem}")))
    }
}

impl<'py> FromPyObject<'_, 'py> for Names {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(listed(&value, "names")))
    }
}

impl<'py> FromPyObject<'_, 'py> for Folders {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(listed(&value, "folders")))
    }
}

/// Reads the elements of a list; messages call them `what`.
fn listed<'py, T: for<'a> FromPyObject<'a, 'py>>(value: &Bound<'py, PyAny>, what: &str) -> Result<Vec<T>, String> {
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.repr().map_or_else(|_| "..".into(), |text| text.to_string());
        return Err(format!("got the text {text}, expected a list of {what}, such as [{text}]"));
    }
    let elements = value.try_iter().map_err(|_| format!("got {}, expected a list of {what}", kind(value)))?;
    let read = |element: PyResult<Bound<'py, PyAny>>| {
        let element = element.map_err(|error| error.to_string())?;
        element.extract::<T>().map_err(|_| format!("got a list with {}, expected a list of {what}", kind(&element)))
    };
    elements.map(read).collect()
}

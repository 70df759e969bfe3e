//! Reads the argument `clearance` of `Scene`, and single lengths.

use extricate::entries::{ClearanceEntry, SplitClearance};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use super::{by_name, kind};
use crate::rows::arrays::floats;

/// The argument `clearance`: one number, or one for pairs with an obstacle and one for the others.
#[derive(Default)]
pub struct Clearance(ClearanceEntry);

impl Clearance {
    /// Returns the entry of a scene file with this clearance.
    pub fn entry(&self) -> ClearanceEntry {
        self.0
    }
}

impl<'py> FromPyObject<'_, 'py> for Clearance {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(length) = value.extract::<f64>() {
            return Ok(Self(ClearanceEntry::Uniform(length)));
        }
        let wrong = || {
            let expected = "expected a number [m], or a dict with `world` and `self`";
            PyTypeError::new_err(format!("clearance: got {}, {expected}", kind(&value)))
        };
        let given = value.to_owned();
        let lengths = by_name("clearance", given.cast::<PyMapping>().map_err(|_| wrong())?, length)?;
        if lengths.keys().any(|name| name != "world" && name != "self") {
            return Err(wrong());
        }
        let of = |name: &str| lengths.get(name).copied();
        Ok(Self(ClearanceEntry::Split(SplitClearance { world: of("world"), own: of("self") })))
    }
}

/// Reads one number \[m\].
///
/// # Errors
/// `TypeError` or `ValueError` that say what was expected.
pub fn length(element: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    match floats(element, value)?[..] {
        [length] => Ok(length),
        _ => Err(PyValueError::new_err(format!("{element}: expected one number [m]"))),
    }
}

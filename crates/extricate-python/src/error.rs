//! From the library's errors to the built-in exceptions that a Python user expects; the message stays.

use std::io;

use extricate::Error;
use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};

/// The exception for `error`: `OSError` (`FileNotFoundError`, ...) for files, `RuntimeError` where learning found nothing free in time,
/// otherwise `ValueError`.
pub fn exception(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        // The library's message in place of the system's, which names no file.
        Error::Read { source, .. } | Error::Write { source, .. } => {
            if source.kind() == io::ErrorKind::Other {
                PyOSError::new_err(message)
            } else {
                io::Error::new(source.kind(), message).into()
            }
        }
        Error::NothingFree { .. } | Error::Interrupted => PyRuntimeError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// `value` as a count, where it is at least `least`.
pub fn count(name: &'static str, value: i64, least: u32) -> Result<usize, PyErr> {
    match usize::try_from(value) {
        Ok(count) if count >= least as usize => Ok(count),
        _ => Err(PyValueError::new_err(format!("{name}: got {value}, expected at least {least}"))),
    }
}

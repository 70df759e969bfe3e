//! Converts the library's errors and warnings to built-in Python exceptions with the same message,
//! and reads counts and seeds.

use std::ffi::CString;
use std::io;
use std::sync::{Arc, OnceLock};

use extricate::{Error, Scene};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyInt;

use crate::long_call;

/// Returns the exception for `error`: `OSError` (`FileNotFoundError`, ...) for files,
/// `RuntimeError` if a search found nothing or was interrupted, otherwise `ValueError`.
pub fn exception(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        // Keep the library's message: that of the system names no file.
        Error::Read { source, .. } | Error::Write { source, .. } => {
            if source.kind() == io::ErrorKind::Other {
                PyOSError::new_err(message)
            } else {
                io::Error::new(source.kind(), message).into()
            }
        }
        Error::Named { kind, .. } if kind != io::ErrorKind::Other => io::Error::new(kind, message).into(),
        Error::NothingFree { .. } => PyRuntimeError::new_err(in_python(&message)),
        Error::Interrupted | Error::Unlikely(_) => PyRuntimeError::new_err(message),
        // In Python, options of the library are arguments, which messages name first.
        Error::Option { name, value, expected } => {
            PyValueError::new_err(format!("{name}: got {value}, expected {expected}"))
        }
        _ => PyValueError::new_err(message),
    }
}

/// Rewrites advice for scene files in terms of the arguments of `Scene`.
fn in_python(message: &str) -> String {
    message.replace("add to the scene: [pairs] disable = [", "make the scene with disable=[")
}

/// Advice for a scene in which a query found nothing free. It is computed once, because it takes
/// as long as many queries, whatever their budgets.
#[derive(Default)]
pub struct Advice(OnceLock<Option<String>>);

impl Advice {
    /// Raises a `UserWarning` if some pairs collide in all sampled configurations; it names them
    /// and says what to do. Every call has to pass the same `solver`.
    ///
    /// # Errors
    /// The warning, if warnings are errors; the exceptions of [`long_call::run`].
    pub fn warn(&self, py: Python<'_>, solver: &extricate::Solver) -> PyResult<()> {
        if self.0.get().is_none() {
            let look = |line: &long_call::Line<()>| solver.checker().advice_if_never_free(|| line.stopped());
            let found = long_call::run(py, |_, ()| Ok(()), look)?;
            // Another thread may have set the same advice already.
            let _ = self.0.set(found);
        }
        let told = |advice: &String| warn(py, &format!("no free configuration was found; {}", in_python(advice)));
        self.0.get().and_then(Option::as_ref).map_or(Ok(()), told)
    }
}

/// Raises a `UserWarning`, which is returned as an error if warnings are errors.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(text)?, 1)
}

/// Returns the scene after a `UserWarning` for each of its warnings.
pub fn warned(py: Python<'_>, scene: Scene) -> PyResult<Arc<Scene>> {
    scene.warnings().iter().try_for_each(|warning| warn(py, warning))?;
    Ok(Arc::new(scene))
}

/// An argument that should be a whole number, written as one or as a float such as `1e5`.
pub enum Whole {
    Number(i64),
    /// A number that is not whole.
    Fraction(f64),
    /// The type of a value that is no number.
    Other(String),
}

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(number) = value.extract() {
            return Ok(Self::Number(number));
        }
        Ok(match value.extract::<f64>() {
            // From 2^53 = 9.007e15, every float is whole, so a fraction would go unnoticed.
            Ok(x) if x.fract() == 0.0 && x.abs() < 9e15 => Self::Number(x as i64),
            Ok(x) => Self::Fraction(x),
            Err(_) => Self::Other(crate::entries::kind(&value)),
        })
    }
}

/// Reads `value` as a count of at least `least`.
pub fn count(name: &str, value: Whole, least: u32) -> Result<usize, PyErr> {
    match value {
        Whole::Number(number) => match usize::try_from(number) {
            Ok(count) if count >= least as usize => Ok(count),
            _ => Err(PyValueError::new_err(format!("{name}: got {number}, expected at least {least}"))),
        },
        Whole::Fraction(x) => Err(PyValueError::new_err(format!("{name}: got {x:?}, expected a whole number"))),
        Whole::Other(kind) => Err(PyTypeError::new_err(format!("{name}: got {kind}, expected a whole number"))),
    }
}

/// Most threads of a call: starting more takes longer than they could save on any machine.
const MAX_THREADS: i64 = 1024;

/// Reads `value` as a number of threads; 0 is one per core.
pub fn threads(value: i64) -> PyResult<usize> {
    let count = usize::try_from(value).ok().filter(|_| value <= MAX_THREADS);
    let wrong = || PyValueError::new_err(format!("threads: got {value}, expected 0 (one per core) to {MAX_THREADS}"));
    count.ok_or_else(wrong)
}

/// The argument `seed`, a whole number of 64 bits.
pub struct Seed(pub u64);

impl<'py> FromPyObject<'_, 'py> for Seed {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong = format!("seed: got {}, expected a whole number from 0 to {}", *value, u64::MAX);
        if let Ok(seed) = value.extract() {
            return Ok(Self(seed));
        }
        Err(if value.is_instance_of::<PyInt>() { PyValueError::new_err(wrong) } else { PyTypeError::new_err(wrong) })
    }
}

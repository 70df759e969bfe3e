//! How much files may hold, as Python says it.

use std::collections::HashMap;

use extricate::{LoadLimit, LoadLimits};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Whole, count};

/// Limits by name.
pub type Limits = HashMap<String, Whole>;

/// The usual limits, but for these.
pub fn limits_of(given: Option<Limits>) -> PyResult<LoadLimits> {
    given.into_iter().flatten().try_fold(LoadLimits::default(), |limits, (name, most)| {
        match LoadLimit::ALL.into_iter().find(|limit| limit.name() == name) {
            Some(limit) => Ok(limits.with(limit, count(&format!("load_limits: {name}"), most, 0)?)),
            None => {
                let names: Vec<&str> = LoadLimit::ALL.into_iter().map(LoadLimit::name).collect();
                let problem = format!("load_limits: got {name:?}, expected one of {}", names.join(", "));
                Err(PyValueError::new_err(problem))
            }
        }
    })
}

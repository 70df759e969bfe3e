//! Reads the argument `load_limits`: how much files may hold.

use std::collections::HashMap;

use extricate::{LoadLimit, LoadLimits};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Whole, count};

pub type Limits = HashMap<String, Whole>;

/// Returns the default limits, with those of `given` in their place.
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

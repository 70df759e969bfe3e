//! Methods of `Scene` that convert positions by joint name to configurations, and back.

use numpy::{PyArray1, PyUntypedArrayMethods, ToPyArray};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use super::Scene;
use crate::entries::kind;
use crate::error::{exception, warn};
use crate::rows::arrays::{bad_row, floats, numbers, one_config};

#[pymethods]
impl Scene {
    /// Converts positions by joint name to one configuration.
    ///
    /// positions: a dict by joint: for each of `joints` a number [rad or m], or as many as it has
    ///     coordinates. Or a JointState: an object with `name` and `position`, or a dict with
    ///     these. It may include joints that are locked, mimic or fixed: a UserWarning reports
    ///     those whose position is not the scene's.
    /// Returns float64 (nq,): angles of continuous joints within [-pi, pi), quaternions of length
    /// 1.
    ///
    /// Raises ValueError for joints that are unknown or missing, values that are not finite or
    /// beyond a limit.
    fn config<'py>(&self, positions: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = self.values(positions)?;
        Ok(self.inner().config(&values).map_err(exception)?.to_pyarray(positions.py()))
    }

    /// As `config`, but takes positions beyond the limits, as `positions` and queries do.
    fn _config_anywhere<'py>(&self, positions: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = self.values(positions)?;
        Ok(self.inner().space().config_anywhere(&values).map_err(exception)?.to_pyarray(positions.py()))
    }

    /// Converts a configuration to positions by joint name: the inverse of `config`. It includes
    /// mimic and locked joints, but not fixed ones.
    ///
    /// q: float64 (nq,); it may be beyond the limits.
    /// Returns a dict: a float [rad or m] for a joint with one coordinate, else float64 (n,).
    ///
    /// Raises ValueError for a wrong shape and values that are not finite.
    fn positions<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let (py, scene) = (q.py(), self.inner());
        let values = one_config("q", q, scene.space())?;
        let config = scene.space().config_anywhere(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let all = PyDict::new(py);
        for (name, values) in scene.positions_at(&config) {
            match values[..] {
                [one] => all.set_item(name, one)?,
                _ => all.set_item(name, PyArray1::from_vec(py, values))?,
            }
        }
        Ok(all)
    }
}

impl Scene {
    /// Returns the coordinates at positions by name, unchecked, after a `UserWarning` for each
    /// joint whose position is not the scene's.
    fn values(&self, positions: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
        let pairs = match joint_state(positions)? {
            Some(pairs) => pairs,
            None => by_name(positions)?,
        };
        let pairs = pairs.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        let found = self.inner().config_of(pairs).map_err(exception)?;
        for (_, text) in &found.differing {
            warn(positions.py(), text)?;
        }
        Ok(found.values)
    }
}

type Positions = Vec<(String, Vec<f64>)>;

/// Reads the names and positions of a JointState; `None` if `given` is not one.
fn joint_state(given: &Bound<'_, PyAny>) -> PyResult<Option<Positions>> {
    let fields = match given.cast::<PyMapping>() {
        Ok(map) if map.contains("name")? && map.contains("position")? => {
            Some((map.get_item("name")?, map.get_item("position")?))
        }
        Ok(_) => None,
        Err(_) if given.hasattr("name")? && given.hasattr("position")? => {
            Some((given.getattr("name")?, given.getattr("position")?))
        }
        Err(_) => None,
    };
    let Some((names, positions)) = fields else { return Ok(None) };
    // In a dict by joint, a joint may be called `name`, and its value is a number.
    let Ok(names) = names.extract::<Vec<String>>() else { return Ok(None) };
    let positions = floats("position", &positions)?;
    if names.len() != positions.len() {
        let (found, expected) = (positions.len(), names.len());
        return Err(PyValueError::new_err(format!(
            "position: got {found} numbers, expected {expected}, one for each name"
        )));
    }
    Ok(Some(names.into_iter().zip(positions.into_iter().map(|x| vec![x])).collect()))
}

fn by_name(given: &Bound<'_, PyAny>) -> PyResult<Positions> {
    let expected = "expected a dict by joint, or a JointState with name and position";
    let wrong = |_| PyTypeError::new_err(format!("positions: got {}, {expected}", kind(given)));
    let mut all = Vec::new();
    for item in given.cast::<PyMapping>().map_err(wrong)?.items()? {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let wrong = |_| PyTypeError::new_err(format!("positions: got the key {name}, expected names of joints"));
        let name: String = name.extract().map_err(wrong)?;
        let values = numbers(&format!("positions[\"{name}\"]"), &value)?;
        if values.ndim() > 1 {
            return Err(PyValueError::new_err(format!("positions[\"{name}\"]: expected a number, or a flat list")));
        }
        all.push((name, values.as_slice().expect("checked to be contiguous").to_vec()));
    }
    Ok(all)
}

//! Queries: what is asked, and how answers are told.

pub mod answer;
pub mod batch;
pub mod layout;
pub mod options;
pub mod page;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::long_call;
use crate::solver::handle::Handle;
use options::Call;

/// The witness alone, with the defaults of the handle; `None` if nothing free was found, with the
/// warning of [`query`].
pub fn nearest_exit<'py>(handle: &Handle, q: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
    let py = q.py();
    let mut asked = handle.asked(py, None, Call::Query)?;
    let watch = long_call::Watch::new();
    asked.options.termination.stop = Some(watch.stop());
    let config = asked.config(q, handle.scene())?;
    let solver = handle.solver_for(py, &asked)?;
    let Some(witness) = py.detach(|| watch.over(|| solver.nearest_exit(&config)))? else {
        handle.advise(py)?;
        return Ok(None);
    };
    Ok(Some(PyArray1::from_slice(py, &witness)))
}

/// The answer for one configuration as an object; `None` if nothing free was found, with a
/// warning if that is because some pairs collide wherever one looks. `owner` is the object of
/// Python that was asked.
pub fn query<'py>(
    handle: &Handle,
    q: &Bound<'py, PyAny>,
    given: Option<&Bound<'py, PyDict>>,
    owner: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let (py, scene) = (q.py(), handle.scene());
    let mut asked = handle.asked(py, given, Call::Query)?;
    let watch = long_call::Watch::new();
    asked.options.termination.stop = Some(watch.stop());
    let config = asked.config(q, scene)?;
    let solver = handle.solver_for(py, &asked)?;
    let Some(answer) = py.detach(|| watch.over(|| solver.query(&config)))? else {
        handle.advise(py)?;
        return Ok(None);
    };
    let object = answer::object(py, &answer, scene)?;
    // For `Answer.show`, which asks once more.
    object.setattr("_asked", (owner, PyArray1::from_slice(py, &config), given))?;
    Ok(Some(object))
}

//! Implements the calls that query configurations: keywords, answers, batches and pages.

pub mod answer;
pub mod batch;
pub mod layout;
pub mod options;
pub mod page;
pub mod signed_distance;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::long_call;
use crate::solver::handle::Handle;
use options::Call;

/// Returns the witness alone, with the defaults of the handle; `None` if nothing free was found,
/// with the warning of [`query`].
pub fn nearest_exit<'py>(handle: &Handle, q: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
    let py = q.py();
    let mut call = handle.call_options(py, None, Call::Query)?;
    let watch = long_call::Watch::new();
    call.options.termination.stop = Some(watch.stop());
    let config = call.config(q, handle.scene())?;
    let solver = handle.solver_for(py, &call)?;
    let Some(witness) = py.detach(|| watch.over(|| solver.nearest_exit(&config)))? else {
        handle.advise(py)?;
        return Ok(None);
    };
    Ok(Some(PyArray1::from_slice(py, &witness)))
}

/// Answers one configuration with an object; `None` if nothing free was found, with the warning of
/// [`Handle::advise`]. `owner` is the Python object whose method was called.
pub fn query<'py>(
    handle: &Handle,
    q: &Bound<'py, PyAny>,
    given: Option<&Bound<'py, PyDict>>,
    owner: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let (py, scene) = (q.py(), handle.scene());
    let mut call = handle.call_options(py, given, Call::Query)?;
    let watch = long_call::Watch::new();
    call.options.termination.stop = Some(watch.stop());
    let config = call.config(q, scene)?;
    let solver = handle.solver_for(py, &call)?;
    let Some(answer) = py.detach(|| watch.over(|| solver.query(&config)))? else {
        handle.advise(py)?;
        return Ok(None);
    };
    let object = answer::object(py, &answer, scene)?;
    // `Answer.show` repeats the query.
    object.setattr("_asked", (owner, PyArray1::from_slice(py, &config), given))?;
    Ok(Some(object))
}

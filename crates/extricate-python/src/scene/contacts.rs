//! Methods of `Scene` that return signed distances and contacts by pair.

use extricate::Contact;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::Scene;
use crate::error::threads as thread_count;
use crate::rows;
use crate::rows::arrays::configs;

#[pymethods]
impl Scene {
    /// Computes the signed distance [m] of every checked pair of bodies, negative if the two
    /// overlap.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits.
    /// threads: 0 for one per core.
    /// Returns float64 (n, len(pairs)), or (len(pairs),) for one, in the order of `pairs`. It is as
    /// exact as `distances`, which is the least of each row. Clearances are not subtracted.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, threads = 0))]
    #[allow(non_snake_case)]
    fn pair_distances<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = Q.py();
        let q = configs("Q", Q, self.inner().space())?;
        let (nq, pairs) = (self.inner().space().nq(), self.inner().pairs().len());
        let found = rows::map(self.handle(), py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
            for (q, out) in rows.chunks_exact(nq).zip(out) {
                *out = checker.signed_distances(q, scratch);
            }
        })?;
        let shape = if q.single { vec![pairs] } else { vec![q.rows, pairs] };
        PyArray1::from_vec(py, found.concat()).reshape(shape)
    }

    /// Finds the contacts of bodies that are near each other or overlap, also at free
    /// configurations.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits.
    /// within: only pairs nearer than this [m] have contacts in the result.
    /// threads: 0 for one per core.
    /// Returns a structured array, a row for each contact, by configuration and pair, with the
    /// fields row (of Q), pair (index into `pairs`), distance (signed [m]; negative if the two
    /// overlap), points (2, 3) (nearest, or deepest, on the first and on the second body, world
    /// coordinates [m]) and normal (3,) (unit, from the second body toward the first). A pair of
    /// convex shapes has one contact, exact also if they overlap. Meshes have several, and the
    /// nearest is exact; if meshes overlap, all are estimates.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, within, threads = 0))]
    #[allow(non_snake_case)]
    fn contacts<'py>(&self, Q: &Bound<'py, PyAny>, within: f64, threads: i64) -> PyResult<Bound<'py, PyAny>> {
        let py = Q.py();
        let q = configs("Q", Q, self.inner().space())?;
        check_within(within)?;
        let nq = self.inner().space().nq();
        let found = rows::map(self.handle(), py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
            for (q, out) in rows.chunks_exact(nq).zip(out) {
                checker.contacts_within(q, within, scratch, out);
            }
        })?;
        let all: Vec<(usize, &Contact)> = by_row(&found).collect();
        contact_array(py, &all, None)
    }

    /// Computes the signed distances of bodies that are near each other, and how they change: the
    /// rows d(distance)/dv that controllers and quadratic programs take as constraints.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; within the limits.
    /// within: only pairs nearer than this [m] have rows in the result.
    /// threads: 0 for one per core.
    /// Returns a structured array, a row for each pair, by configuration and pair, with the fields
    /// of `contacts`, of the nearest contact of the pair, and jacobian (nv,): the derivative of the
    /// distance [m per rad or m] over the tangent coordinates. It jumps if the nearest points do,
    /// as between parallel faces.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (Q, *, within, threads = 0))]
    #[allow(non_snake_case)]
    fn distance_jacobians<'py>(&self, Q: &Bound<'py, PyAny>, within: f64, threads: i64) -> PyResult<Bound<'py, PyAny>> {
        let py = Q.py();
        let q = configs("Q", Q, self.inner().space())?;
        check_within(within)?;
        let (nq, nv) = (self.inner().space().nq(), self.inner().space().nv());
        let found = rows::map(self.handle(), py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
            for (q, out) in rows.chunks_exact(nq).zip(out) {
                *out = checker.distance_rows(q, within, scratch);
            }
        })?;
        let all: Vec<(usize, &Contact)> = by_row(&found).map(|(row, found)| (row, &found.contact)).collect();
        let gradients: Vec<f64> = by_row(&found).flat_map(|(_, found)| found.gradient.iter().copied()).collect();
        contact_array(py, &all, Some((nv, gradients)))
    }
}

fn check_within(within: f64) -> PyResult<()> {
    match within.is_finite() {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!("within: got {within}, expected a finite distance [m]"))),
    }
}

/// Yields what was found for each row, with the index of the row.
fn by_row<T>(found: &[Vec<T>]) -> impl Iterator<Item = (usize, &T)> {
    found.iter().enumerate().flat_map(|(row, found)| found.iter().map(move |one| (row, one)))
}

/// Returns a structured array of contacts, with gradients of this width if there are any.
fn contact_array<'py>(
    py: Python<'py>,
    all: &[(usize, &Contact)],
    gradients: Option<(usize, Vec<f64>)>,
) -> PyResult<Bound<'py, PyAny>> {
    let count = all.len();
    let fields = (("row", "i8"), ("pair", "i8"), ("distance", "f8"), ("points", "f8", (2, 3)), ("normal", "f8", 3));
    let fields: Bound<'_, PyTuple> = fields.into_pyobject(py)?;
    let fields = fields.to_list();
    if let Some((width, _)) = &gradients {
        fields.append(("jacobian", "f8", *width))?;
    }
    let answers = py.import("numpy")?.call_method1("zeros", (count, fields))?;
    answers.set_item("row", PyArray1::from_iter(py, all.iter().map(|(row, _)| *row as i64)))?;
    answers.set_item("pair", PyArray1::from_iter(py, all.iter().map(|(_, contact)| contact.pair.index() as i64)))?;
    answers.set_item("distance", PyArray1::from_iter(py, all.iter().map(|(_, contact)| contact.distance)))?;
    let points = all.iter().flat_map(|(_, contact)| contact.points().concat());
    answers.set_item("points", PyArray1::from_iter(py, points).reshape([count, 2, 3])?)?;
    let normals = all.iter().flat_map(|(_, contact)| contact.normal());
    answers.set_item("normal", PyArray1::from_iter(py, normals).reshape([count, 3])?)?;
    if let Some((width, values)) = gradients {
        answers.set_item("jacobian", PyArray1::from_vec(py, values).reshape([count, width])?)?;
    }
    Ok(answers)
}

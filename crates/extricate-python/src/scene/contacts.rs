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
        if !within.is_finite() {
            return Err(PyValueError::new_err(format!("within: got {within}, expected a finite distance [m]")));
        }
        let q = configs("Q", Q, self.inner().space())?;
        let nq = self.inner().space().nq();
        let found = rows::map(self.handle(), py, &q, (thread_count(threads)?, 1), |checker, rows, out, scratch| {
            for (q, out) in rows.chunks_exact(nq).zip(out) {
                checker.contacts_within(q, within, scratch, out);
            }
        })?;
        let all = || found.iter().enumerate().flat_map(|(row, contacts)| contacts.iter().map(move |c| (row, c)));
        let of = |number: &dyn Fn(&Contact) -> f64| PyArray1::from_iter(py, all().map(|(_, contact)| number(contact)));
        let fields = (("row", "i8"), ("pair", "i8"), ("distance", "f8"), ("points", "f8", (2, 3)), ("normal", "f8", 3));
        let fields: Bound<'_, PyTuple> = fields.into_pyobject(py)?;
        let fields = fields.to_list();
        let count = all().count();
        let answers = py.import("numpy")?.call_method1("zeros", (count, fields))?;
        answers.set_item("row", PyArray1::from_iter(py, all().map(|(row, _)| row as i64)))?;
        answers.set_item("pair", PyArray1::from_iter(py, all().map(|(_, contact)| contact.pair.index() as i64)))?;
        answers.set_item("distance", of(&|contact| contact.distance))?;
        let points = all().flat_map(|(_, contact)| contact.points().concat());
        answers.set_item("points", PyArray1::from_iter(py, points).reshape([count, 2, 3])?)?;
        let normals = all().flat_map(|(_, contact)| contact.normal());
        answers.set_item("normal", PyArray1::from_iter(py, normals).reshape([count, 3])?)?;
        Ok(answers)
    }
}

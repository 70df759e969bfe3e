//! Reads poses from Python: arrays, or a dict with the keys of a scene file; returns transforms.

use extricate::entries::PoseEntry;
use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use super::{by_name, unknown};
use crate::error::exception;
use crate::rows::arrays::{floats, numbers, tuple};

/// Largest deviation of a rotation matrix from an orthonormal one, such as one rounded to
/// `float32`.
const ROTATION_TOLERANCE: f64 = 1e-5;

/// Reads `None`, a position `(3,)`, position and roll, pitch, yaw `(6,)`, a homogeneous transform
/// `(4, 4)`, or a mapping with the keys of a scene file.
///
/// # Errors
/// `TypeError` if `value` is no array of numbers, `ValueError` for another shape or key.
pub fn pose(element: &str, value: &Bound<'_, PyAny>) -> PyResult<PoseEntry> {
    if value.is_none() {
        return Ok(PoseEntry::default());
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return pose_by_key(element, mapping);
    }
    let array = numbers(element, value)?;
    let x = array.as_slice().expect("checked to be contiguous");
    let of = |xyz, rpy| PoseEntry { xyz, rpy: Some(rpy), ..PoseEntry::default() };
    match array.shape() {
        [3] => Ok(of([x[0], x[1], x[2]], [0.0; 3])),
        [6] => Ok(of([x[0], x[1], x[2]], [x[3], x[4], x[5]])),
        [4, 4] => Ok(of([x[3], x[7], x[11]], roll_pitch_yaw(element, x)?)),
        shape => Err(PyValueError::new_err(format!(
            "{element}: got shape {}, expected (3,) position, (6,) position and roll, pitch, yaw, (4, 4) transform, or \
             {{\"xyz\": .., \"quat_xyzw\": ..}}, where the key tells the order of the quaternion",
            tuple(shape)
        ))),
    }
}

/// Returns a pose, in any form that `Box` takes, as a transform, float64 (4, 4).
#[pyfunction]
pub fn _pose_matrix<'py>(pose: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let py = pose.py();
    let pose = self::pose("pose", pose)?.pose("argument", "pose").map_err(exception)?;
    let ([x, y, z], t) = (pose.columns(), pose.origin());
    let row = |i: usize| vec![x[i], y[i], z[i], t[i]];
    Ok(PyArray2::from_vec2(py, &[row(0), row(1), row(2), vec![0.0, 0.0, 0.0, 1.0]])?)
}

/// Reads `{"xyz": .., "rpy": ..}`, or with `quat_xyzw` or `quat_wxyz`, as in a scene file.
fn pose_by_key(element: &str, mapping: &Bound<'_, PyMapping>) -> PyResult<PoseEntry> {
    fn exactly<const N: usize>(element: &str, value: &[f64]) -> PyResult<[f64; N]> {
        let wrong = |_| PyValueError::new_err(format!("{element}: got {} numbers, expected {N}", value.len()));
        value.try_into().map_err(wrong)
    }
    let mut entry = PoseEntry::default();
    for (key, value) in by_name(element, mapping, floats)? {
        let element = format!("{element}[\"{key}\"]");
        match key.as_str() {
            "xyz" => entry.xyz = exactly(&element, &value)?,
            "rpy" => entry.rpy = Some(exactly(&element, &value)?),
            "quat_xyzw" => entry.quat_xyzw = Some(exactly(&element, &value)?),
            "quat_wxyz" => entry.quat_wxyz = Some(exactly(&element, &value)?),
            other => return Err(unknown("pose", other, &["xyz", "rpy", "quat_xyzw", "quat_wxyz"])),
        }
    }
    Ok(entry)
}

/// Returns roll, pitch and yaw \[rad\] of a 4 x 4 transform, row major.
fn roll_pitch_yaw(element: &str, m: &[f64]) -> PyResult<[f64; 3]> {
    let [x, y, z] = [0, 1, 2].map(|k| [m[k], m[4 + k], m[8 + k]]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |k: usize| x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3];
    let off = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(x, y), cross(0) - z[0], cross(1) - z[1], cross(2) - z[2]];
    let last = [m[12], m[13], m[14], m[15] - 1.0];
    // Written so that NaN is refused too.
    if !off.into_iter().chain(last).all(|x| x.abs() <= ROTATION_TOLERANCE) {
        return Err(PyValueError::new_err(format!(
            "{element}: got a 4 x 4 matrix that is no rigid transform, expected a rotation and a last row 0, 0, 0, 1"
        )));
    }
    let cosine = x[0].hypot(x[1]);
    let pitch = (-x[2]).atan2(cosine);
    // If the pitch is a right angle, roll and yaw rotate about the same axis, and yaw is set to 0.
    if cosine < 1e-9 { Ok([(-z[1]).atan2(y[1]), pitch, 0.0]) } else { Ok([y[2].atan2(z[2]), pitch, x[1].atan2(x[0])]) }
}

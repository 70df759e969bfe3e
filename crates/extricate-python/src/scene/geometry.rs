//! Methods of `Scene` for viewers: poses of bodies, and their triangles.

use extricate::parts::Seated;
use numpy::{Ix2, PyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::Scene;
use crate::entries::lists::Names;
use crate::error::{Whole, count};
use crate::long_call;
use crate::rows::KERNEL_ROWS;
use crate::rows::arrays::{bad_row, configs};

/// Vertices, and triangles as rows of their indices.
type Triangles<'py> = (Bound<'py, PyArray<f64, Ix2>>, Bound<'py, PyArray<i64, Ix2>>);

#[pymethods]
impl Scene {
    /// Computes the poses of bodies in the world: forward kinematics.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; it may be beyond the limits.
    /// of: names of bodies or of links, which need no geometry; None takes all of `bodies`.
    /// Returns float64 (n, len(of), 4, 4), or (len(of), 4, 4) for one: transforms from a body's own
    /// coordinates [m] to those of the world. A link has the URDF's coordinates; an obstacle or an
    /// attached object has those of its shape.
    ///
    /// Raises ValueError for wrong shapes, names that nothing has, values that are not finite.
    #[pyo3(signature = (Q, of = None))]
    #[allow(non_snake_case)]
    fn poses<'py>(&self, Q: &Bound<'py, PyAny>, of: Option<Names>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, scene) = (Q.py(), self.inner());
        let named = |name: &String| {
            let known =
                || scene.links().iter().map(|link| &link.name).chain(scene.bodies().iter().map(|body| &body.name));
            let listed = || known().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let unknown = || PyValueError::new_err(format!("of: got `{name}`, expected some of {}", listed()));
            scene.seat_named(name).ok_or_else(unknown)
        };
        let of = of.map(|of| of.of("of")).transpose()?;
        let seats: Vec<Seated> = match &of {
            Some(names) => names.iter().map(named).collect::<PyResult<_>>()?,
            None => (0..scene.bodies().len()).map(|body| scene.seat_of_body(body)).collect(),
        };
        let q = configs("Q", Q, scene.space())?;
        let (values, rows, single, nq) = (q.values(), q.rows, q.single, scene.space().nq());
        let watch = long_call::Watch::new();
        let stop = watch.stop();
        let all = || {
            let (mut numbers, mut frames) = (Vec::with_capacity(rows * seats.len() * 16), Vec::new());
            for (row, q) in values.chunks_exact(nq).enumerate() {
                if row % KERNEL_ROWS == 0 && stop.is_asked() {
                    break;
                }
                let q = scene.space().config_anywhere(q).map_err(|error| bad_row("Q", row, single, error))?;
                scene.poses(&q, &mut frames);
                for seat in &seats {
                    let pose = frames[seat.frame].then(&seat.pose_frame_own);
                    let ([x, y, z], t) = (pose.columns(), pose.origin());
                    (0..3).for_each(|i| numbers.extend([x[i], y[i], z[i], t[i]]));
                    numbers.extend([0.0, 0.0, 0.0, 1.0]);
                }
            }
            Ok::<_, PyErr>(numbers)
        };
        let numbers = py.detach(|| watch.over(all))??;
        let shape = if single { vec![seats.len(), 4, 4] } else { vec![rows, seats.len(), 4, 4] };
        PyArray1::from_vec(py, numbers).reshape(shape)
    }

    /// Returns the triangles of a body, to draw at its pose from `poses`.
    ///
    /// body: name of the body.
    /// segments: sides of round shapes around their axis, 3 or more.
    /// Returns (vertices, triangles): float64 (v, 3) [m] in the body's own coordinates, int64
    /// (t, 3) indices of them, counterclockwise from outside. Round shapes are inscribed; a
    /// half-space is a square of 10 m.
    ///
    /// Raises ValueError for a name that no body has.
    #[pyo3(signature = (body, segments = Whole::Number(32)), text_signature = "($self, body, segments=32)")]
    fn mesh<'py>(&self, py: Python<'py>, body: &str, segments: Whole) -> PyResult<Triangles<'py>> {
        let (scene, segments) = (self.inner(), count("segments", segments, 3)?);
        let names = || scene.bodies().iter().map(|body| format!("`{}`", body.name)).collect::<Vec<_>>().join(", ");
        let index = scene.bodies().iter().position(|other| other.name == body);
        let unknown = || PyValueError::new_err(format!("body: got `{body}`, expected one of {}", names()));
        let index = index.ok_or_else(unknown)?;
        let (vertices, triangles) = py.detach(|| scene.mesh_of_body(index, segments));
        let corners: Vec<i64> = triangles.iter().flatten().map(|corner| i64::from(*corner)).collect();
        let numbers: Vec<f64> = vertices.iter().flatten().copied().collect();
        let vertices = PyArray1::from_vec(py, numbers).reshape([vertices.len(), 3])?;
        Ok((vertices, PyArray1::from_vec(py, corners).reshape([triangles.len(), 3])?))
    }
}

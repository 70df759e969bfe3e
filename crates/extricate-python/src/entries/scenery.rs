//! Reads points, voxels, octrees, half-spaces and height fields; implements `Scene.robot_filter`.

use std::sync::Arc;

use extricate::LoadLimits;
use extricate::geometry::{Geometry, HeightField, Octree, PointCloud, Voxels};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::{NAME, kind, rows_of_three};
use crate::error::exception;
use crate::long_call;
use crate::rows::arrays::{bad_row, floats, numbers, one_config, tuple};
use crate::scene::Scene;

/// Points between two polls for a stop in `Scene.robot_filter`.
const POLL_POINTS: usize = 1024;

/// Returns the shape of an obstacle and how many of its points were left out because they are NaN;
/// `None` for other classes. Messages call the obstacle `element`.
///
/// # Errors
/// `TypeError` for a value of the wrong type, `ValueError` for one of the wrong shape or size.
pub fn geometry(class: &str, element: &str, given: &Bound<'_, PyAny>) -> PyResult<Option<(Geometry, usize)>> {
    let get = |name: &str| given.getattr(name);
    let number = |name: &str| -> PyResult<f64> {
        let element = format!("{element}: {name}");
        match floats(&element, &get(name)?)?[..] {
            [number] => Ok(number),
            _ => Err(PyValueError::new_err(format!("{element}: expected one number [m]"))),
        }
    };
    let mut left_out = 0;
    let geometry = match class {
        "Points" => {
            let points = rows_of_three(&format!("{element}: xyz"), &get("xyz")?)?;
            let (cloud, lost) = PointCloud::seen(NAME, element, number("radius")?, &points).map_err(exception)?;
            left_out = lost;
            Geometry::Points(Arc::new(cloud))
        }
        "Voxels" => {
            let cells = cells(&format!("{element}: occupied"), &get("occupied")?)?;
            let voxels = Voxels::new(NAME, element, number("size")?, cells).map_err(exception)?;
            Geometry::Voxels(Arc::new(voxels))
        }
        "HalfSpace" => {
            let of_normal = format!("{element}: normal");
            let wrong = |_| PyValueError::new_err(format!("{of_normal}: expected three numbers"));
            let normal = floats(&of_normal, &get("normal")?)?.try_into().map_err(wrong)?;
            Geometry::half_space(NAME, element, normal, number("offset")?).map_err(exception)?
        }
        "HeightField" => {
            let of_heights = format!("{element}: heights");
            let heights = numbers(&of_heights, &get("heights")?)?;
            let &[_, columns] = heights.shape() else {
                let shape = tuple(heights.shape());
                return Err(PyValueError::new_err(format!(
                    "{of_heights}: got shape {shape}, expected (rows, columns)"
                )));
            };
            let values = heights.as_slice().expect("checked to be contiguous").to_vec();
            let field = HeightField::new(NAME, element, number("size")?, columns, values).map_err(exception)?;
            Geometry::HeightField(Arc::new(field))
        }
        _ => return Ok(None),
    };
    Ok(Some((geometry, left_out)))
}

/// Reads the indices of occupied cells from a boolean grid (nx, ny, nz), or from rows of three.
fn cells(element: &str, occupied: &Bound<'_, PyAny>) -> PyResult<Vec<[i32; 3]>> {
    let numpy = occupied.py().import("numpy")?;
    let expected = "expected a boolean grid (nx, ny, nz) or indices (n, 3)";
    let wrong = |_| PyTypeError::new_err(format!("{element}: got {}, {expected}", kind(occupied)));
    let array = numpy.call_method1("asarray", (occupied,)).map_err(wrong)?.cast_into::<PyUntypedArray>()?;
    let is_boolean = numpy::PyArrayDescrMethods::kind(&array.dtype()) == b'b';
    let rows = match (is_boolean, array.ndim()) {
        (true, 3) => numpy.call_method1("argwhere", (array,))?,
        (false, 2) => array.into_any(),
        (true, _) | (false, _) => {
            let shape = tuple(array.shape());
            let found = format!("an array of {} of shape {shape}", array.dtype());
            return Err(PyValueError::new_err(format!("{element}: got {found}, {expected}")));
        }
    };
    let whole = |x: f64| {
        let fits = x.fract() == 0.0 && x.abs() <= f64::from(i32::MAX);
        let wrong = || PyValueError::new_err(format!("{element}: got {x}, expected whole numbers below 2^31"));
        if fits { Ok(x as i32) } else { Err(wrong()) }
    };
    rows_of_three(element, &rows)?.into_iter().map(|[i, j, k]| Ok([whole(i)?, whole(j)?, whole(k)?])).collect()
}

/// Returns the occupied cells of an octree of OctoMap, int32 (n, 3). Messages say `element`.
#[pyfunction]
pub fn _octree_cells<'py>(
    py: Python<'py>,
    element: &str,
    id: &str,
    is_binary: bool,
    resolution: f64,
    data: &[u8],
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let tree = Octree { id, is_binary, resolution, data };
    let voxels = tree.voxels("message", element, &LoadLimits::default()).map_err(exception)?;
    let cells = PyArray1::from_iter(py, voxels.cells().iter().flatten().copied());
    cells.reshape([voxels.cells().len(), 3])
}

#[pymethods]
impl Scene {
    /// Finds the points that are not the robot's own: at a configuration, no link is nearer to them
    /// than `padding`.
    ///
    /// points: float64 (n, 3) [m], in the world, for example from a camera.
    /// q: float64 (nq,), within the limits: where the robot stood when the camera saw them.
    /// padding: distance [m], 0 or more.
    /// Returns bool (n,): `points[scene.robot_filter(points, q, 0.02)]` are those to keep.
    /// Obstacles do not count.
    ///
    /// Raises ValueError for wrong shapes, values that are not finite or beyond a limit.
    #[pyo3(signature = (points, q, padding = 0.0))]
    fn robot_filter<'py>(
        &self,
        points: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        padding: f64,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let py = points.py();
        if !(padding >= 0.0 && padding.is_finite()) {
            return Err(PyValueError::new_err(format!("padding: got {padding}, expected 0 m or more")));
        }
        let points = rows_of_three("points", points)?;
        if let Some(row) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(PyValueError::new_err(format!("points: row {row}: expected finite coordinates [m]")));
        }
        let space = self.inner().space();
        let values = one_config("q", q, space)?;
        let config = self.inner().config(values.values()).map_err(|error| bad_row("q", 0, true, error))?;
        let solver = self.handle().for_checks(py)?;
        let watch = long_call::Watch::new();
        let stop = watch.stop();
        let filter = |scratch: &mut _| {
            let parts = points.chunks(POLL_POINTS).take_while(|_| !stop.is_asked());
            parts.flat_map(|part| solver.checker().robot_filter(&config, part, padding, scratch)).collect::<Vec<bool>>()
        };
        let keep = py.detach(|| watch.over(|| solver.with_scratch(filter)))?;
        Ok(PyArray1::from_vec(py, keep))
    }
}

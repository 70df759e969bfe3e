//! Reads the shapes of `Mesh` and `Fixture` from files, arrays, and objects of other packages.

use std::sync::Arc;

use extricate::entries::{ScaleEntry, ShapeEntry};
use extricate::parts::from_arrays;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::{folders, geometry, kind, rows_of_three, text_or_path};
use crate::error::exception;
use crate::long_call;
use crate::rows::arrays::floats;

/// Fills the shape of a `Mesh`.
///
/// # Errors
/// `TypeError` and `ValueError` if `given` describes no mesh.
pub fn mesh(element: &str, given: &Bound<'_, PyAny>, shape: &mut ShapeEntry) -> PyResult<()> {
    let source = given.getattr("source")?;
    match text_or_path(&source) {
        Ok(path) => shape.mesh = Some(path),
        Err(_) => {
            let (vertices, triangles) = arrays_of_mesh(element, &source)?;
            let vertices = rows_of_three(&format!("{element}: vertices"), &vertices)?;
            let corner = |x: f64| {
                let fits = x.fract() == 0.0 && (0.0..=u32::MAX.into()).contains(&x);
                let wrong = || PyValueError::new_err(format!("{element}: triangles: got {x}, expected an index"));
                if fits { Ok(x as u32) } else { Err(wrong()) }
            };
            let triangles = rows_of_three(&format!("{element}: triangles"), &triangles)?
                .into_iter()
                .map(|[a, b, c]| Ok([corner(a)?, corner(b)?, corner(c)?]))
                .collect::<PyResult<Vec<_>>>()?;
            let name = element.to_string();
            let made = move || from_arrays(&name, &vertices, triangles);
            shape.triangles = Some(Arc::new(long_call::apart(given.py(), made)?.map_err(exception)?));
        }
    }
    shape.scale = match floats(&format!("{element}: scale"), &given.getattr("scale")?)?[..] {
        [all] => Some(ScaleEntry::Uniform(all)),
        [x, y, z] => Some(ScaleEntry::Axes([x, y, z])),
        _ => return Err(PyValueError::new_err(format!("{element}: scale: expected one number or three"))),
    };
    shape.convex = given.getattr("convex")?.extract()?;
    shape.convex_parts = given.getattr("convex_parts")?.extract()?;
    Ok(())
}

/// Returns the vertices and triangles of a pair of arrays, or of a mesh of trimesh or open3d.
fn arrays_of_mesh<'py>(element: &str, source: &Bound<'py, PyAny>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    for triangles in ["faces", "triangles"] {
        if let (Ok(vertices), Ok(triangles)) = (source.getattr("vertices"), source.getattr(triangles)) {
            return Ok((vertices, triangles));
        }
    }
    source.extract().map_err(|_| {
        let found = kind(source);
        let hint = if found == "Scene" { "; one mesh of a trimesh scene is `scene.to_mesh()`" } else { "" };
        PyTypeError::new_err(format!(
            "{element}: got {found}, expected a path, (vertices, triangles) or a mesh with `.vertices` and `.faces` or \
             `.triangles`{hint}"
        ))
    })
}

/// Fills the shape of a `Fixture`.
///
/// # Errors
/// `TypeError` if `urdf` is no path.
pub fn fixture(element: &str, given: &Bound<'_, PyAny>, shape: &mut ShapeEntry) -> PyResult<()> {
    let urdf = given.getattr("urdf")?;
    let path = text_or_path(&urdf).ok().filter(|path| !path.trim_start().starts_with('<'));
    let wrong =
        || PyTypeError::new_err(format!("{element}: urdf: got {}, expected the path of a URDF file", kind(&urdf)));
    shape.urdf = Some(path.ok_or_else(wrong)?);
    shape.packages = folders(&format!("{element}: packages"), &given.getattr("packages")?)?;
    shape.geometry = Some(geometry(&format!("{element}: geometry"), &given.getattr("geometry")?)?);
    Ok(())
}

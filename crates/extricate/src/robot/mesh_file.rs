//! Mesh files: STL (binary and ASCII), OBJ and COLLADA, from bytes to a welded [`TriangleMesh`].

use super::{TriangleMesh, collada, obj, stl};
use crate::error::{Error, Result};
use crate::math::{FARTHEST, Vec3};

/// Parses by the extension of `file` (its name in messages), in any case: `stl`, `obj` or `dae`.
///
/// All objects of a file become one mesh. COLLADA: node transforms and `<unit>` are applied, `<up_axis>` is not, which is
/// what RViz shows.
///
/// # Errors
/// [`Error::Input`] for an unknown extension, text that does not parse, a file cut short, an index without its vertex, a
/// coordinate that is not finite (or beyond 1e9 m), and a mesh without any triangle of positive area.
pub fn parse(file: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
    let soup = match extension.as_str() {
        "stl" => stl::parse(file, bytes)?,
        "obj" => obj::parse(file, bytes)?,
        "dae" => collada::parse(file, bytes)?,
        _ => return Err(Error::input(file, "extension", format!("got `{extension}`, expected stl, obj or dae"))),
    };
    from_arrays(file, soup.vertices, soup.triangles)
}

/// Checks and welds vertices \[m\] and triangles; `name` is what messages call them.
///
/// # Errors
/// [`Error::Input`] for an index without its vertex, a coordinate that is not finite (or beyond 1e9 m), and where no
/// triangle has a positive area.
pub fn from_arrays(name: &str, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<TriangleMesh> {
    if let Some(index) = vertices.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
        let v = vertices[index];
        let problem = format!("got ({}, {}, {}), expected finite coordinates [m] within 1e9", v.x, v.y, v.z);
        return Err(Error::input(name, format!("vertex {index}"), problem));
    }
    if let Some(index) = triangles.iter().position(|t| t.iter().any(|&corner| corner as usize >= vertices.len())) {
        let problem = format!("got {:?}, expected indices below the {} vertices", triangles[index], vertices.len());
        return Err(Error::input(name, format!("triangle {index}"), problem));
    }
    let mesh = TriangleMesh::new(vertices, triangles);
    if mesh.triangles.is_empty() {
        return Err(Error::input(name, "mesh", "got no triangles of positive area, expected at least one"));
    }
    Ok(mesh)
}

/// What a file says: vertices that may repeat, and triangles with valid indices into them.
#[derive(Default)]
pub(super) struct Soup {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    pub fn push_triangle(&mut self, corners: [Vec3; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// As a fan; points and lines are nothing.
    pub fn push_polygon(&mut self, indices: &[u32]) {
        for k in 2..indices.len() {
            self.triangles.push([indices[0], indices[k - 1], indices[k]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_checked_before_they_are_used() {
        let corners = || [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]].map(Vec3::from).to_vec();
        assert_eq!(from_arrays("m", corners(), vec![[0, 1, 2]]).unwrap().triangles.len(), 1);
        let refused = |vertices, triangle| from_arrays("m", vertices, vec![triangle]).unwrap_err().to_string();
        assert!(refused(corners(), [0, 1, 3]).contains("m: triangle 0: got [0, 1, 3], expected indices below the 3"));
        assert!(refused(corners(), [0, 1, 1]).contains("no triangles of positive area"));
        let mut broken = corners();
        broken[1].y = f64::NAN;
        assert!(refused(broken, [0, 1, 2]).contains("vertex 1: got (1, NaN, 0)"));
    }

    #[test]
    fn unknown_extensions_are_named() {
        for (file, extension) in [("a.ply", "ply"), ("meshes/noext", ""), ("a.STEP", "step")] {
            let message = parse(file, b"").unwrap_err().to_string();
            assert_eq!(message, format!("{file}: extension: got `{extension}`, expected stl, obj or dae"));
        }
    }

    #[test]
    fn empty_files_are_errors() {
        for file in ["a.stl", "a.obj", "a.dae"] {
            assert!(parse(file, b"").is_err());
        }
    }
}

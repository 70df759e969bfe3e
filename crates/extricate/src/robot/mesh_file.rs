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
    if let Some(index) = soup.vertices.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
        let v = soup.vertices[index];
        let problem = format!("got ({}, {}, {}), expected finite coordinates [m] within 1e9", v.x, v.y, v.z);
        return Err(Error::input(file, format!("vertex {index}"), problem));
    }
    let mesh = TriangleMesh::new(soup.vertices, soup.triangles);
    if mesh.triangles.is_empty() {
        return Err(Error::input(file, "mesh", "got no triangles of positive area, expected at least one"));
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

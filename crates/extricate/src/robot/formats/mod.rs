//! Mesh files: STL (binary and ASCII), OBJ, COLLADA, PLY and glTF, from bytes to a welded
//! [`TriangleMesh`]; files of points (`cloud`) and of rows of numbers (`rows`); octrees (`octree`).

pub mod cloud;
#[cfg(feature = "meshes")]
pub mod collada;
#[cfg(feature = "meshes")]
pub mod gltf;
pub mod lines;
mod lzf;
#[cfg(feature = "meshes")]
pub mod obj;
pub mod octree;
mod pcd;
#[cfg(feature = "meshes")]
pub mod ply;
pub mod rows;
mod soup;
#[cfg(feature = "meshes")]
pub mod stl;
pub mod xml;

use super::mesh::components::Mending;
use super::mesh::seams::Welding;
use super::{LoadLimit, LoadLimits, TriangleMesh};
use crate::error::{Error, Result, quoted};
use crate::math::{FARTHEST, Vec3};
use soup::Neighbour;

/// The byte order mark of UTF-8, which editors on some systems put before a text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

/// Parses a mesh file by the extension of `file` (its name in messages), in any case: `stl`, `obj`,
/// `dae`, `ply`, `glb` or `gltf`. A `.gltf` has to contain its data; [`parse_among`] reads one that
/// names other files.
///
/// All objects of a file become one mesh. COLLADA: node transforms and `<unit>` are applied,
/// `<up_axis>` is not, as in RViz. glTF: node transforms are applied, and the axes stay those of
/// the file.
///
/// # Errors
/// [`Error::Input`] for an unknown extension, text that does not parse, a file cut short, an index
/// without its vertex, a coordinate that is not finite (or beyond 1e9 m), and a mesh without any
/// triangle of positive area.
pub fn parse(file: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    parse_and_warn(file, bytes, &mut Vec::new())
}

/// As [`parse`], and appends to `warnings` what the file's author may not have meant: faces that
/// cannot be triangulated, seams that were welded, walls that were left out.
///
/// # Errors
/// As [`parse`].
pub fn parse_and_warn(file: &str, bytes: &[u8], warnings: &mut Vec<String>) -> Result<TriangleMesh> {
    let mut alone = |uri: &str| {
        let problem = format!("got `{uri}`, expected all in one file: a .glb, or a .gltf with its data in it");
        Err(Error::input(file, "uri", problem))
    };
    parse_among(file, bytes, &LoadLimits::default(), &mut alone, warnings)
}

/// As [`parse_and_warn`], within limits; `neighbour` reads the files that a `.gltf` names.
///
/// # Errors
/// As [`parse`], a file that exceeds the limits, and errors of `neighbour`.
pub fn parse_among(
    file: &str,
    bytes: &[u8],
    limits: &LoadLimits,
    neighbour: Neighbour,
    warnings: &mut Vec<String>,
) -> Result<TriangleMesh> {
    limits.check(LoadLimit::FileBytes, bytes.len(), file, "file")?;
    let soup = soup_of(file, bytes, limits, neighbour)?;
    soup.has_room(0, 0).map_err(|problem| Error::input(file, "mesh", problem))?;
    warnings.extend(soup.told().map(|fault| format!("{file}: {fault}")));
    let (mesh, Mending { welding, walls }) = checked(file, soup.vertices, soup.triangles)?;
    warnings.extend(welding.map(|Welding { corners, farthest, closed }| {
        format!(
            "{file}: {corners} corners at open edges are welded to others within {farthest:.1e} m, which f32 hardly tells \
             apart: {closed} of {} components are closed by that",
            mesh.components.len()
        )
    }));
    if walls > 0 {
        let told = "edges with three triangles or more: walls inside, which are left out";
        warnings.push(format!("{file}: {walls} triangles hang inside a solid by {told}"));
    }
    Ok(mesh)
}

/// Reads the triangles of a mesh file, in the format that its extension names.
#[cfg(feature = "meshes")]
fn soup_of(file: &str, bytes: &[u8], limits: &LoadLimits, neighbour: Neighbour) -> Result<soup::Soup> {
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
    // A binary STL may begin with any bytes, so they are no mark there.
    let is_text = extension != "stl" || stl::looks_like_text(without_mark(bytes));
    let bytes = if is_text { without_mark(bytes) } else { bytes };
    match extension.as_str() {
        "stl" => stl::parse(file, bytes, limits),
        "obj" => obj::parse(file, bytes, limits),
        "dae" => collada::parse(file, bytes, limits),
        "ply" => ply::parse(file, bytes, limits),
        "glb" | "gltf" => gltf::parse(file, bytes, limits, neighbour),
        _ => {
            let problem = format!(
                "got `{}`, expected stl, obj, dae, ply, glb or gltf; others are to be converted, for instance in \
                 Python: trimesh.load(PATH, force='mesh').export('x.stl')",
                quoted(&extension)
            );
            Err(Error::input(file, "extension", problem))
        }
    }
}

#[cfg(not(feature = "meshes"))]
const WITHOUT_MESHES: &str =
    "got a mesh or PLY file, expected none: this build of extricate has not the feature `meshes`";

#[cfg(not(feature = "meshes"))]
fn soup_of(file: &str, _: &[u8], _: &LoadLimits, _: Neighbour) -> Result<soup::Soup> {
    Err(Error::input(file, "file", WITHOUT_MESHES))
}

/// Checks and welds vertices \[m\] and triangles; `name` is what messages call them.
///
/// # Errors
/// [`Error::Input`] for an index without its vertex, a coordinate that is not finite (or beyond 1e9
/// m), and if no triangle has a positive area.
pub fn from_arrays(name: &str, vertices: &[[f64; 3]], triangles: Vec<[u32; 3]>) -> Result<TriangleMesh> {
    Ok(checked(name, vertices.iter().copied().map(Vec3::from).collect(), triangles)?.0)
}

fn checked(name: &str, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<(TriangleMesh, Mending)> {
    if let Some(index) = vertices.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
        let v = vertices[index];
        let problem = format!("got ({}, {}, {}), expected finite coordinates [m] within 1e9", v.x, v.y, v.z);
        return Err(Error::input(name, format!("vertex {index}"), problem));
    }
    if let Some(index) = triangles.iter().position(|t| t.iter().any(|&corner| corner as usize >= vertices.len())) {
        let problem = format!("got {:?}, expected indices below the {} vertices", triangles[index], vertices.len());
        return Err(Error::input(name, format!("triangle {index}"), problem));
    }
    let (mesh, mending) = TriangleMesh::mended(vertices, triangles);
    if mesh.triangles.is_empty() {
        return Err(Error::input(name, "mesh", "got no triangles of positive area, expected at least one"));
    }
    Ok((mesh, mending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_checked_before_they_are_used() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        assert_eq!(from_arrays("m", &corners, vec![[0, 1, 2]]).unwrap().triangles.len(), 1);
        let refused = |vertices: &[_], triangle| from_arrays("m", vertices, vec![triangle]).unwrap_err().to_string();
        assert!(refused(&corners, [0, 1, 3]).contains("m: triangle 0: got [0, 1, 3], expected indices below the 3"));
        assert!(refused(&corners, [0, 1, 1]).contains("no triangles of positive area"));
        let mut broken = corners;
        broken[1][1] = f64::NAN;
        assert!(refused(&broken, [0, 1, 2]).contains("vertex 1: got (1, NaN, 0)"));
    }

    #[test]
    fn unknown_extensions_are_named() {
        for (file, extension) in [("a.off", "off"), ("meshes/noext", ""), ("a.STEP", "step")] {
            let message = parse(file, b"").unwrap_err().to_string();
            let expected =
                format!("{file}: extension: got `{extension}`, expected stl, obj, dae, ply, glb or gltf; others");
            assert!(message.starts_with(&expected) && message.contains("trimesh.load("), "{message}");
        }
    }

    #[test]
    fn texts_may_begin_with_a_byte_order_mark() {
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
        let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
            endsolid\n";
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        for (file, text) in [("a.obj", obj), ("a.stl", stl), ("a.ply", ply)] {
            let marked = parse(file, format!("\u{feff}{text}").as_bytes()).unwrap();
            assert_eq!(marked, parse(file, text.as_bytes()).unwrap(), "{file}");
        }
        // A binary STL whose header begins with the mark stays binary.
        let mut binary = [BYTE_ORDER_MARK, &[b' '; 77], &1u32.to_le_bytes(), &[0; 12]].concat();
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().for_each(|x| binary.extend(x.to_le_bytes()));
        binary.extend([0; 2]);
        assert_eq!(parse("a.stl", &binary).unwrap().triangles.len(), 1);
    }

    #[test]
    fn empty_files_are_errors() {
        for file in ["a.stl", "a.obj", "a.dae", "a.ply", "a.glb", "a.gltf"] {
            assert!(parse(file, b"").is_err());
        }
    }
}

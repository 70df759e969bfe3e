//! Reads glTF 2.0 (`.glb`, `.gltf`): the meshes of the scene, placed by its nodes. The crate `gltf`
//! reads and validates the description; numbers are read here, because the crate's readers trust
//! the counts in the file.
//!
//! The axes stay those of the file, as in assimp, trimesh and the viewers of robots that use them:
//! glTF specifies y up, but exporters of robots mean z. Materials, skins, morphs and animations are
//! skipped.

mod accessor;

use std::collections::HashMap;
use std::rc::Rc;

use base64::Engine;
use gltf::json::validation::{Error as Fault, Validate};
use gltf::json::{Path, Root};
use gltf::scene::Transform;
use gltf::{Document, Node, Primitive, Semantic, mesh::Mode};
use nalgebra::{Matrix3, Matrix4, Quaternion, UnitQuaternion};

use super::soup::{Neighbour, Soup};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits};

/// Largest depth of nested nodes; more is a cycle.
const MAX_NODE_DEPTH: usize = 64;

/// Extensions that compress the numbers, so that they cannot be read.
const COMPRESSED: [&str; 2] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];

struct Reader<'a> {
    file: &'a str,
    buffers: Vec<Rc<[u8]>>,
    limits: &'a LoadLimits,
    soup: Soup,
}

/// Parses the default scene, or the first one; if there is none, all meshes, unplaced. `neighbour`
/// reads the files that a `.gltf` names.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits, neighbour: Neighbour) -> Result<Soup> {
    let (root, blob) = root(file, bytes, limits)?;
    let document = Document::from_json_without_validation(root);
    let blob: Rc<[u8]> = blob.unwrap_or_default().into();
    let (mut buffers, mut total) = (Vec::new(), 0);
    // Many buffers may name one file.
    let mut known: HashMap<&str, Rc<[u8]>> = HashMap::new();
    for (number, buffer) in document.buffers().enumerate() {
        buffers.push(match buffer.source() {
            gltf::buffer::Source::Bin => Rc::clone(&blob),
            gltf::buffer::Source::Uri(uri) => match known.get(uri) {
                Some(known) => Rc::clone(known),
                None => {
                    let bytes: Rc<[u8]> = self::buffer(file, number, uri, neighbour)?.into();
                    total += bytes.len();
                    limits.check(LoadLimit::FileBytes, total, file, "buffers")?;
                    known.insert(uri, Rc::clone(&bytes));
                    bytes
                }
            },
        });
    }
    let mut reader = Reader { file, buffers, limits, soup: Soup::shown(limits, bytes.len() + total) };
    match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => {
            for node in scene.nodes() {
                reader.node(&node, &Matrix4::identity(), 0)?;
            }
        }
        None => {
            for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
                reader.primitive(&primitive, &Matrix4::identity())?;
            }
        }
    }
    Ok(reader.soup)
}

/// Returns the description, validated, and the binary part of a `.glb`.
fn root(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<(Root, Option<Vec<u8>>)> {
    let (json, blob) = if bytes.starts_with(b"glTF") {
        // The crate subtracts the header's size from this length, so it must not be smaller.
        let length =
            bytes.get(8..12).map_or(0, |field| field.iter().rev().fold(0, |all, &byte| all << 8 | usize::from(byte)));
        if !(12..=bytes.len()).contains(&length) {
            let problem = format!("got {} bytes, expected {length} as its header says", bytes.len());
            return Err(Error::input(file, "length", problem));
        }
        let glb = gltf::Glb::from_slice(&bytes[..length]).map_err(|error| {
            Error::input(file, "chunks", format!("got what is no GLB ({error}), expected glTF 2.0"))
        })?;
        (glb.json, glb.bin.map(Vec::from))
    } else {
        (bytes.into(), None)
    };
    // Each object becomes a node, an accessor or the like, of hundreds of bytes.
    let objects = json.iter().filter(|&&byte| byte == b'{').count();
    limits.check(LoadLimit::MeshNodes, objects, file, "JSON")?;
    let root: Root = serde_json::from_slice(&json)
        .map_err(|error| Error::input(file, "JSON", format!("got what is no glTF 2.0 ({error}), expected it")))?;
    if let Some(name) = root.extensions_required.iter().find(|name| COMPRESSED.contains(&name.as_str())) {
        let problem = format!("got {name}, expected a file that is not compressed: export it without");
        return Err(Error::input(file, "extensionsRequired", problem));
    }
    match fault(&root) {
        Some((path, error)) => Err(Error::input(file, path, format!("got what is no glTF 2.0 ({error}), expected it"))),
        None => Ok((root, blob)),
    }
}

/// Returns what is wrong with the description, and where.
fn fault(root: &Root) -> Option<(String, Fault)> {
    // The crate's validation takes these for valid indices of accessors.
    for (number, mesh) in root.meshes.iter().enumerate() {
        let mut indices = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if indices.any(|index| index.value() >= root.accessors.len()) {
            return Some((format!("meshes[{number}].primitives"), Fault::IndexOutOfBounds));
        }
    }
    let mut fault = None;
    root.validate(root, Path::new, &mut |path, error| {
        let path = path().to_string();
        // Other extensions concern appearance. Of attributes only positions are used, without their
        // bounds.
        let matters = error == Fault::IndexOutOfBounds || error == Fault::Invalid && !path.contains("attributes");
        if matters && fault.is_none() {
            fault = Some((path, error));
        }
    });
    fault
}

fn buffer(file: &str, number: usize, uri: &str, neighbour: Neighbour) -> Result<Vec<u8>> {
    let Some(data) = uri.strip_prefix("data:") else { return neighbour(&uri.replace("%20", " ")) };
    let text = data.split_once(";base64,").map(|(_, text)| text);
    let decoded = text.and_then(|text| base64::engine::general_purpose::STANDARD.decode(text).ok());
    decoded.ok_or_else(|| {
        Error::input(file, format!("buffers[{number}]"), "got a data URI that is not base64, expected one")
    })
}

impl Reader<'_> {
    fn node(&mut self, node: &Node, parent: &Matrix4<f64>, depth: usize) -> Result<()> {
        let place = || format!("nodes[{}]", node.index());
        if depth > MAX_NODE_DEPTH {
            let problem = format!("got nodes nested deeper than {MAX_NODE_DEPTH}, expected no cycle");
            return Err(Error::input(self.file, place(), problem));
        }
        self.soup.enter_node().map_err(|problem| Error::input(self.file, place(), problem))?;
        let matrix = parent * placed(&node.transform());
        for primitive in node.mesh().into_iter().flat_map(|mesh| mesh.primitives()) {
            self.primitive(&primitive, &matrix)?;
        }
        node.children().try_for_each(|child| self.node(&child, &matrix, depth + 1))
    }

    fn primitive(&mut self, primitive: &Primitive, matrix: &Matrix4<f64>) -> Result<()> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let positions = accessor::rows::<3>(self.file, &self.buffers, self.limits, &positions)?;
        let (first, count) = (self.soup.vertices.len() as u32, positions.len());
        let corners: Vec<u32> = match primitive.indices() {
            None => (0..count as u32).collect(),
            Some(indices) => {
                let place = format!("accessors[{}]", indices.index());
                let known = |[index]: [f64; 1]| match index < count as f64 {
                    true => Ok(index as u32),
                    false => Err(Error::input(
                        self.file,
                        &place,
                        format!("got index {index}, expected one of {count} vertices"),
                    )),
                };
                accessor::rows::<1>(self.file, &self.buffers, self.limits, &indices)?
                    .into_iter()
                    .map(known)
                    .collect::<Result<_>>()?
            }
        };
        let room = self.soup.may_place(count, corners.len() / 3);
        room.map_err(|problem| Error::input(self.file, "meshes", problem))?;
        let corners: Vec<u32> = corners.into_iter().map(|corner| first + corner).collect();
        let place = |p: [f64; 3]| matrix.fixed_view::<3, 3>(0, 0) * Vec3::from(p) + matrix.fixed_view::<3, 1>(0, 3);
        self.soup.vertices.extend(positions.into_iter().map(place));
        let from = self.soup.triangles.len();
        match mode {
            Mode::TriangleStrip => self.soup.push_strip(&corners),
            Mode::TriangleFan => self.soup.push_fan(&corners),
            _ => self.soup.triangles.extend_from_slice(corners.as_chunks().0),
        }
        // Mirroring reverses the side that a triangle faces, so its winding is reversed too.
        if matrix.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            self.soup.triangles[from..].iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(())
    }
}

fn placed(transform: &Transform) -> Matrix4<f64> {
    match transform {
        Transform::Matrix { matrix } => Matrix4::from_fn(|row, column| f64::from(matrix[column][row])),
        Transform::Decomposed { translation, rotation, scale } => {
            let [x, y, z, w] = rotation.map(f64::from);
            let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
            let linear = rotation.to_rotation_matrix() * Matrix3::from_diagonal(&Vec3::from(scale.map(f64::from)));
            let mut matrix = linear.to_homogeneous();
            matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vec3::from(translation.map(f64::from)));
            matrix
        }
    }
}

#[cfg(test)]
mod tests;

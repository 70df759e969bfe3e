//! Reads a `moveit_msgs/CollisionObject`: primitives, meshes and planes, each with its pose.

use std::sync::Arc;

use serde_json::Value;

use super::message_pose::MessagePose;
use super::objects::{Object, Objects, Shape};
use super::value::At;
use crate::error::Result;
use crate::robot::formats;
use crate::robot::packages::file_path;

const OBJECT_FIELDS: &[&str] = &[
    "header",
    "pose",
    "id",
    "type",
    "primitives",
    "primitive_poses",
    "meshes",
    "mesh_poses",
    "planes",
    "plane_poses",
    "subframe_names",
    "subframe_poses",
    "operation",
];

/// Returns whether the object is added, which is the default; notes any other operation.
pub fn operation(at: &At, objects: &mut Objects) -> Result<bool> {
    const WORDS: [&str; 4] = ["add", "remove", "append", "move"];
    let Some(operation) = at.get("operation")? else { return Ok(true) };
    // `ros2 topic echo` writes a byte as a character, rosbridge as base64.
    let code = match operation.value {
        Value::Number(_) => Some(operation.number()?),
        Value::String(text) => {
            let base64 = ["AA==", "AQ==", "Ag==", "Aw=="].iter().position(|word| word == text);
            let word = WORDS.iter().position(|word| word.eq_ignore_ascii_case(text));
            let mut characters = text.chars();
            let character = characters.next().filter(|_| characters.next().is_none()).map(|c| c as usize);
            base64.or(word).or(character).map(|code| code as f64)
        }
        _ => None,
    };
    match code {
        Some(0.0 | 2.0) => Ok(true),
        Some(code @ (1.0 | 3.0)) => {
            let word = WORDS[code as usize];
            objects.note(format!("{}: its operation is to {word} it: nothing is written", at.path));
            Ok(false)
        }
        _ => Err(operation.fault("0 (add), 1 (remove), 2 (append) or 3 (move)")),
    }
}

/// Reads an object; `frame` is the pose of the frame that its poses are given in.
pub fn object(at: &At, frame: &MessagePose, objects: &mut Objects) -> Result<Object> {
    let name = at.text("id")?.to_string();
    objects.note_unknown(at, OBJECT_FIELDS)?;
    let pose = frame.then(&at.pose("pose")?);
    let mut shapes = Vec::new();
    for (kind, poses) in [("primitives", "primitive_poses"), ("meshes", "mesh_poses"), ("planes", "plane_poses")] {
        let (found, poses) = (at.list(kind)?, at.list(poses)?);
        if poses.len() > found.len() || (poses.len() < found.len() && !poses.is_empty()) {
            let path = format!("{}.{}", at.path, if kind == "meshes" { "mesh_poses" } else { kind });
            let problem = format!("got {} {kind} and {} poses, expected as many", found.len(), poses.len());
            return Err(crate::error::Error::input(at.file, path, problem));
        }
        for (index, shape_at) in found.iter().enumerate() {
            let shape = match kind {
                "primitives" => primitive(shape_at)?,
                "meshes" => mesh(shape_at)?,
                _ => plane(shape_at)?,
            };
            let own = poses.get(index).map_or(Ok(MessagePose::IDENTITY), |pose| pose.as_pose())?;
            shapes.push((shape, pose.then(&own)));
        }
    }
    if !at.list("subframe_names")?.is_empty() {
        objects.note(format!("{}: its subframes are not taken: a scene has none", at.path));
    }
    let has_type = |kind: At| Ok::<bool, crate::error::Error>(!kind.text("key")?.is_empty());
    if at.get("type")?.map_or(Ok(false), has_type)? {
        objects.note(format!("{}: its type is not taken: a scene has shapes alone", at.path));
    }
    Ok(Object { name, shapes })
}

fn primitive(at: &At) -> Result<Shape> {
    const KINDS: &str = "1 (box), 2 (sphere), 3 (cylinder) or 4 (cone)";
    let kind = at.get("type")?.ok_or_else(|| at.fault(&format!("a mapping with `type`: {KINDS}")))?;
    let word = kind.value.as_str().map(str::to_ascii_lowercase);
    let code = match (word.as_deref(), kind.value.as_u64()) {
        (Some("box"), _) | (_, Some(1)) => 1,
        (Some("sphere"), _) | (_, Some(2)) => 2,
        (Some("cylinder"), _) | (_, Some(3)) => 3,
        (Some("cone"), _) | (_, Some(4)) => 4,
        (Some("prism"), _) | (_, Some(5)) => return Err(kind.fault(&format!("{KINDS}: give a prism as a mesh"))),
        _ => return Err(kind.fault(KINDS)),
    };
    let sizes = at.get("dimensions")?.ok_or_else(|| at.fault("a mapping with `dimensions`"))?;
    Ok(match code {
        1 => Shape::Box(sizes.numbers(["x", "y", "z"])?),
        2 => Shape::Sphere(sizes.numbers(["radius"])?[0]),
        // The message has the height first.
        3 => Shape::Cylinder(swapped(sizes.numbers(["height", "radius"])?)),
        _ => Shape::Cone(swapped(sizes.numbers(["height", "radius"])?)),
    })
}

fn swapped([height, radius]: [f64; 2]) -> [f64; 2] {
    [radius, height]
}

/// Reads a mesh from vertices and triangles, or from a file with a scale, as Robowflex writes it.
fn mesh(at: &At) -> Result<Shape> {
    if let Some(resource) = at.get("resource")? {
        let path = file_path(resource.string()?);
        if path.contains("://") {
            return Err(resource.fault("the path of a mesh file: packages are not known here"));
        }
        let scale = at.get("dimensions")?.map_or(Ok([1.0; 3]), |scale| scale.numbers(["x", "y", "z"]))?;
        return Ok(Shape::MeshFile(path, scale));
    }
    let vertex = |at: At| at.numbers(["x", "y", "z"]);
    let vertices = at.list("vertices")?.into_iter().map(vertex).collect::<Result<Vec<_>>>()?;
    let triangle = |at: At| -> Result<[u32; 3]> {
        let corners = if at.value.is_object() { at.get("vertex_indices")? } else { Some(at.clone()) };
        let corners = corners.ok_or_else(|| at.fault("a mapping with `vertex_indices`"))?;
        let mut indices = [0; 3];
        for (index, corner) in indices.iter_mut().zip(corners.numbers(["first", "second", "third"])?) {
            let is_index = corner.fract() == 0.0 && (0.0..vertices.len() as f64).contains(&corner);
            let expected = || corners.fault(&format!("three indices below the {} vertices", vertices.len()));
            *index = if is_index { corner as u32 } else { return Err(expected()) };
        }
        Ok(indices)
    };
    let triangles = at.list("triangles")?.into_iter().map(triangle).collect::<Result<Vec<_>>>()?;
    let mesh = formats::from_arrays(&format!("{}: {}", at.file, at.path), &vertices, triangles)?;
    Ok(Shape::Mesh(Arc::new(mesh)))
}

fn plane(at: &At) -> Result<Shape> {
    let coefficients = if at.value.is_object() { at.get("coef")? } else { Some(at.clone()) };
    let coefficients = coefficients.ok_or_else(|| at.fault("a mapping with `coef`: a, b, c, d"))?;
    Ok(Shape::Plane(coefficients.numbers(["a", "b", "c", "d"])?))
}

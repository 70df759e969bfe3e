//! URDF to [`Robot`](super::Robot): what collides and what moves. Visuals, inertias and plugins are skipped.

use std::collections::HashMap;
use std::sync::Arc;

use roxmltree::Node;

use super::tree::{NamedMimic, resolve_mimics, root};
use super::xml::{NEEDS_XACRO, child, children, document, label, numbers, numbers_or, required};
use super::{Geometry, Joint, JointKind, Link, LinkGeometry, Robot, TriangleMesh};
use crate::error::{Error, Result};
use crate::math::{Pose, Vec3, quaternion_matrix};

/// Loads an unscaled mesh by the `filename` attribute of a `<mesh>` element.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str) -> Result<Arc<TriangleMesh>>;

/// Parses URDF `text`; `file` is its name in messages. Warnings are appended to `warnings`.
///
/// Joint types are those of URDF and `spherical`; geometries those of URDF and `capsule`, whose length is that of the
/// cylindrical part. A mimic joint has no limits of its own: it goes where the joint it follows takes it. Soft limits
/// (`safety_controller`) are ignored.
///
/// # Errors
/// [`Error::Input`], with the link or joint, the value and what was expected: text that is not plain URDF, names that
/// repeat or do not exist, links that are not one tree, limits or axes that make no sense, sizes that are not positive.
pub fn parse(file: &str, text: &str, load_mesh: LoadMesh, warnings: &mut Vec<String>) -> Result<Robot> {
    let document = document(file, text, "URDF")?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(Error::input(file, "root", format!("got <{}>, expected <robot>", robot.tag_name().name())));
    }
    if let Some(macro_node) =
        robot.descendants().find(|n| n.tag_name().namespace().is_some_and(|n| n.contains("xacro")))
    {
        let line = document.text_pos_at(macro_node.range().start).row;
        return Err(Error::input(file, format!("line {line}"), NEEDS_XACRO));
    }
    let mut meshes = Meshes { load: load_mesh, scaled: HashMap::new() };
    let mut links = Vec::new();
    let mut link_of_name = HashMap::new();
    for node in children(robot, "link") {
        let link = parse_link(file, node, &mut meshes, warnings)?;
        if link_of_name.insert(link.name.clone(), links.len()).is_some() {
            return Err(Error::input(file, label(node), "got a second link of this name, expected unique names"));
        }
        links.push(link);
    }
    let mut joints: Vec<Joint> = Vec::new();
    let mut mimics = Vec::new();
    for node in children(robot, "joint") {
        let joint = parse_joint(file, node, &link_of_name, warnings)?;
        if joints.iter().any(|other| other.name == joint.name) {
            return Err(Error::input(file, label(node), "got a second joint of this name, expected unique names"));
        }
        // Fixed joints stay fixed, whatever they are said to follow.
        if let Some(mimic) = child(node, "mimic").filter(|_| joint.kind != JointKind::Fixed) {
            let element = label(node);
            let [multiplier] = numbers_or(file, &element, Some(mimic), "multiplier", [1.0])?;
            let [offset] = numbers_or(file, &element, Some(mimic), "offset", [0.0])?;
            let followed = required(file, &element, mimic, "joint")?.to_owned();
            mimics.push(NamedMimic { joint: joints.len(), followed, multiplier, offset });
        }
        joints.push(joint);
    }
    let root = root(file, &links, &joints)?;
    resolve_mimics(file, &mimics, &mut joints)?;
    Ok(Robot { name: robot.attribute("name").unwrap_or("robot").to_owned(), links, joints, root })
}

/// Meshes, each scaled once however many links use it.
struct Meshes<'a> {
    load: LoadMesh<'a>,
    scaled: HashMap<(String, [u64; 3]), Arc<TriangleMesh>>,
}

fn parse_link(file: &str, node: Node, meshes: &mut Meshes, warnings: &mut Vec<String>) -> Result<Link> {
    let element = label(node);
    let name = required(file, &element, node, "name")?.to_owned();
    let mut collision = Vec::new();
    for part in children(node, "collision") {
        let geometry = child(part, "geometry").and_then(|g| g.children().find(Node::is_element));
        let Some(geometry) = geometry else {
            warnings.push(format!("{file}: {element}: a <collision> without geometry is ignored"));
            continue;
        };
        let pose_link_geometry = parse_origin(file, &element, part)?;
        let geometry = parse_geometry(file, &element, geometry, meshes)?;
        collision.push(LinkGeometry { pose_link_geometry, geometry });
    }
    Ok(Link { name, collision })
}

fn parse_origin(file: &str, element: &str, node: Node) -> Result<Pose> {
    let origin = child(node, "origin");
    let xyz = numbers_or(file, element, origin, "xyz", [0.0; 3])?;
    let rpy = numbers_or(file, element, origin, "rpy", [0.0; 3])?;
    let mut pose = Pose::from_xyz_rpy(xyz, rpy);
    if let Some(value) = origin.and_then(|origin| origin.attribute("quat_xyzw")) {
        let quaternion = nalgebra::Vector4::from(numbers::<4>(file, element, "quat_xyzw", value)?);
        let unit = quaternion.try_normalize(1e-9).ok_or_else(|| {
            Error::input(file, element, format!("got quat_xyzw=\"{value}\", expected a quaternion that is not zero"))
        })?;
        pose.rotation = quaternion_matrix(unit.as_slice());
    }
    Ok(pose)
}

fn parse_geometry(file: &str, element: &str, node: Node, meshes: &mut Meshes) -> Result<Geometry> {
    let value = |attribute| required(file, element, node, attribute);
    let positive = |attribute| {
        let text = value(attribute)?;
        let [size] = numbers(file, element, attribute, text)?;
        if size > 0.0 {
            return Ok(size);
        }
        Err(Error::input(file, element, format!("got {attribute}=\"{text}\", expected a positive size [m]")))
    };
    Ok(match node.tag_name().name() {
        "sphere" => Geometry::Sphere { radius: positive("radius")? },
        "cylinder" => Geometry::Cylinder { radius: positive("radius")?, half_length: 0.5 * positive("length")? },
        "capsule" => Geometry::Capsule { radius: positive("radius")?, half_length: 0.5 * positive("length")? },
        "box" => {
            let text = value("size")?;
            let size = numbers(file, element, "size", text)?;
            if !size.iter().all(|&side| side > 0.0) {
                return Err(Error::input(file, element, format!("got size=\"{text}\", expected positive sizes [m]")));
            }
            Geometry::Box { half_extents: 0.5 * Vec3::from(size) }
        }
        "mesh" => {
            let scale = numbers_or(file, element, Some(node), "scale", [1.0; 3])?;
            if scale.contains(&0.0) {
                let problem = format!("got mesh scale {scale:?}, expected factors that are not zero");
                return Err(Error::input(file, element, problem));
            }
            let name = value("filename")?;
            let key = (name.to_owned(), scale.map(f64::to_bits));
            let mesh = match meshes.scaled.get(&key) {
                Some(mesh) => Arc::clone(mesh),
                None => {
                    let mesh = (meshes.load)(name)?;
                    let mesh = if scale == [1.0; 3] { mesh } else { Arc::new(mesh.scaled(scale)) };
                    meshes.scaled.insert(key, Arc::clone(&mesh));
                    mesh
                }
            };
            Geometry::Mesh(mesh)
        }
        tag => {
            let problem = format!("got geometry <{tag}>, expected box, sphere, cylinder, capsule or mesh");
            return Err(Error::input(file, element, problem));
        }
    })
}

fn parse_joint(file: &str, node: Node, links: &HashMap<String, usize>, warnings: &mut Vec<String>) -> Result<Joint> {
    let element = &label(node);
    let name = required(file, element, node, "name")?.to_owned();
    let kind = match required(file, element, node, "type")? {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "planar" => JointKind::Planar,
        "spherical" => JointKind::Spherical,
        "floating" => JointKind::Floating,
        other => {
            let kinds = "fixed, revolute, continuous, prismatic, planar, spherical or floating";
            return Err(Error::input(file, element, format!("got type=\"{other}\", expected {kinds}")));
        }
    };
    let link = |tag| {
        let found = child(node, tag)
            .ok_or_else(|| Error::input(file, element, format!("got no <{tag}>, expected one with a link")))?;
        let name = required(file, element, found, "link")?;
        links.get(name).copied().ok_or_else(|| {
            Error::input(file, element, format!("got {tag} link=\"{name}\", expected a link of this robot"))
        })
    };
    let (parent, child_link) = (link("parent")?, link("child")?);
    let axis = Vec3::from(numbers_or(file, element, child(node, "axis"), "xyz", [1.0, 0.0, 0.0])?);
    let moves_along = !matches!(kind, JointKind::Fixed | JointKind::Spherical | JointKind::Floating);
    let axis = match axis.try_normalize(1e-9) {
        Some(axis) => axis,
        None if moves_along => {
            let problem = format!("got axis xyz=\"{} {} {}\", expected one that is not zero", axis.x, axis.y, axis.z);
            return Err(Error::input(file, element, problem));
        }
        None => Vec3::x(),
    };
    Ok(Joint {
        limits: parse_limits(file, element, node, kind, warnings)?,
        pose_parent_joint: parse_origin(file, element, node)?,
        mimic: None,
        name,
        kind,
        parent,
        child: child_link,
        axis,
    })
}

fn parse_limits(
    file: &str,
    element: &str,
    joint: Node,
    kind: JointKind,
    warnings: &mut Vec<String>,
) -> Result<Option<(f64, f64)>> {
    let limit = child(joint, "limit");
    let given = |attribute| limit.is_some_and(|limit| limit.has_attribute(attribute));
    let single = matches!(kind, JointKind::Revolute | JointKind::Prismatic);
    let composite = matches!(kind, JointKind::Planar | JointKind::Floating) && given("lower") && given("upper");
    if child(joint, "mimic").is_some() || !(single || composite) {
        return Ok(None);
    }
    if limit.is_none() {
        return Err(Error::input(file, element, "got no <limit>, expected one with `lower` and `upper`"));
    }
    let [lower] = numbers_or(file, element, limit, "lower", [0.0])?;
    let [upper] = numbers_or(file, element, limit, "upper", [0.0])?;
    if lower > upper {
        return Err(Error::input(file, element, format!("got limits {lower} to {upper}, expected lower <= upper")));
    }
    if lower == upper {
        warnings.push(format!("{file}: {element}: cannot move, its limits are {lower} and {upper}"));
    }
    Ok(Some((lower, upper)))
}

#[cfg(test)]
mod tests;

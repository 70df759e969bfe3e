//! URDF to [`Robot`]: what collides and what moves, read by `urdf_rs`. Visuals, inertias and plugins are skipped.

use std::collections::HashMap;
use std::sync::Arc;

use urdf_rs::JointType;

use super::mesh::is_scale;
use super::tree::{NamedMimic, resolve_mimics, root};
use super::{Geometry, Joint, JointKind, Link, LinkGeometry, Robot, TriangleMesh};
use crate::error::{Error, Result};
use crate::math::{FARTHEST, Pose, Vec3};

mod plain;

/// Loads an unscaled mesh by the `filename` attribute of a `<mesh>` element.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str) -> Result<Arc<TriangleMesh>>;

/// Which shapes of its links a robot collides with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shapes {
    /// Those of `<collision>` elements.
    Collision,
    /// Those of `<visual>` elements.
    Visual,
}

/// Parses URDF `text`; `file` is its name in messages. Warnings are appended to `warnings`.
///
/// Joint types are those of URDF and `spherical`; geometries those of URDF and `capsule`, whose length is that of the
/// cylindrical part. A mimic joint has no limits of its own: it goes where the joint it follows takes it. Soft limits
/// (`safety_controller`) are ignored. A lower or upper limit that is not stated is 0, from URDF version 1.2 on an error.
///
/// # Errors
/// [`Error::Input`], with the link or joint, the value and what was expected: text that is not
/// plain URDF, names that repeat or do not exist, links that are not one tree, limits or axes that
/// make no sense, sizes that are negative. Points and segments are left out, discs and plates are
/// as thin as a micrometre, each with a warning.
pub fn parse(file: &str, text: &str, shapes: Shapes, load_mesh: LoadMesh, warnings: &mut Vec<String>) -> Result<Robot> {
    let plain = plain::plain(file, text, shapes, warnings)?;
    let urdf = urdf_rs::read_from_string(&plain)
        .map_err(|error| Error::input(file, "robot", format!("got what urdf-rs calls `{error}`, expected URDF")))?;
    let mut meshes = Meshes { load: load_mesh, scaled: HashMap::new() };
    let mut links = Vec::with_capacity(urdf.links.len());
    let mut link_of_name = HashMap::new();
    for link in urdf.links {
        let element = format!("link \"{}\"", link.name);
        if link_of_name.insert(link.name.clone(), links.len()).is_some() {
            return Err(Error::input(file, element, "got a second link of this name, expected unique names"));
        }
        let mut collision = Vec::with_capacity(link.collision.len());
        for mut part in link.collision {
            if let Some((is_something, told)) = mend_zero_size(&mut part.geometry) {
                warnings.push(format!("{file}: {element}: {told}"));
                if !is_something {
                    continue;
                }
            }
            let geometry = convert_geometry(file, &element, &part.geometry, &mut meshes)?;
            collision.push(LinkGeometry { pose_link_geometry: pose(&part.origin), geometry });
        }
        links.push(Link { name: link.name, collision });
    }
    let mut joints: Vec<Joint> = Vec::with_capacity(urdf.joints.len());
    let mut mimics = Vec::new();
    for joint in &urdf.joints {
        let converted = convert_joint(file, joint, &link_of_name, warnings)?;
        if joints.iter().any(|other| other.name == joint.name) {
            let element = format!("joint \"{}\"", joint.name);
            return Err(Error::input(file, element, "got a second joint of this name, expected unique names"));
        }
        if let Some(mimic) = &joint.mimic {
            let (multiplier, offset) = (mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0));
            mimics.push(NamedMimic { joint: joints.len(), followed: mimic.joint.clone(), multiplier, offset });
        }
        joints.push(converted);
    }
    let root = root(file, &links, &joints)?;
    resolve_mimics(file, &mimics, &mut joints)?;
    Ok(Robot { name: urdf.name, links, joints, root })
}

/// What a geometry without volume is taken for \[m\], where it has an area: more than rounding,
/// less than any clearance in use.
const THIN: f64 = 1e-6;

/// Mends a geometry without volume, and says what it is taken for: a disc or plate is as thin as
/// [`THIN`]; points and segments, which exporters write where nothing shall collide, are nothing.
fn mend_zero_size(geometry: &mut urdf_rs::Geometry) -> Option<(bool, String)> {
    let is_zero = |sizes: &[f64]| sizes.contains(&0.0) && sizes.iter().all(|size| *size >= 0.0);
    let told = |size: String, has_area: bool| {
        let taken = if has_area { format!("{THIN:e} m thick") } else { "none".into() };
        Some((has_area, format!("a collision geometry with {size} is taken for {taken}")))
    };
    match geometry {
        urdf_rs::Geometry::Sphere { radius } if *radius == 0.0 => told(format!("radius=\"{radius}\""), false),
        urdf_rs::Geometry::Cylinder { radius, length } if is_zero(&[*radius, *length]) => {
            let size = format!("radius=\"{radius}\" length=\"{length}\"");
            let has_area = *radius > 0.0;
            *length = length.max(THIN);
            told(size, has_area)
        }
        urdf_rs::Geometry::Capsule { radius, length } if *radius == 0.0 && *length >= 0.0 => {
            told(format!("radius=\"{radius}\" length=\"{length}\""), false)
        }
        urdf_rs::Geometry::Box { size } if is_zero(&**size) => {
            let [x, y, z] = **size;
            let has_area = [x, y, z].iter().filter(|side| **side == 0.0).count() == 1;
            size.iter_mut().for_each(|side| *side = side.max(THIN));
            told(format!("size=\"{x} {y} {z}\""), has_area)
        }
        _ => None,
    }
}

/// Meshes, each scaled once however many links use it.
struct Meshes<'a> {
    load: LoadMesh<'a>,
    scaled: HashMap<(String, [u64; 3]), Arc<TriangleMesh>>,
}

fn pose(origin: &urdf_rs::Pose) -> Pose {
    Pose::from_xyz_rpy(*origin.xyz, *origin.rpy)
}

fn convert_geometry(file: &str, element: &str, geometry: &urdf_rs::Geometry, meshes: &mut Meshes) -> Result<Geometry> {
    let positive = |name: &str, size: f64| {
        if size > 0.0 {
            return Ok(size);
        }
        Err(Error::input(file, element, format!("got {name}=\"{size}\", expected a positive size [m]")))
    };
    Ok(match geometry {
        urdf_rs::Geometry::Sphere { radius } => Geometry::Sphere { radius: positive("radius", *radius)? },
        urdf_rs::Geometry::Cylinder { radius, length } => {
            Geometry::Cylinder { radius: positive("radius", *radius)?, half_length: 0.5 * positive("length", *length)? }
        }
        urdf_rs::Geometry::Capsule { radius, length } if *length == 0.0 => {
            Geometry::Sphere { radius: positive("radius", *radius)? }
        }
        urdf_rs::Geometry::Capsule { radius, length } => {
            Geometry::Capsule { radius: positive("radius", *radius)?, half_length: 0.5 * positive("length", *length)? }
        }
        urdf_rs::Geometry::Box { size } => {
            let [x, y, z] = **size;
            if !(x > 0.0 && y > 0.0 && z > 0.0) {
                let problem = format!("got size=\"{x} {y} {z}\", expected positive sizes [m]");
                return Err(Error::input(file, element, problem));
            }
            Geometry::Box { half_extents: 0.5 * Vec3::new(x, y, z) }
        }
        urdf_rs::Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or([1.0; 3], |scale| *scale);
            if !is_scale(&scale) {
                let problem = format!("got mesh scale {scale:?}, expected factors of size 1e-9 to 1e9, not zero");
                return Err(Error::input(file, element, problem));
            }
            let key = (filename.clone(), scale.map(f64::to_bits));
            let mesh = match meshes.scaled.get(&key) {
                Some(mesh) => Arc::clone(mesh),
                None => {
                    let mesh = (meshes.load)(filename)?;
                    let mesh = if scale == [1.0; 3] { mesh } else { Arc::new(mesh.scaled(scale)) };
                    meshes.scaled.insert(key, Arc::clone(&mesh));
                    mesh
                }
            };
            Geometry::Mesh(mesh)
        }
    })
}

fn convert_joint(
    file: &str,
    joint: &urdf_rs::Joint,
    links: &HashMap<String, usize>,
    warnings: &mut Vec<String>,
) -> Result<Joint> {
    let element = &format!("joint \"{}\"", joint.name);
    let kind = match joint.joint_type {
        JointType::Fixed => JointKind::Fixed,
        JointType::Revolute => JointKind::Revolute,
        JointType::Continuous => JointKind::Continuous,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Planar => JointKind::Planar,
        JointType::Spherical => JointKind::Spherical,
        JointType::Floating => JointKind::Floating,
    };
    let link = |tag: &str, name: &str| {
        links.get(name).copied().ok_or_else(|| {
            Error::input(file, element, format!("got {tag} link=\"{name}\", expected a link of this robot"))
        })
    };
    let moves_along = !matches!(kind, JointKind::Fixed | JointKind::Spherical | JointKind::Floating);
    let [x, y, z] = *joint.axis.xyz;
    let axis = match Vec3::new(x, y, z).try_normalize(1e-9) {
        Some(axis) => axis,
        None if moves_along => {
            let problem = format!("got axis xyz=\"{x} {y} {z}\", expected one that is not zero");
            return Err(Error::input(file, element, problem));
        }
        None => Vec3::x(),
    };
    let limits = if joint.mimic.is_some() { None } else { limits(file, element, kind, &joint.limit, warnings)? };
    // Propellers are often written as revolute with limits of 1e16.
    let stated = joint.limit.lower.is_finite() && joint.limit.upper.is_finite();
    let turns_freely = kind == JointKind::Revolute && joint.mimic.is_none() && limits.is_none() && stated;
    if turns_freely {
        let (lower, upper) = (joint.limit.lower, joint.limit.upper);
        warnings.push(format!("{file}: {element}: its limits {lower:e} and {upper:e} are taken for none: continuous"));
    }
    Ok(Joint {
        name: joint.name.clone(),
        kind: if turns_freely { JointKind::Continuous } else { kind },
        parent: link("parent", &joint.parent.link)?,
        child: link("child", &joint.child.link)?,
        pose_parent_joint: pose(&joint.origin),
        axis,
        limits,
        mimic: None,
    })
}

fn limits(
    file: &str,
    element: &str,
    kind: JointKind,
    limit: &urdf_rs::JointLimit,
    warnings: &mut Vec<String>,
) -> Result<Option<(f64, f64)>> {
    let (lower, upper) = (limit.lower, limit.upper);
    let finite = lower.is_finite() && upper.is_finite();
    match kind {
        JointKind::Fixed | JointKind::Continuous | JointKind::Spherical => return Ok(None),
        // So `plain` writes what the file leaves out, and so some write it themselves; the scene may have other limits.
        _ if lower < -FARTHEST && upper > FARTHEST => return Ok(None),
        _ if !finite => {
            let problem = format!("got limits {lower} to {upper}, expected `lower` and `upper`, both finite");
            return Err(Error::input(file, element, problem));
        }
        _ => {}
    }
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

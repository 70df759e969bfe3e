//! Converts the `<joint>` elements of a URDF to [`Joint`]s. `tree` checks whether they make a tree.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::element_reader::ElementReader;
use crate::error::{Result, quoted};
use crate::math::{FARTHEST, Vec3};
use crate::robot::formats::xml::{child, children, label, numbers_within, own_attribute};
use crate::robot::link_tree::NamedMimic;
use crate::robot::{Joint, JointKind};

/// From this URDF version on, a missing limit is not 0 but infinite, and it is an error to state
/// only one.
const EXPLICIT_LIMITS_VERSION: f64 = 1.2;

/// Reads all joints in document order, and which of them follow others.
pub(crate) fn joints(
    file: &str,
    robot: Node,
    (version, is_replaced): (f64, &dyn Fn(&str) -> bool),
    links: &HashMap<String, usize>,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Joint>, Vec<NamedMimic>)> {
    let (mut joints, mut mimics, mut names) = (Vec::new(), Vec::new(), HashSet::new());
    let known: HashSet<&str> = children(robot, "joint").filter_map(|node| own_attribute(node, "name")).collect();
    for node in children(robot, "joint") {
        let reader = ElementReader { file, element: label(node) };
        // Fixed joints stay fixed even if they have a <mimic>.
        let follows = child(node, "mimic").filter(|_| own_attribute(node, "type") != Some("fixed"));
        let followed = follows.map(|mimic| reader.required(mimic, "joint")).transpose()?;
        let is_known = followed.is_some_and(|name| known.contains(name));
        if let Some(name) = followed.filter(|_| !is_known) {
            let told = "it moves on its own, as other readers have it";
            warnings.push(format!(
                "{file}: {}: it follows \"{}\", which is no joint of this robot: {told}",
                reader.element,
                quoted(name)
            ));
        }
        // Followers have no limits of their own.
        let has_limits = !is_known && !own_attribute(node, "name").is_some_and(is_replaced);
        let joint = joint(&reader, node, version, has_limits, (links, warnings))?;
        if !names.insert(joint.name.clone()) {
            return Err(reader.error("got a second joint of this name, expected unique names"));
        }
        if let (Some(mimic), Some(followed), true) = (follows, followed, is_known) {
            let followed = followed.to_owned();
            let [multiplier] = reader.numbers_or(Some(mimic), "multiplier", [1.0])?;
            let [offset] = reader.numbers_or(Some(mimic), "offset", [0.0])?;
            mimics.push(NamedMimic { joint: joints.len(), followed, multiplier, offset });
        }
        joints.push(joint);
    }
    Ok((joints, mimics))
}

fn joint(
    reader: &ElementReader,
    node: Node,
    version: f64,
    has_limits: bool,
    (links, warnings): (&HashMap<String, usize>, &mut Vec<String>),
) -> Result<Joint> {
    let name = reader.required(node, "name")?.to_owned();
    let kind = kind(reader, reader.required(node, "type")?)?;
    let end = |tag: &'static str| {
        let end = child(node, tag).ok_or_else(|| reader.error(format!("got no <{tag}>, expected one with a link")))?;
        let name = reader.required(end, "link")?;
        let unknown = || reader.error(format!("got {tag} link=\"{}\", expected a link of this robot", quoted(name)));
        links.get(name).copied().ok_or_else(unknown)
    };
    let (parent, child_link) = (end("parent")?, end("child")?);
    let pose_parent_joint = reader.origin(node)?;
    let moves_along = !matches!(kind, JointKind::Fixed | JointKind::Spherical | JointKind::Floating);
    let [x, y, z] = reader.numbers_or(child(node, "axis"), "xyz", [1.0, 0.0, 0.0])?;
    let axis = match Vec3::new(x, y, z).try_normalize(1e-9) {
        Some(axis) => axis,
        None if moves_along => {
            return Err(reader.error(format!("got axis xyz=\"{x} {y} {z}\", expected one that is not zero")));
        }
        None => Vec3::x(),
    };
    let stated = if has_limits { stated_limits(reader, node, kind, version)? } else { None };
    let limits = stated.map_or(Ok(None), |stated| limits(reader, (&name, kind), stated, warnings))?;
    // Propellers are often written as revolute with limits of 1e16, or infinite ones.
    let written = stated.filter(|_| {
        let limit = child(node, "limit");
        ["lower", "upper"].iter().all(|name| limit.is_some_and(|limit| own_attribute(limit, name).is_some()))
    });
    let turns_freely = kind == JointKind::Revolute && limits.is_none() && written.is_some();
    if let Some((lower, upper)) = written.filter(|_| turns_freely) {
        let ElementReader { file, element } = reader;
        warnings.push(format!("{file}: {element}: its limits {lower:e} and {upper:e} are taken for none: continuous"));
    }
    let kind = if turns_freely { JointKind::Continuous } else { kind };
    Ok(Joint { name, kind, parent, child: child_link, pose_parent_joint, axis, limits, mimic: None })
}

fn kind(reader: &ElementReader, name: &str) -> Result<JointKind> {
    Ok(match name {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "planar" => JointKind::Planar,
        "spherical" => JointKind::Spherical,
        "floating" => JointKind::Floating,
        _ => {
            let kinds = "fixed, revolute, continuous, prismatic, planar, spherical or floating";
            return Err(reader.error(format!("got type=\"{}\", expected {kinds}", quoted(name))));
        }
    })
}

/// Returns the limits that `<limit>` states; `None` if there are none.
fn stated_limits(reader: &ElementReader, node: Node, kind: JointKind, version: f64) -> Result<Option<(f64, f64)>> {
    let Some(limit) = child(node, "limit") else { return Ok(None) };
    let has = |name: &str| own_attribute(limit, name).is_some();
    match kind {
        JointKind::Fixed | JointKind::Continuous | JointKind::Spherical => return Ok(None),
        JointKind::Planar | JointKind::Floating if !(has("lower") && has("upper")) => return Ok(None),
        _ => {}
    }
    let unstated = if version < EXPLICIT_LIMITS_VERSION { 0.0 } else { f64::INFINITY };
    let value = |name: &str, unstated: f64| match own_attribute(limit, name) {
        // Some files say "no limit" with 1e16, others with infinity.
        Some(text) if text.trim().parse().is_ok_and(f64::is_infinite) => Ok(text.trim().parse().unwrap_or(unstated)),
        Some(text) => numbers_within::<1>(f64::MAX, reader.file, &reader.element, name, text).map(|[value]| value),
        None => Ok(unstated),
    };
    Ok(Some((value("lower", -unstated)?, value("upper", unstated)?)))
}

fn limits(
    reader: &ElementReader,
    (name, kind): (&str, JointKind),
    (lower, upper): (f64, f64),
    warnings: &mut Vec<String>,
) -> Result<Option<(f64, f64)>> {
    // Such limits bound nothing; the scene may set others.
    if lower < -FARTHEST && upper > FARTHEST {
        return Ok(None);
    }
    let expected = match (lower.is_finite() && upper.is_finite(), lower <= upper) {
        (false, _) => Some("`lower` and `upper`, both finite"),
        (_, false) => Some("lower <= upper"),
        _ => None,
    };
    if let Some(expected) = expected {
        let instead = format!("or `limits = {{ {name} = [lower, upper] }}` in its [[robot]] of the scene");
        return Err(reader.error(format!("got limits {lower} to {upper}, expected {expected}, {instead}")));
    }
    if lower == upper && kind != JointKind::Fixed {
        let ElementReader { file, element } = reader;
        warnings.push(format!("{file}: {element}: cannot move, its limits are {lower} and {upper}"));
    }
    Ok(Some((lower, upper)))
}

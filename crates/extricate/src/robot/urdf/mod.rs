//! Converts URDF to a [`Robot`]: collision shapes and joints. Skips visuals (unless they are
//! requested), inertias and plugins.
//!
//! Works on the XML tree itself: a file may contain anything that does not matter here, and every
//! message names the link or joint, the value and what was expected.

mod element_reader;
mod joints;
mod shapes;

use std::collections::HashMap;

use roxmltree::{Document, Node};

use super::formats::xml::{NEEDS_XACRO, child, children, document, label, numbers, own_attribute};
use super::link_tree::{resolve_mimics, root};
use super::{Link, LinkGeometry, LoadLimit, LoadLimits, Robot};
use crate::error::{Error, Result, listed, quoted};

use element_reader::ElementReader;
pub use element_reader::LoadMesh;

/// The elements that give a robot its shapes for collision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shapes {
    /// The shapes in `<collision>` elements.
    Collision,
    /// The shapes in `<visual>` elements.
    Visual,
}

impl Shapes {
    fn tag(self) -> &'static str {
        match self {
            Shapes::Collision => "collision",
            Shapes::Visual => "visual",
        }
    }
}

/// Parses URDF `text`; `file` is its name in messages. Warnings are appended to `warnings`.
///
/// Joint types are those of URDF and `spherical`. Geometries are those of URDF, `capsule` (its
/// length is that of the cylindrical part) and `plane` (the half-space below it). A mimic joint has
/// no limits of its own; if it follows a fixed joint, it stays at its offset. Soft limits
/// (`safety_controller`) are ignored. If `<limit>` lacks a lower or upper value, that is 0; from
/// URDF version 1.2 on, it is an error to state only one.
///
/// # Errors
/// [`Error::Input`], with the link or joint, the value and what was expected: text that is not
/// plain URDF, names that repeat or do not exist, links that are not one tree, invalid limits or
/// axes, negative sizes. Points and segments are left out, and plates and discs without thickness
/// get a micrometre, each with a warning.
pub fn parse(file: &str, text: &str, shapes: Shapes, load_mesh: LoadMesh, warnings: &mut Vec<String>) -> Result<Robot> {
    let wanted = Wanted { shapes, limits: &LoadLimits::default(), is_replaced: &|_| false };
    parse_within(file, text, &wanted, load_mesh, warnings)
}

/// Parts of a URDF to read, and limits on its size.
pub struct Wanted<'a> {
    /// The elements that give links their shapes.
    pub shapes: Shapes,
    /// How much the file may hold.
    pub limits: &'a LoadLimits,
    /// Whether a joint of this name gets its limits from elsewhere. Those of the file are then not
    /// read, since they may be invalid.
    pub is_replaced: &'a dyn Fn(&str) -> bool,
}

/// As [`parse`], but reads what is `wanted`.
///
/// # Errors
/// As [`parse`], and if the file holds more than is allowed.
pub fn parse_within(
    file: &str,
    text: &str,
    wanted: &Wanted,
    load_mesh: LoadMesh,
    warnings: &mut Vec<String>,
) -> Result<Robot> {
    let &Wanted { shapes, limits, is_replaced } = wanted;
    limits.check(LoadLimit::TextBytes, text.len(), file, "file")?;
    let text = super::formats::xml::with_declared_prefixes(file, text, limits)?;
    let document = document(file, &text, "URDF", limits)?;
    let robot = document.root_element();
    check_root(file, &document)?;
    let colours = if shapes == Shapes::Visual { named_colours(robot) } else { HashMap::new() };
    let mut links = Vec::new();
    let mut link_of_name = HashMap::new();
    let mut shape_count = 0;
    for node in children(robot, "link") {
        let reader = ElementReader { file, element: label(node) };
        let link = link(&reader, node, (shapes, &colours), load_mesh, warnings)?;
        shape_count += link.collision.len();
        limits.check(LoadLimit::NameBytes, link.name.len(), file, &reader.element)?;
        limits.check(LoadLimit::Links, links.len() + 1, file, "robot")?;
        limits.check(LoadLimit::Shapes, shape_count, file, "robot")?;
        if link_of_name.insert(link.name.clone(), links.len()).is_some() {
            return Err(reader.error("got a second link of this name, expected unique names"));
        }
        links.push(link);
    }
    warn_of_visuals(file, robot, shapes, warnings);
    let version = own_attribute(robot, "version").and_then(|version| version.trim().parse().ok()).unwrap_or(1.0);
    let (mut joints, mimics) = joints::joints(file, robot, (version, is_replaced), &link_of_name, warnings)?;
    for joint in &joints {
        limits.check(LoadLimit::NameBytes, joint.name.len(), file, "joint")?;
    }
    let root = root(file, &links, &joints)?;
    resolve_mimics(file, &mimics, &mut joints)?;
    let name = own_attribute(robot, "name").unwrap_or("robot");
    limits.check(LoadLimit::NameBytes, name.len(), file, "robot")?;
    Ok(Robot { name: name.into(), links, joints, root })
}

fn check_root(file: &str, document: &Document) -> Result<()> {
    let robot = document.root_element();
    match robot.tag_name().name() {
        "robot" => {}
        "mujoco" => return Err(Error::input(file, "root", IS_MJCF)),
        "sdf" => return Err(Error::input(file, "root", IS_SDF)),
        other => return Err(Error::input(file, "root", format!("got <{}>, expected <robot>", quoted(other)))),
    }
    let is_macro = |node: &Node| node.tag_name().namespace().is_some_and(|namespace| namespace.contains("xacro"));
    match robot.descendants().find(is_macro) {
        Some(node) => {
            let line = document.text_pos_at(node.range().start).row;
            Err(Error::input(file, format!("line {line}"), NEEDS_XACRO))
        }
        None => Ok(()),
    }
}

const IS_MJCF: &str = "got <mujoco>, expected <robot>: this is MJCF; in Python `extricate.Robot.from_mujoco(path)` takes it \
                       (pip install 'extricate[mujoco]')";
const IS_SDF: &str = "got <sdf>, expected <robot>: this is SDF; in Python `extricate.Robot.from_sdf(path)` takes it";

fn link(
    reader: &ElementReader,
    node: Node,
    (shapes, colours): (Shapes, &HashMap<&str, [f64; 4]>),
    load_mesh: LoadMesh,
    warnings: &mut Vec<String>,
) -> Result<Link> {
    let (file, element, tag) = (reader.file, &reader.element, shapes.tag());
    let name = reader.required(node, "name")?.to_owned();
    let mut collision = Vec::new();
    for part in children(node, tag) {
        let Some(shape) = child(part, "geometry").and_then(|g| g.children().find(Node::is_element)) else {
            warnings.push(format!("{file}: {element}: a <{tag}> without geometry is ignored"));
            continue;
        };
        let pose_link_geometry = reader.origin(part)?;
        if let Some(geometry) = shapes::geometry(reader, shape, load_mesh, warnings)? {
            let rgba = child(part, "material").and_then(|material| {
                own_colour(material).or_else(|| colours.get(own_attribute(material, "name")?).copied())
            });
            collision.push(LinkGeometry { pose_link_geometry, geometry, rgba });
        }
    }
    Ok(Link { name, collision })
}

/// Colours of materials by name. A material may be defined in the robot or in any `<visual>`, and
/// others use it by its name.
fn named_colours<'a>(robot: Node<'a, '_>) -> HashMap<&'a str, [f64; 4]> {
    let materials = robot.descendants().filter(|node| node.has_tag_name("material"));
    materials.filter_map(|material| Some((own_attribute(material, "name")?, own_colour(material)?))).collect()
}

/// The colour that a material states itself. No check depends on it, so an invalid one is none.
fn own_colour(material: Node) -> Option<[f64; 4]> {
    let text = own_attribute(child(material, "color")?, "rgba")?;
    let rgba: [f64; 4] = numbers("", "", "rgba", text).ok()?;
    rgba.iter().all(|x| (0.0..=1.0).contains(x)).then_some(rgba)
}

/// Warns of a robot that collides with nothing because all its shapes are visual.
fn warn_of_visuals(file: &str, robot: Node, shapes: Shapes, warnings: &mut Vec<String>) {
    let have = |tag: &'static str| children(robot, "link").filter(move |link| child(*link, tag).is_some());
    if shapes != Shapes::Collision || have("collision").next().is_some() {
        return;
    }
    let seen: Vec<&str> = have("visual").filter_map(|link| own_attribute(link, "name")).collect();
    if !seen.is_empty() {
        warnings.push(format!(
            "{file}: no link has <collision> geometry, so the robot collides with nothing; <visual> geometry ({}) is \
             taken with `geometry = \"visual\"`",
            listed(seen)
        ));
    }
}

#[cfg(test)]
mod tests;

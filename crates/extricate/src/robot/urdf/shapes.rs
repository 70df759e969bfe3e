//! Converts the `<geometry>` of a URDF to [`Geometry`]: checks sizes, warns of zero ones, loads
//! meshes.

use roxmltree::Node;

use super::element_reader::{ElementReader, LoadMesh};
use crate::error::{Result, quoted};
use crate::robot::Geometry;
use crate::robot::formats::xml::{child, numbers, own_attribute};
use crate::robot::mesh::is_scale;

/// Thickness \[m\] of a plate or disc that has none in the file: more than rounding, less than any
/// clearance in use.
const PLATE_THICKNESS_M: f64 = 1e-6;

/// Returns the shape of `node`, or `None`, with a warning, for a point or a segment: exporters
/// write those if nothing shall collide. A disc or plate without thickness gets
/// [`PLATE_THICKNESS_M`].
pub(crate) fn geometry(
    reader: &ElementReader,
    node: Node,
    load_mesh: LoadMesh,
    warnings: &mut Vec<String>,
) -> Result<Option<Geometry>> {
    let mut tell = |size: String, has_area: bool| {
        let taken = if has_area { format!("{PLATE_THICKNESS_M:e} m thick") } else { "none".into() };
        let ElementReader { file, element } = reader;
        warnings.push(format!("{file}: {element}: a collision geometry with {size} is taken for {taken}"));
    };
    let one = |name: &str| reader.numbers::<1>(node, name).map(|[size]| size);
    let positive = |name: &str, size: f64| match size > 0.0 {
        true => Ok(size),
        false => Err(reader.error(format!("got {name}=\"{size}\", expected a positive size [m]"))),
    };
    let is_zero = |sizes: &[f64]| sizes.contains(&0.0) && sizes.iter().all(|size| *size >= 0.0);
    Ok(Some(match node.tag_name().name() {
        "box" => {
            let sides = reader.numbers::<3>(node, "size")?;
            let [x, y, z] = sides;
            let size = format!("size=\"{x} {y} {z}\"");
            if !is_zero(&sides) && sides.iter().any(|side| *side <= 0.0) {
                return Err(reader.error(format!("got {size}, expected positive sizes [m]")));
            }
            if is_zero(&sides) {
                let has_area = sides.iter().filter(|side| **side == 0.0).count() == 1;
                tell(size, has_area);
                if !has_area {
                    return Ok(None);
                }
            }
            Geometry::Box { half_extents: sides.map(|side| 0.5 * side.max(PLATE_THICKNESS_M * f64::from(side == 0.0))) }
        }
        "sphere" => match one("radius")? {
            0.0 => {
                tell("radius=\"0\"".into(), false);
                return Ok(None);
            }
            radius => Geometry::Sphere { radius: positive("radius", radius)? },
        },
        tag @ ("cylinder" | "capsule") => {
            let (radius, mut length) = (one("radius")?, one("length")?);
            let size = format!("radius=\"{radius}\" length=\"{length}\"");
            if is_zero(&[radius, length]) && (radius == 0.0 || tag == "cylinder") {
                tell(size, radius > 0.0);
                if radius == 0.0 {
                    return Ok(None);
                }
                length = PLATE_THICKNESS_M;
            }
            let radius = positive("radius", radius)?;
            match tag {
                "cylinder" => Geometry::Cylinder { radius, half_length: 0.5 * positive("length", length)? },
                _ if length == 0.0 => Geometry::Sphere { radius },
                _ => Geometry::Capsule { radius, half_length: 0.5 * positive("length", length)? },
            }
        }
        "mesh" => mesh(reader, node, load_mesh)?,
        "plane" => plane(reader, node)?,
        tag => {
            let kinds = "box, sphere, cylinder, capsule, mesh or plane";
            return Err(reader.error(format!("got geometry <{}>, expected {kinds}", quoted(tag))));
        }
    }))
}

fn mesh(reader: &ElementReader, node: Node, load_mesh: LoadMesh) -> Result<Geometry> {
    let filename = reader.required(node, "filename")?;
    let scale = reader.numbers_or(Some(node), "scale", [1.0; 3])?;
    if !is_scale(&scale) {
        let problem = format!("got mesh scale {scale:?}, expected factors of size 1e-9 to 1e9, not zero");
        return Err(reader.error(problem));
    }
    Ok(Geometry::Mesh(load_mesh(filename, scale)?))
}

/// Returns the half-space below a plane through the origin. As in other readers, its normal is an
/// attribute or an element, and z by default; its size only matters for drawing.
fn plane(reader: &ElementReader, node: Node) -> Result<Geometry> {
    let text = own_attribute(node, "normal").or_else(|| child(node, "normal")?.text());
    let normal = match text {
        Some(text) => numbers::<3>(reader.file, &reader.element, "normal", &text.replace(',', " "))?,
        None => [0.0, 0.0, 1.0],
    };
    Geometry::half_space(reader.file, &reader.element, normal, 0.0)
}

//! COLLADA 1.4 and 1.5 to triangles: geometries, placed by the nodes of the scene, in metres.
//!
//! Node transforms and `<unit meter="...">` are applied, as RViz and Gazebo do (pinocchio and
//! MoveIt drop the unit along with assimp's root node). `<up_axis>` is not applied, as in all of
//! these: ROS files say `Y_UP` and mean z.
//!
//! An own reader, because no crate reads the 286 files of example-robot-data 6.0 (this one does,
//! with the bounding boxes that assimp gives). `dae-parser` 0.11 refuses 85 of them (68 are COLLADA
//! 1.5, 17 have no `<created>`), panics on one where an id repeats, and keeps `f32`. `mesh-loader`
//! 0.1.13 misplaces 3, puts nested nodes and geometries that are shown twice where they are not,
//! and panics on 3.6 % of files with one to three bytes changed.

use std::collections::HashMap;

use nalgebra::{Matrix4, Unit};
use roxmltree::Node;

use super::soup::Soup;
use super::xml::{child, children, document, label, numbers_or, own_attribute, required};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Nodes may be nested and instanced this deep; more is a cycle of `<instance_node>`.
const DEEPEST: usize = 64;

struct Reader<'a, 'i> {
    file: &'a str,
    by_id: HashMap<&'a str, Node<'a, 'i>>,
    soup: Soup,
}

/// Parses what the file's scene shows; where it shows nothing, all its geometries, unplaced.
pub(crate) fn parse(file: &str, bytes: &[u8]) -> Result<Soup> {
    let text = String::from_utf8_lossy(bytes);
    let document = document(file, &text, "COLLADA")?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(Error::input(file, "root", format!("got <{}>, expected <COLLADA>", root.tag_name().name())));
    }
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let [meter] = numbers_or(file, "unit", unit, "meter", [1.0])?;
    if meter <= 0.0 {
        return Err(Error::input(file, "unit", format!("got meter=\"{meter}\", expected a positive number")));
    }
    let by_id = root.descendants().filter_map(|node| Some((own_attribute(node, "id")?, node))).collect();
    let mut reader = Reader { file, by_id, soup: Soup::default() };
    let to_metres = Matrix4::new_scaling(meter);
    for instance in children(root, "scene").flat_map(|scene| children(scene, "instance_visual_scene")) {
        let scene = reader.target(instance, "url")?;
        for node in children(scene, "node") {
            reader.node(node, &to_metres, 0)?;
        }
    }
    if reader.soup.triangles.is_empty() {
        for geometry in children(root, "library_geometries").flat_map(|library| children(library, "geometry")) {
            reader.geometry(geometry, &to_metres)?;
        }
    }
    Ok(reader.soup)
}

impl<'a, 'i> Reader<'a, 'i> {
    fn error(&self, node: Node, problem: impl Into<String>) -> Error {
        Error::input(self.file, label(node), problem)
    }

    /// The element that an attribute such as `url="#id"` points to.
    fn target(&self, node: Node<'a, 'i>, attribute: &str) -> Result<Node<'a, 'i>> {
        // Labels take long where they tell the line.
        let url = match own_attribute(node, attribute) {
            Some(url) => url,
            None => required(self.file, &label(node), node, attribute)?,
        };
        url.strip_prefix('#')
            .and_then(|id| self.by_id.get(id).copied())
            .ok_or_else(|| self.error(node, format!("got {attribute}=\"{url}\", expected `#` and an id in this file")))
    }

    fn node(&mut self, node: Node<'a, 'i>, parent: &Matrix4<f64>, depth: usize) -> Result<()> {
        if depth > DEEPEST {
            return Err(self.error(node, format!("got nodes nested deeper than {DEEPEST}, expected no cycle")));
        }
        self.soup.enter_node().map_err(|problem| self.error(node, problem))?;
        let mut matrix = *parent;
        for element in node.children().filter(Node::is_element) {
            match element.tag_name().name() {
                "node" => self.node(element, &matrix, depth + 1)?,
                "instance_node" => self.node(self.target(element, "url")?, &matrix, depth + 1)?,
                "instance_geometry" => self.geometry(self.target(element, "url")?, &matrix)?,
                "instance_controller" => self.controller(self.target(element, "url")?, &matrix)?,
                // Transforms stand before all else and compose in document order.
                _ => matrix *= self.transform(element)?,
            }
        }
        Ok(())
    }

    /// A skinned geometry in its rest shape.
    fn controller(&mut self, controller: Node<'a, 'i>, matrix: &Matrix4<f64>) -> Result<()> {
        let Some(skin) = child(controller, "skin") else { return Ok(()) };
        let geometry = self.target(skin, "source")?;
        let shape = match child(skin, "bind_shape_matrix") {
            Some(element) => Matrix4::from_row_slice(&self.numbers(element, Some(16))?),
            None => Matrix4::identity(),
        };
        self.geometry(geometry, &(matrix * shape))
    }

    fn transform(&self, element: Node) -> Result<Matrix4<f64>> {
        let take = |count| self.numbers(element, Some(count));
        Ok(match element.tag_name().name() {
            "matrix" => Matrix4::from_row_slice(&take(16)?),
            "translate" => Matrix4::new_translation(&Vec3::from_row_slice(&take(3)?)),
            "scale" => Matrix4::new_nonuniform_scaling(&Vec3::from_row_slice(&take(3)?)),
            "rotate" => {
                let v = take(4)?;
                match Unit::try_new(Vec3::new(v[0], v[1], v[2]), 0.0) {
                    Some(axis) => nalgebra::Rotation3::from_axis_angle(&axis, v[3].to_radians()).to_homogeneous(),
                    None => Matrix4::identity(),
                }
            }
            tag @ ("lookat" | "skew") => {
                return Err(self.error(element, format!("got <{tag}>, expected matrix, translate, rotate or scale")));
            }
            _ => Matrix4::identity(),
        })
    }

    fn geometry(&mut self, geometry: Node<'a, 'i>, matrix: &Matrix4<f64>) -> Result<()> {
        let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
        for element in mesh.children().filter(Node::is_element) {
            if matches!(element.tag_name().name(), "triangles" | "polylist" | "polygons" | "trifans" | "tristrips") {
                self.primitive(element, matrix)?;
            }
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: Node<'a, 'i>, matrix: &Matrix4<f64>) -> Result<()> {
        let mut stride = 1;
        let mut vertex = None;
        for input in children(primitive, "input") {
            let offset = self.whole(Some(input), "offset", 0.0)?;
            stride = stride.max(offset + 1);
            if own_attribute(input, "semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        // Exporters write primitives without anything in them.
        let Some((input, offset)) = vertex else { return Ok(()) };
        let first = self.soup.vertices.len() as u32;
        let positions = self.positions(self.target(input, "source")?)?;
        let count = positions.len();
        let place = |p: Vec3| matrix.fixed_view::<3, 3>(0, 0) * p + matrix.fixed_view::<3, 1>(0, 3);
        self.soup.vertices.extend(positions.into_iter().map(place));
        let from = self.soup.triangles.len();
        self.faces(primitive, (stride, offset), (first, count))?;
        // What a node mirrors faces the same way as before only if it is wound the other way.
        if matrix.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            self.soup.triangles[from..].iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(())
    }

    /// The faces of a primitive: `count` vertices begin at `first`; an index of them stands at
    /// `offset` of every `stride` numbers.
    fn faces(
        &mut self,
        primitive: Node<'a, 'i>,
        (stride, offset): (usize, usize),
        (first, count): (u32, usize),
    ) -> Result<()> {
        let tag = primitive.tag_name().name();
        let corners_of = |list: Node| -> Result<Vec<u32>> {
            let mut corners = Vec::new();
            for index in self.numbers(list, None)?.into_iter().skip(offset).step_by(stride) {
                if !(0.0..count as f64).contains(&index) {
                    return Err(self.error(primitive, format!("got index {index}, expected one of {count} vertices")));
                }
                corners.push(first + index as u32);
            }
            Ok(corners)
        };
        let mut lists = Vec::new();
        for list in primitive.children().filter(Node::is_element) {
            match list.tag_name().name() {
                "p" => lists.push(vec![corners_of(list)?]),
                // A polygon with holes: its outline is in <p>, each hole in <h>.
                "ph" => {
                    let rings = children(list, "p").chain(children(list, "h"));
                    lists.push(rings.map(corners_of).collect::<Result<_>>()?);
                }
                _ => {}
            }
        }
        let counts = match child(primitive, "vcount") {
            Some(element) => self.numbers(element, None)?.into_iter().map(|x| x as u32 as usize).collect(),
            None => Vec::new(),
        };
        let place = label(primitive);
        let mut faces = 0;
        for rings in &lists {
            let [corners, holes @ ..] = &rings[..] else { continue };
            match tag {
                "trifans" => self.soup.push_fan(corners),
                "tristrips" => self.soup.push_strip(corners),
                "polygons" => {
                    let rings: Vec<&[u32]> = std::iter::once(corners).chain(holes).map(Vec::as_slice).collect();
                    faces += 1;
                    self.soup.push_face(&rings, || format!("{place}: face {faces}"));
                }
                _ => {
                    let sizes = if tag == "triangles" { vec![3; corners.len().div_ceil(3)] } else { counts.clone() };
                    if sizes.iter().sum::<usize>() != corners.len() {
                        let problem =
                            format!("got {} corners, expected {}", corners.len(), sizes.iter().sum::<usize>());
                        return Err(self.error(primitive, problem));
                    }
                    let mut rest = &corners[..];
                    for size in sizes {
                        let (polygon, tail) = rest.split_at(size);
                        faces += 1;
                        self.soup.push_face(&[polygon], || format!("{place}: face {faces}"));
                        rest = tail;
                    }
                }
            }
        }
        Ok(())
    }

    /// The points of a `<vertices>` element.
    fn positions(&self, vertices: Node<'a, 'i>) -> Result<Vec<Vec3>> {
        let input = children(vertices, "input").find(|input| own_attribute(*input, "semantic") == Some("POSITION"));
        let input = input.ok_or_else(|| self.error(vertices, "got no POSITION input, expected one"))?;
        let source = self.target(input, "source")?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let (stride, offset) = (self.whole(accessor, "stride", 3.0)?, self.whole(accessor, "offset", 0.0)?);
        let array = match accessor {
            Some(accessor) => self.target(accessor, "source")?,
            None => child(source, "float_array").ok_or_else(|| self.error(source, "got no array, expected one"))?,
        };
        let values = self.numbers(array, None)?;
        if stride < 3 {
            return Err(self.error(source, format!("got stride {stride}, expected at least 3")));
        }
        let values = values.get(offset..).unwrap_or(&[]);
        Ok(values.chunks(stride).filter(|p| p.len() >= 3).map(|p| Vec3::new(p[0], p[1], p[2])).collect())
    }

    /// A small whole number in an attribute, or `default`.
    fn whole(&self, element: Option<Node>, attribute: &str, default: f64) -> Result<usize> {
        let place = element.map_or("accessor".into(), label);
        let [value] = numbers_or(self.file, &place, element, attribute, [default])?;
        if !(0.0..1e6).contains(&value) {
            let problem = format!("got {attribute}=\"{value}\", expected a small whole number");
            return Err(Error::input(self.file, place, problem));
        }
        Ok(value as usize)
    }

    /// The numbers in an element's text, `count` of them where that is given.
    fn numbers(&self, element: Node, count: Option<usize>) -> Result<Vec<f64>> {
        let text = element.text().unwrap_or("");
        let mut values = Vec::with_capacity(text.len() / 8);
        for word in text.split_whitespace() {
            values.push(word.parse().map_err(|_| self.error(element, format!("got `{word}`, expected a number")))?);
        }
        match count {
            Some(count) if count != values.len() => {
                Err(self.error(element, format!("got {} numbers, expected {count}", values.len())))
            }
            _ => Ok(values),
        }
    }
}

#[cfg(test)]
mod tests;

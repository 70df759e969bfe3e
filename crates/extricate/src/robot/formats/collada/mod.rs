//! Reads COLLADA 1.4 and 1.5: geometries, placed by the nodes of the scene, in metres.
//!
//! Node transforms and `<unit meter="...">` are applied, as RViz and Gazebo do (pinocchio and
//! MoveIt drop the unit along with assimp's root node). `<up_axis>` is not applied, as in all of
//! these: ROS files say `Y_UP` and mean z.
//!
//! This reader exists because no crate reads all 286 files of example-robot-data 6.0, as it does,
//! with the bounding boxes of assimp. `dae-parser` 0.11 refuses 85 of them (68 are COLLADA 1.5, 17
//! have no `<created>`), panics on one that repeats an id, and keeps `f32`. `mesh-loader` 0.1.13
//! misplaces 3 of them, nested nodes, and geometries that are shown twice. It panics on 3.6 % of
//! files with one to three bytes changed.

use std::collections::HashMap;
use std::rc::Rc;

use nalgebra::{Matrix4, Unit};
use roxmltree::{Node, NodeId};

use super::soup::Soup;
use super::xml::{child, children, document, label, numbers_or, own_attribute, required};
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::LoadLimits;

/// Largest depth of nested and instanced nodes; more is a cycle of `<instance_node>`.
const MAX_NODE_DEPTH: usize = 64;
/// Bytes of text that take as long as one node.
const TEXT_BYTES_PER_NODE: usize = 256;

struct Reader<'a, 'i> {
    file: &'a str,
    limits: &'a LoadLimits,
    by_id: HashMap<&'a str, Node<'a, 'i>>,
    /// Geometries in their own coordinates; nodes may show one any number of times.
    geometries: HashMap<NodeId, Rc<Soup>>,
    /// Geometry that each controller shows, and its matrix.
    controllers: HashMap<NodeId, Option<(Node<'a, 'i>, Matrix4<f64>)>>,
    /// Numbers of arrays, which many primitives may share.
    arrays: HashMap<NodeId, Rc<Vec<f64>>>,
    soup: Soup,
}

/// Parses what the file's scene shows; if that is nothing, all geometries, unplaced.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Soup> {
    let text = String::from_utf8_lossy(bytes);
    let document = document(file, &text, "COLLADA", limits)?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(Error::input(
            file,
            "root",
            format!("got <{}>, expected <COLLADA>", quoted(root.tag_name().name())),
        ));
    }
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let [meter] = numbers_or(file, "unit", unit, "meter", [1.0])?;
    if meter <= 0.0 {
        return Err(Error::input(file, "unit", format!("got meter=\"{meter}\", expected a positive number")));
    }
    let by_id = root.descendants().filter_map(|node| Some((own_attribute(node, "id")?, node))).collect();
    let (geometries, controllers, arrays) = Default::default();
    let mut reader =
        Reader { file, limits, by_id, geometries, controllers, arrays, soup: Soup::shown(limits, bytes.len()) };
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
        // A label without a name scans the file for its line, so it is only made for messages.
        let url = match own_attribute(node, attribute) {
            Some(url) => url,
            None => required(self.file, &label(node), node, attribute)?,
        };
        url.strip_prefix('#').and_then(|id| self.by_id.get(id).copied()).ok_or_else(|| {
            self.error(node, format!("got {attribute}=\"{}\", expected `#` and an id in this file", quoted(url)))
        })
    }

    fn node(&mut self, node: Node<'a, 'i>, parent: &Matrix4<f64>, depth: usize) -> Result<()> {
        if depth > MAX_NODE_DEPTH {
            return Err(self.error(node, format!("got nodes nested deeper than {MAX_NODE_DEPTH}, expected no cycle")));
        }
        self.soup.enter_node().map_err(|problem| self.error(node, problem))?;
        let mut matrix = *parent;
        for element in node.children() {
            // Each instance of a node is visited again, with everything in it.
            let cost = 1 + element.text().map_or(0, str::len) / TEXT_BYTES_PER_NODE;
            self.soup.enter_nodes(cost).map_err(|problem| self.error(node, problem))?;
            if !element.is_element() {
                continue;
            }
            match element.tag_name().name() {
                "node" => self.node(element, &matrix, depth + 1)?,
                "instance_node" => self.node(self.target(element, "url")?, &matrix, depth + 1)?,
                "instance_geometry" => self.geometry(self.target(element, "url")?, &matrix)?,
                "instance_controller" => self.controller(self.target(element, "url")?, &matrix)?,
                // Transforms come before all else and compose in document order.
                _ => matrix *= self.transform(element)?,
            }
        }
        Ok(())
    }

    /// Adds a skinned geometry in its rest shape.
    fn controller(&mut self, controller: Node<'a, 'i>, matrix: &Matrix4<f64>) -> Result<()> {
        let shown = match self.controllers.get(&controller.id()) {
            Some(known) => *known,
            None => {
                let shown = self.skin(controller)?;
                self.controllers.insert(controller.id(), shown);
                shown
            }
        };
        shown.map_or(Ok(()), |(geometry, shape)| self.geometry(geometry, &(matrix * shape)))
    }

    fn skin(&self, controller: Node<'a, 'i>) -> Result<Option<(Node<'a, 'i>, Matrix4<f64>)>> {
        let Some(skin) = child(controller, "skin") else { return Ok(None) };
        let geometry = self.target(skin, "source")?;
        let shape = match child(skin, "bind_shape_matrix") {
            Some(element) => Matrix4::from_row_slice(&self.numbers(element, Some(16))?),
            None => Matrix4::identity(),
        };
        Ok(Some((geometry, shape)))
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

    /// Adds a geometry, placed by `matrix`.
    fn geometry(&mut self, geometry: Node<'a, 'i>, matrix: &Matrix4<f64>) -> Result<()> {
        let local = match self.geometries.get(&geometry.id()) {
            Some(known) => Rc::clone(known),
            None => {
                let local = Rc::new(self.local(geometry)?);
                self.soup.faults.extend(local.told());
                self.geometries.insert(geometry.id(), Rc::clone(&local));
                local
            }
        };
        let linear = matrix.fixed_view::<3, 3>(0, 0);
        let place = |p: &Vec3| linear * p + matrix.fixed_view::<3, 1>(0, 3);
        // Mirroring reverses the side that a triangle faces, so its winding is reversed too.
        let mirrored = linear.determinant() < 0.0;
        self.soup.add(&local, place, mirrored).map_err(|problem| self.error(geometry, problem))
    }

    /// Reads a geometry in its own coordinates.
    fn local(&mut self, geometry: Node<'a, 'i>) -> Result<Soup> {
        let mut local = Local { soup: Soup::new(self.limits), known: HashMap::new() };
        let Some(mesh) = child(geometry, "mesh") else { return Ok(local.soup) };
        for element in mesh.children().filter(Node::is_element) {
            if matches!(element.tag_name().name(), "triangles" | "polylist" | "polygons" | "trifans" | "tristrips") {
                self.primitive(element, &mut local)?;
            }
        }
        Ok(local.soup)
    }

    fn primitive(&mut self, primitive: Node<'a, 'i>, local: &mut Local) -> Result<()> {
        let mut stride = 1;
        let mut vertex = None;
        for input in children(primitive, "input") {
            let offset = self.whole(Some(input), "offset", 0)?;
            stride = stride.max(offset + 1);
            if own_attribute(input, "semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        // Exporters write empty primitives too.
        let Some((input, offset)) = vertex else { return Ok(()) };
        let vertices = self.target(input, "source")?;
        let points = self.points(vertices)?;
        let mut lists = Vec::new();
        let mut corners_of = |list: Node| self.corners(list, (stride, offset), vertices.id(), &points, local);
        for list in primitive.children().filter(Node::is_element) {
            match list.tag_name().name() {
                "p" => lists.push(vec![corners_of(list)?]),
                // A polygon with holes: its outline is in <p>, each hole in <h>.
                "ph" => {
                    let rings = children(list, "p").chain(children(list, "h"));
                    lists.push(rings.map(&mut corners_of).collect::<Result<_>>()?);
                }
                _ => {}
            }
        }
        self.faces(primitive, &lists, &mut local.soup)
    }

    /// Reads the corners in `list` as indices into the soup of `local`, to which it adds the points
    /// that are used. In every `stride` numbers, the one at `offset` is an index of `points`.
    fn corners(
        &self,
        list: Node,
        (stride, offset): (usize, usize),
        vertices: NodeId,
        points: &Points,
        local: &mut Local,
    ) -> Result<Vec<u32>> {
        let mut corners = Vec::new();
        for index in self.numbers(list, None)?.into_iter().skip(offset).step_by(stride) {
            if !(0.0..points.count as f64).contains(&index) || index.fract() != 0.0 {
                let problem = format!("got index {index}, expected one of {} vertices", points.count);
                return Err(self.error(list, problem));
            }
            let Local { soup, known } = &mut *local;
            corners.push(*known.entry((vertices, index as u32)).or_insert_with(|| {
                soup.vertices.push(points.at(index as usize));
                soup.vertices.len() as u32 - 1
            }));
        }
        local.soup.has_room(0, corners.len() / 3).map_err(|problem| self.error(list, problem))?;
        Ok(corners)
    }

    /// Adds the faces of a primitive, from its lists of corners.
    fn faces(&self, primitive: Node<'a, 'i>, lists: &[Vec<Vec<u32>>], soup: &mut Soup) -> Result<()> {
        let tag = primitive.tag_name().name();
        let sizes = match child(primitive, "vcount") {
            Some(element) if tag == "polylist" => self.counts(element)?,
            _ => Vec::new(),
        };
        // Each list would be divided by all the sizes.
        if tag == "polylist" && lists.len() > 1 {
            return Err(self.error(primitive, format!("got {} lists of corners, expected one <p>", lists.len())));
        }
        let mut faces = 0;
        let mut face = |soup: &mut Soup, rings: &[&[u32]]| {
            faces += 1;
            soup.push_face(rings, || format!("{}: face {faces}", label(primitive)));
        };
        for rings in lists {
            let [corners, ..] = &rings[..] else { continue };
            match tag {
                "trifans" => soup.push_fan(corners),
                "tristrips" => soup.push_strip(corners),
                "polygons" => face(soup, &rings.iter().map(Vec::as_slice).collect::<Vec<_>>()),
                _ => {
                    let expected = if tag == "triangles" { 3 * corners.len().div_ceil(3) } else { sizes.iter().sum() };
                    if expected != corners.len() {
                        let problem = format!("got {} corners, expected {expected}", corners.len());
                        return Err(self.error(primitive, problem));
                    }
                    let mut rest = &corners[..];
                    let mut sizes = sizes.iter().copied();
                    while !rest.is_empty() {
                        let size = if tag == "triangles" { 3 } else { sizes.next().unwrap_or(rest.len()) };
                        let (polygon, tail) = rest.split_at(size);
                        face(soup, &[polygon]);
                        rest = tail;
                    }
                }
            }
        }
        Ok(())
    }

    /// Reads how many corners each face has.
    fn counts(&self, element: Node) -> Result<Vec<usize>> {
        let count = |count: f64| match (0.0..=f64::from(u32::MAX)).contains(&count) && count.fract() == 0.0 {
            true => Ok(count as usize),
            false => Err(self.error(element, format!("got {count}, expected whole numbers of corners"))),
        };
        self.numbers(element, None)?.into_iter().map(count).collect()
    }

    /// Reads the points of a `<vertices>` element.
    fn points(&mut self, vertices: Node<'a, 'i>) -> Result<Points> {
        let input = children(vertices, "input").find(|input| own_attribute(*input, "semantic") == Some("POSITION"));
        let input = input.ok_or_else(|| self.error(vertices, "got no POSITION input, expected one"))?;
        let source = self.target(input, "source")?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let (stride, offset) = (self.whole(accessor, "stride", 3)?, self.whole(accessor, "offset", 0)?);
        let array = match accessor {
            Some(accessor) => self.target(accessor, "source")?,
            None => child(source, "float_array").ok_or_else(|| self.error(source, "got no array, expected one"))?,
        };
        if stride < 3 {
            return Err(self.error(source, format!("got stride {stride}, expected at least 3")));
        }
        let values = match self.arrays.get(&array.id()) {
            Some(known) => Rc::clone(known),
            None => {
                let values = Rc::new(self.numbers(array, None)?);
                self.arrays.insert(array.id(), Rc::clone(&values));
                values
            }
        };
        let rest = values.len().saturating_sub(offset);
        // The last point may lack the numbers between two points.
        let count = rest / stride + usize::from(rest % stride >= 3);
        Ok(Points { values, stride, offset, count })
    }

    /// Reads a small whole number from an attribute, or returns `default` if it is missing.
    fn whole(&self, element: Option<Node>, attribute: &str, default: usize) -> Result<usize> {
        let Some(element) = element else { return Ok(default) };
        let Some(text) = own_attribute(element, attribute) else { return Ok(default) };
        text.trim().parse().ok().filter(|value| *value < 1_000_000).ok_or_else(|| {
            self.error(element, format!("got {attribute}=\"{}\", expected a small whole number", quoted(text)))
        })
    }

    /// Reads the numbers in an element's text, which have to be `count` if that is given.
    fn numbers(&self, element: Node, count: Option<usize>) -> Result<Vec<f64>> {
        let text = element.text().unwrap_or("");
        let mut values = Vec::with_capacity(text.len() / 8);
        for word in text.split_whitespace() {
            values.push(
                word.parse().map_err(|_| self.error(element, format!("got `{}`, expected a number", quoted(word))))?,
            );
        }
        match count {
            Some(count) if count != values.len() => {
                Err(self.error(element, format!("got {} numbers, expected {count}", values.len())))
            }
            _ => Ok(values),
        }
    }
}

/// Points, each the first three of `stride` numbers.
struct Points {
    values: Rc<Vec<f64>>,
    stride: usize,
    offset: usize,
    count: usize,
}

impl Points {
    fn at(&self, index: usize) -> Vec3 {
        Vec3::from_column_slice(&self.values[self.offset + index * self.stride..][..3])
    }
}

/// A geometry in its own coordinates.
struct Local {
    soup: Soup,
    /// Index in `soup` of each point that is used, by `<vertices>` element and index there.
    known: HashMap<(NodeId, u32), u32>,
}

#[cfg(test)]
mod tests;

//! Reads PLY through `ply_rs_bw`: ASCII, and binary of both byte orders. Skips colours, normals and
//! confidences.

use std::io::BufReader;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::soup::Soup;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits};

type Source<'a> = Reader<BufReader<&'a [u8]>>;

#[derive(Default)]
struct Contents {
    vertices: Vec<Vec3>,
    /// Corners of each face or strip, by element; true for faces.
    rows: Vec<(bool, Vec<Indices>)>,
}

/// Parses vertices, faces and triangle strips.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Soup> {
    let mut source = Reader::new(BufReader::new(bytes));
    let header = header(file, &mut source)?;
    let count = |name: &str| header.elements.get(name).map_or(0, |element| element.count);
    if count("vertex") > 0 && count("face") == 0 && count("tristrips") == 0 {
        let problem = "got points without faces, expected triangles; an obstacle takes such a file as `points`, in place of \
                       `mesh`";
        return Err(Error::input(file, "face", problem));
    }
    let Contents { vertices, rows } = contents(file, (&mut source, &header), bytes.len(), limits)?;
    let mut soup = Soup::new(limits);
    soup.vertices = vertices;
    for (are_faces, rows) in rows {
        for (number, Indices(row)) in rows.into_iter().enumerate() {
            let corners = corners(file, number, &row, soup.vertices.len(), are_faces)?;
            if are_faces {
                soup.push_face(&[&corners], || format!("face {number}"));
            } else {
                corners.split(|&corner| corner == END_OF_STRIP).for_each(|strip| soup.push_strip(strip));
            }
        }
    }
    Ok(soup)
}

/// Parses the vertices \[m\] of a file, whatever faces it has; some may be NaN.
pub(crate) fn points(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Vec<Vec3>> {
    let mut source = Reader::new(BufReader::new(bytes));
    let header = header(file, &mut source)?;
    if header.elements.get("vertex").is_none() {
        return Err(Error::input(file, "header", "got no element vertex, expected one with x, y, z"));
    }
    if header.encoding == Encoding::Ascii {
        return ascii_points(file, bytes, &header, limits);
    }
    Ok(contents(file, (&mut source, &header), bytes.len(), limits)?.vertices)
}

/// As [`points`], for an ASCII file, in which `ply_rs_bw` takes no NaN.
fn ascii_points(file: &str, bytes: &[u8], header: &Header, limits: &LoadLimits) -> Result<Vec<Vec3>> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(str::trim).zip(1..).skip_while(|(line, _)| *line != "end_header").skip(1);
    let mut next = || lines.find(|(line, _)| !line.is_empty());
    let mut points = Vec::new();
    for element in header.elements.values() {
        check_element(file, element, bytes.len(), limits)?;
        for row in 0..if element.properties.is_empty() { 0 } else { element.count } {
            let Some((line, number)) = next() else {
                let problem = format!("got {row} of {}, expected {}", quoted(&element.name), element.count);
                return Err(Error::input(file, "end of the file", problem));
            };
            if element.name == "vertex" {
                let wrong = || {
                    let problem = format!("got `{}`, expected a vertex as the header has it", quoted(line));
                    Error::input(file, format!("line {number}"), problem)
                };
                points.push(ascii_point(line, element).ok_or_else(wrong)?);
            }
        }
    }
    Ok(points)
}

/// Parses a vertex; `None` if the line does not hold what the header says.
fn ascii_point(line: &str, vertex: &ElementDef) -> Option<Vec3> {
    let mut words = line.split_whitespace();
    let mut point = Vec3::zeros();
    for (name, property) in &vertex.properties {
        let word = words.next()?;
        if let PropertyType::List(..) = property.data_type {
            let count: usize = word.parse().ok()?;
            for _ in 0..count {
                words.next()?;
            }
        } else if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
            point[axis] = word.parse().ok()?;
        }
    }
    words.next().is_none().then_some(point)
}

fn header(file: &str, source: &mut Source) -> Result<Header> {
    Parser::<Vertex>::new().read_header(source).map_err(|error| explain(file, "header", &error))
}

/// Reads what comes after the header in a file of so many bytes.
fn contents(
    file: &str,
    (source, header): (&mut Source, &Header),
    bytes: usize,
    limits: &LoadLimits,
) -> Result<Contents> {
    let mut contents = Contents::default();
    for element in header.elements.values() {
        check_element(file, element, bytes, limits)?;
        match element.name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = elements(file, source, element, header)?;
                contents.vertices.extend(vertices.iter().map(|vertex| Vec3::from(vertex.0)));
            }
            kind @ ("face" | "tristrips") => {
                let found: Vec<Indices> = elements(file, source, element, header)?;
                contents.rows.push((kind == "face", found));
            }
            _ => drop(elements::<Skipped>(file, source, element, header)?),
        }
    }
    Ok(contents)
}

/// Refuses vertices without coordinates, and more elements than the file has bytes: those without a
/// property take none, however many there are.
fn check_element(file: &str, element: &ElementDef, bytes: usize, limits: &LoadLimits) -> Result<()> {
    let name = quoted(&element.name);
    let limit = if element.name == "vertex" { LoadLimit::Vertices } else { LoadLimit::Triangles };
    limits.check(limit, element.count, file, &format!("header: element {name}"))?;
    if element.count > bytes {
        let problem = format!("got {} of {name} in {bytes} bytes, expected as many as there are", element.count);
        return Err(Error::input(file, "header", problem));
    }
    let lacks = |name: &&str| element.name == "vertex" && element.properties.get(*name).is_none();
    match ["x", "y", "z"].into_iter().find(lacks) {
        Some(name) => Err(Error::input(file, "header", format!("got vertices without `{name}`, expected x, y, z"))),
        None => Ok(()),
    }
}

/// Stands for the index -1, which ends a strip.
const END_OF_STRIP: u32 = u32::MAX;

fn corners(file: &str, number: usize, row: &[i64], count: usize, are_faces: bool) -> Result<Vec<u32>> {
    let corner = |&index: &i64| match u32::try_from(index) {
        Ok(corner) if (corner as usize) < count => Ok(corner),
        _ if index == -1 && !are_faces => Ok(END_OF_STRIP),
        _ => {
            let place = format!("{} {number}", if are_faces { "face" } else { "strip" });
            Err(Error::input(file, place, format!("got index {index}, expected one of the {count} vertices")))
        }
    };
    row.iter().map(corner).collect()
}

fn elements<E: PropertyAccess>(
    file: &str,
    source: &mut Source,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>> {
    let read = Parser::<E>::new().read_payload_for_element(source, element, header);
    read.map_err(|error| explain(file, &format!("{} {}s", element.count, quoted(&element.name)), &error))
}

fn explain(file: &str, what: &str, error: &ParseError) -> Error {
    // The error's text spans several lines, and a message is one.
    let told = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    Error::input(file, what, format!("got what is no PLY ({}), expected it as the header has it", quoted(&told)))
}

#[derive(Default)]
struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match property {
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The corners of a face or a strip.
#[derive(Default)]
struct Indices(Vec<i64>);

impl PropertyAccess for Indices {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element whose properties are ignored.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests {
    use crate::math::Vec3;
    use crate::robot::LoadLimits;
    use crate::robot::formats::parse;

    const HEADER: &str = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        element camera 1\nproperty float view\nelement face 5\nproperty list uchar int vertex_indices\n\
        property float quality\nend_header\n";
    /// A pyramid on a square.
    const VERTICES: [[f32; 3]; 5] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.]];
    const FACES: [&[i32]; 5] = [&[3, 2, 1, 0], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];

    fn ascii() -> String {
        let vertices = VERTICES.map(|[x, y, z]| format!("{x} {y} {z} 255\n")).concat();
        let face = |face: &[i32]| {
            let indices: Vec<String> = face.iter().map(i32::to_string).collect();
            format!("{} {} 0.5\n", face.len(), indices.join(" "))
        };
        format!("ply\nformat ascii 1.0\ncomment made here\n{HEADER}{vertices}0.25\n{}", FACES.map(face).concat())
    }

    fn binary(order: &str, f32_bytes: fn(f32) -> [u8; 4], i32_bytes: fn(i32) -> [u8; 4]) -> Vec<u8> {
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").into_bytes();
        for vertex in VERTICES {
            vertex.iter().for_each(|&x| bytes.extend(f32_bytes(x)));
            bytes.push(255);
        }
        bytes.extend(f32_bytes(0.25));
        for face in FACES {
            bytes.push(face.len() as u8);
            face.iter().for_each(|&index| bytes.extend(i32_bytes(index)));
            bytes.extend(f32_bytes(0.5));
        }
        bytes
    }

    #[test]
    fn all_encodings_give_the_same_mesh() {
        let mesh = parse("a.ply", ascii().as_bytes()).unwrap();
        assert!(mesh.is_closed() && mesh.vertices.len() == 5 && mesh.triangles.len() == 6);
        for bytes in [
            binary("little", f32::to_le_bytes, i32::to_le_bytes),
            binary("big", f32::to_be_bytes, i32::to_be_bytes),
            ascii().replace('\n', "\r\n").into_bytes(),
            ascii().replace("vertex_indices", "vertex_index").replace("float x", "double x").into_bytes(),
            ascii().replace("list uchar int", "list uint8 uint16").replace("float", "float32").into_bytes(),
        ] {
            assert_eq!(parse("A.PLY", &bytes).unwrap(), mesh, "{}", String::from_utf8_lossy(&bytes[..60]));
        }
    }

    #[test]
    fn files_without_faces_are_points() {
        let header = |format: &str, more: &str| {
            format!(
                "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 property uchar red\n{more}end_header\n"
            )
        };
        let cloud: [[f32; 3]; 3] = [[0., 0., 0.], [f32::NAN; 3], [1., -2., 0.5]];
        let binary = |order: &str, bytes: fn(f32) -> [u8; 4]| {
            let mut file = header(&format!("binary_{order}_endian"), "").into_bytes();
            cloud.iter().for_each(|point| {
                point.iter().for_each(|x| file.extend(bytes(*x)));
                file.push(9);
            });
            file
        };
        let no_faces = "element face 0\nproperty list uchar int vertex_indices\n";
        let ascii = |more: &str| (header("ascii", more) + "0 0 0 1\nnan nan nan 1\n1 -2 0.5 1\n").into_bytes();
        for bytes in [ascii(""), ascii(no_faces), binary("little", f32::to_le_bytes), binary("big", f32::to_be_bytes)] {
            let points = super::points("a.ply", &bytes, &LoadLimits::default()).unwrap();
            assert!(points.len() == 3 && points[1].x.is_nan() && points[2] == Vec3::new(1.0, -2.0, 0.5), "{points:?}");
            assert!(parse("a.ply", &bytes).unwrap_err().to_string().contains("takes such a file as `points`"));
            // A number that lacks a digit is still one, and the last line may lack its end.
            for length in 0..bytes.len() - 2 {
                assert!(super::points("a.ply", &bytes[..length], &LoadLimits::default()).is_err(), "{length}");
            }
            for at in 0..bytes.len() {
                let mut spoiled = bytes.clone();
                spoiled[at] = spoiled[at].wrapping_mul(31).wrapping_add(17);
                let _ = super::points("a.ply", &spoiled, &LoadLimits::default());
            }
        }
        let none = "ply\nformat ascii 1.0\nend_header\n";
        let message = super::points("a.ply", none.as_bytes(), &LoadLimits::default()).unwrap_err().to_string();
        assert!(message.contains("got no element vertex"), "{message}");
    }

    #[test]
    fn strips_are_triangles() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n\
            8 0 1 2 3 -1 0 1 2\n";
        assert_eq!(parse("a.ply", text.as_bytes()).unwrap().triangles.len(), 2, "repeated ones are one");
    }

    #[test]
    fn faults_are_named() {
        let message = |text: String| parse("a.ply", text.as_bytes()).unwrap_err().to_string();
        let index = message(ascii().replace("3 2 1 0", "3 2 1 9"));
        assert_eq!(index, "a.ply: face 0: got index 9, expected one of the 5 vertices");
        assert!(message(ascii().replace("3 2 1 0", "3 2 1 -1")).contains("got index -1"));
        assert!(message(ascii().replace("float x", "float u")).contains("header: got vertices without `x`"));
        assert!(
            message(ascii().replace("0.5 0.5 1", "0.5 half 1")).contains("a.ply: 5 vertexs: got what is no PLY (Line")
        );
        assert!(message("solid".into()).contains("a.ply: header: got what is no PLY"));
        let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
            end_header\n0 0 0\n";
        assert!(message(cloud.into()).contains("got points without faces"));
        let huge = ascii().replace("vertex 5", "vertex 4000000000");
        assert!(message(huge).contains("element vertex: got 4000000000 corners"));
    }

    #[test]
    fn what_is_cut_or_spoiled_never_panics() {
        for bytes in [ascii().into_bytes(), binary("little", f32::to_le_bytes, i32::to_le_bytes)] {
            for length in 0..bytes.len() - 1 {
                let _ = parse("a.ply", &bytes[..length]);
                let mut spoiled = bytes.clone();
                spoiled[length] = spoiled[length].wrapping_mul(31).wrapping_add(17);
                let _ = parse("a.ply", &spoiled);
            }
            assert!(parse("a.ply", &bytes[..bytes.len() - 8]).is_err());
        }
    }
}

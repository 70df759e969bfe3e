//! PLY to triangles, through `ply_rs_bw`: ASCII, and binary of both byte orders. Colours, normals
//! and confidences are skipped.

use std::io::BufReader;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};

use super::soup::Soup;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits};

type Source<'a> = Reader<BufReader<&'a [u8]>>;

/// Parses vertices, faces and triangle strips.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Soup> {
    let mut source = Reader::new(BufReader::new(bytes));
    let header = Parser::<Vertex>::new().read_header(&mut source).map_err(|error| explain(file, "header", &error))?;
    let (mut soup, mut rows) = (Soup::new(limits), Vec::new());
    for element in header.elements.values() {
        check_count(file, element, bytes.len(), limits)?;
        match element.name.as_str() {
            "vertex" => {
                for name in ["x", "y", "z"] {
                    if element.properties.get(name).is_none() {
                        return Err(Error::input(
                            file,
                            "header",
                            format!("got vertices without `{name}`, expected x, y, z"),
                        ));
                    }
                }
                let vertices: Vec<Vertex> = elements(file, &mut source, element, &header)?;
                soup.vertices.extend(vertices.iter().map(|vertex| Vec3::from(vertex.0)));
            }
            kind @ ("face" | "tristrips") => {
                let found: Vec<Indices> = elements(file, &mut source, element, &header)?;
                rows.push((kind == "face", found));
            }
            _ => drop(elements::<Skipped>(file, &mut source, element, &header)?),
        }
    }
    if rows.iter().all(|(_, rows)| rows.is_empty()) && !soup.vertices.is_empty() {
        let problem = "got points without faces, expected triangles; an obstacle takes points as `points`";
        return Err(Error::input(file, "face", problem));
    }
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

/// Refuses elements that the file cannot hold: those without a property take no bytes, however many
/// there are.
fn check_count(file: &str, element: &ElementDef, bytes: usize, limits: &LoadLimits) -> Result<()> {
    let name = quoted(&element.name);
    let limit = if element.name == "vertex" { LoadLimit::Vertices } else { LoadLimit::Triangles };
    limits.check(limit, element.count, file, &format!("header: element {name}"))?;
    if element.count > bytes {
        let problem = format!("got {} of {name} in {bytes} bytes, expected as many as there are", element.count);
        return Err(Error::input(file, "header", problem));
    }
    Ok(())
}

/// What stands for the index -1, which ends a strip.
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
    // It tells of the line, then of its text, in lines of their own.
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

/// An element that does not matter.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests {
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

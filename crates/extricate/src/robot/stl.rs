//! STL, binary and ASCII, to triangle soup.

use super::mesh_file::Soup;
use crate::error::{Error, Result};
use crate::math::Vec3;

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Parses either kind. Which one it is, the length decides: many binary files begin with "solid" too.
pub(super) fn parse(file: &str, bytes: &[u8]) -> Result<Soup> {
    let count = bytes.get(80..HEADER).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let needed = HEADER + RECORD * count;
    let text = looks_like_text(bytes);
    if bytes.len() >= HEADER && (bytes.len() == needed || !text && bytes.len() > needed) {
        return Ok(binary(&bytes[HEADER..needed]));
    }
    if text {
        return ascii(file, &String::from_utf8_lossy(bytes));
    }
    let expected = if bytes.len() < HEADER {
        format!("at least {HEADER} for a binary STL, or text that begins with `solid`")
    } else {
        format!("{needed} for the {count} triangles that its header announces")
    };
    Err(Error::input(file, "length", format!("got {} bytes, expected {expected}", bytes.len())))
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid") && !bytes.contains(&0)
}

fn binary(records: &[u8]) -> Soup {
    let mut soup = Soup::default();
    for record in records.chunks_exact(RECORD) {
        // Twelve floats: the normal, which nobody keeps right, then three corners.
        let mut floats = record.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f64).skip(3);
        let mut corner = || Vec3::from_fn(|_, _| floats.next().unwrap_or(f64::NAN));
        soup.push_triangle([corner(), corner(), corner()]);
    }
    soup
}

fn ascii(file: &str, text: &str) -> Result<Soup> {
    let error = |line: usize, got: &str, expected: &str| {
        Error::input(file, format!("line {}", line + 1), format!("got `{}`, expected {expected}", got.trim()))
    };
    let mut soup = Soup::default();
    let mut corners = Vec::with_capacity(3);
    let mut ended = false;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "vertex" => {
                let mut corner = Vec3::zeros();
                for slot in corner.iter_mut() {
                    let number_found = words.next().and_then(|word| word.parse::<f32>().ok());
                    *slot = number_found.ok_or_else(|| error(number, line, "`vertex x y z`"))? as f64;
                }
                corners.push(corner);
            }
            "endloop" => match corners[..] {
                [a, b, c] => {
                    soup.push_triangle([a, b, c]);
                    corners.clear();
                }
                _ => return Err(error(number, &format!("{} vertices", corners.len()), "3 in a loop")),
            },
            "solid" => ended = false,
            "endsolid" => ended = true,
            "facet" | "outer" | "endfacet" => {}
            _ => return Err(error(number, line, "a line of an ASCII STL")),
        }
    }
    if !ended || !corners.is_empty() {
        return Err(error(text.lines().count(), "the end of the file", "`endsolid`"));
    }
    Ok(soup)
}

#[cfg(test)]
mod tests {
    use super::super::mesh_file::parse;

    /// A tetrahedron.
    pub(in crate::robot) fn binary(header: &[u8]) -> Vec<u8> {
        let corners = [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(4u32.to_le_bytes());
        for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
            bytes.extend([0; 12]);
            face.iter().for_each(|&k: &usize| corners[k].iter().for_each(|x| bytes.extend(x.to_le_bytes())));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const ASCII: &str = "solid a b\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n VERTEX 1 0 0\n vertex 0 1e0 0\n\
                         endloop\n endfacet\nendsolid a\n";

    #[test]
    fn both_kinds_parse_even_where_binary_says_solid() {
        for header in [&b"made by"[..], b"solid thing", b"solid"] {
            let mesh = parse("a.STL", &binary(header)).unwrap();
            assert!(mesh.is_closed() && mesh.triangles.len() == 4);
        }
        let mut trailing = binary(b"x");
        trailing.push(b'\n');
        assert_eq!(parse("a.stl", &trailing).unwrap().triangles.len(), 4);
        let mesh = parse("a.stl", ASCII.as_bytes()).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (3, 1));
        assert_eq!(parse("a.stl", format!("{ASCII}{ASCII}").as_bytes()).unwrap().triangles.len(), 1);
    }

    #[test]
    fn every_truncation_is_an_error() {
        for bytes in [binary(b"made by"), binary(b"solid"), ASCII.as_bytes().to_vec()] {
            let complete = bytes.len() - if bytes.contains(&0) { 0 } else { 3 };
            for length in 0..complete {
                assert!(parse("a.stl", &bytes[..length]).is_err(), "{length} of {}", bytes.len());
            }
        }
        let message = parse("a.stl", &binary(b"x")[..200]).unwrap_err().to_string();
        assert_eq!(message, "a.stl: length: got 200 bytes, expected 284 for the 4 triangles that its header announces");
    }

    #[test]
    fn wrong_lines_are_named() {
        let message = |text: String| parse("a.stl", text.as_bytes()).unwrap_err().to_string();
        assert!(message(ASCII.replace("1e0", "one")).starts_with("a.stl: line 6: got `vertex 0 one 0`"));
        assert!(message(ASCII.replace("1e0", "nan")).contains("finite"));
        assert!(message(ASCII.replace(" VERTEX 1 0 0\n", "")).contains("line 6: got `2 vertices`"));
        assert!(message(ASCII.replace("outer", "inner")).contains("line 3"));
    }
}

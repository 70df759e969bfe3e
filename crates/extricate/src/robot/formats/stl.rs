//! Reads STL, binary and ASCII, through `stl_io`.
//!
//! The reader first settles what `stl_io` would misread: which kind a file is, whether it is
//! complete, and how ASCII writers differ. They vary in case, in the number of solids, and in
//! normals of triangles without area.

use std::io::{Cursor, ErrorKind};

use super::lines::CountedLines;
use super::soup::Soup;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::LoadLimits;

/// Sizes in a binary file \[bytes\]: the header, the number of triangles after it, and a triangle.
const HEADER_BYTES: usize = 80;
const COUNT_BYTES: usize = 4;
const RECORD_BYTES: usize = 50;

/// Parses either kind. The length decides which one it is: many binary files begin with "solid"
/// too.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Soup> {
    let start = HEADER_BYTES + COUNT_BYTES;
    let count = bytes.get(HEADER_BYTES..start).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let needed = start + RECORD_BYTES * count;
    let text = looks_like_text(bytes);
    if bytes.len() >= start && (bytes.len() == needed || !text && bytes.len() > needed) {
        let empty = Soup::new(limits);
        empty.has_room(3 * count, count).map_err(|problem| Error::input(file, "triangles", problem))?;
        return binary(&bytes[..needed], empty)
            .map_err(|error| Error::input(file, "triangles", format!("got {error}, expected {count} of them")));
    }
    if text {
        return ascii(file, &String::from_utf8_lossy(bytes), Soup::new(limits));
    }
    let expected = if bytes.len() < start {
        format!("at least {start} for a binary STL, or text that begins with `solid`")
    } else {
        format!("{needed} for the {count} triangles that its header announces")
    };
    Err(Error::input(file, "length", format!("got {} bytes, expected {expected}", bytes.len())))
}

pub(super) fn looks_like_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid") && !bytes.contains(&0)
}

fn binary(bytes: &[u8], empty: Soup) -> std::io::Result<Soup> {
    // The header's text is cleared, since `stl_io` would guess the kind from it.
    let mut bytes = bytes.to_vec();
    bytes[..HEADER_BYTES].fill(0);
    let mut cursor = Cursor::new(bytes);
    soup(&mut cursor, empty)
}

fn ascii(file: &str, text: &str, empty: Soup) -> Result<Soup> {
    let plain = plain(text);
    let mut lines = CountedLines::new(&plain);
    soup(&mut lines, empty).map_err(|error| {
        let last = text.lines().count();
        let number = lines.line.saturating_sub(1).min(last);
        let (got, expected) = match error.kind() {
            ErrorKind::UnexpectedEof => ("the end of the file", "`endsolid`"),
            _ => (text.lines().nth(number.saturating_sub(1)).unwrap_or("").trim(), "a line of an ASCII STL"),
        };
        // The parser's message repeats the line, so it is quoted too.
        let (got, error) = (quoted(got), error.to_string());
        let problem = format!("got `{got}`, expected {expected} ({})", quoted(&error));
        Error::input(file, format!("line {number}"), problem)
    })
}

/// Rewrites `text`, line by line after a line `solid`, as `stl_io` wants it: keywords in lower
/// case, no normals, and one solid, which ends where the last one does.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len() + text.len() / 8);
    plain.push_str("solid \n");
    let mut ended = false;
    for line in text.lines() {
        let line = line.trim();
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or("");
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => ended = false,
            "endsolid" => ended = true,
            "facet" => plain.push_str("facet normal 0 0 0"),
            "outer" if words.next().is_some_and(|word| word.eq_ignore_ascii_case("loop")) => {
                plain.push_str("outer loop")
            }
            known @ ("vertex" | "endloop" | "endfacet") => {
                plain.push_str(known);
                // One word too many is kept, so that `stl_io` sees that there are more.
                words.take(4).for_each(|word| plain.extend([" ", word]));
            }
            _ => plain.push_str(&quoted(line)),
        }
        plain.push('\n');
    }
    plain.push_str(if ended { "endsolid" } else { "" });
    plain
}

fn soup<R: std::io::Read + std::io::Seek>(reader: &mut R, mut soup: Soup) -> std::io::Result<Soup> {
    for triangle in stl_io::create_stl_reader(reader)? {
        soup.push_triangle(triangle?.vertices.map(|corner| Vec3::from(corner.0.map(f64::from))));
    }
    Ok(soup)
}

#[cfg(test)]
mod tests {
    use crate::robot::formats::parse;

    pub(crate) fn binary(header: &[u8]) -> Vec<u8> {
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
    fn ascii_is_read_as_writers_vary_it() {
        let triangle = parse("a.stl", ASCII.as_bytes()).unwrap();
        for same in [
            ASCII.to_uppercase(),
            format!("\n\t {}", ASCII.replace("solid a b", "solid").replace("endsolid a", "endsolid")),
            ASCII.replace("normal 0 0 1", "normal nan nan nan").replace('\n', " \r\n"),
            ASCII.replace(" outer loop", "OUTER   loop"),
        ] {
            assert_eq!(parse("a.stl", same.as_bytes()).unwrap(), triangle, "{same}");
        }
        let other = ASCII.replace("vertex 0 0 0", "vertex 0 0 1");
        assert_eq!(parse("a.stl", format!("{ASCII}{other}").as_bytes()).unwrap().triangles.len(), 2);
        assert!(parse("a.stl", format!("{ASCII}{}", other.replace("endsolid", "")).as_bytes()).is_err());
    }

    #[test]
    fn a_huge_count_is_an_error_at_once() {
        let mut bytes = binary(b"x");
        bytes[80..84].fill(0xff);
        let message = parse("a.stl", &bytes).unwrap_err().to_string();
        assert!(message.contains("got 284 bytes, expected 214748364834 for the 4294967295 triangles"), "{message}");
    }

    #[test]
    fn wrong_lines_are_named() {
        let message = |text: String| parse("a.stl", text.as_bytes()).unwrap_err().to_string();
        assert!(message(ASCII.replace("1e0", "one")).starts_with("a.stl: line 6: got `vertex 0 one 0`"));
        assert!(message(ASCII.replace("1e0", "nan")).contains("finite"));
        assert!(message(ASCII.replace(" VERTEX 1 0 0\n", "")).contains("line 6: got `endloop`, expected a line"));
        assert!(message(ASCII.replace("outer", "inner")).contains("line 3"));
    }
}

//! Wavefront OBJ to triangles: vertices and faces; materials, normals and textures are skipped.

use super::mesh_file::Soup;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Parses `v` and `f` lines; polygons become fans, all objects and groups one mesh.
pub(super) fn parse(file: &str, bytes: &[u8]) -> Result<Soup> {
    let text = String::from_utf8_lossy(bytes);
    let mut soup = Soup::default();
    let mut polygon = Vec::new();
    // Line numbers are those of the file, so continued lines are joined where they are read.
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = line.to_owned();
        while line.ends_with('\\') {
            line.pop();
            line.push_str(lines.next().map_or("", |(_, more)| more));
        }
        let content = line.split('#').next().unwrap_or("");
        let mut words = content.split_whitespace();
        let keyword = words.next();
        let error = |expected: &str| {
            Error::input(file, format!("line {}", number + 1), format!("got `{}`, expected {expected}", content.trim()))
        };
        if keyword == Some("v") {
            let mut vertex = Vec3::zeros();
            for slot in vertex.iter_mut() {
                *slot = words.next().and_then(|word| word.parse().ok()).ok_or_else(|| error("`v x y z`"))?;
            }
            soup.vertices.push(vertex);
        } else if keyword == Some("f") {
            polygon.clear();
            for word in words {
                let index: i64 = word.split('/').next().and_then(|i| i.parse().ok()).ok_or_else(|| error("indices"))?;
                let count = soup.vertices.len() as i64;
                let from_zero = if index < 0 { count + index } else { index - 1 };
                if !(0..count).contains(&from_zero) {
                    return Err(error(&format!(
                        "indices of the {count} vertices before it (1 to {count}, or -1 back)"
                    )));
                }
                polygon.push(from_zero as u32);
            }
            soup.push_polygon(&polygon);
        }
    }
    Ok(soup)
}

#[cfg(test)]
mod tests {
    use super::super::mesh_file::parse;

    const CUBE: &str = "# cube\nmtllib a.mtl\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 # comment\n v 0 0 1 0.1 0.2 0.3\n\
        v 1 0 1 1.0\nv 1 1 1\nv 0 1 1\nvn 0 0 1\nvt 0 0\nusemtl red\nf 4 3 2 1\nf 5/1 6/1 7/1 8/1\ng two\n\
        f 1//1 2//1 6//1 5//1\nf -6/1/1 -5/1/1 -1/1/1 -2/1/1\nf 2 3 7 6\nf 1 5 \\\n8 4\nl 1 2\ns off\n";

    #[test]
    fn quads_negative_indices_and_objects_merge() {
        let mesh = parse("a.obj", CUBE.as_bytes()).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len(), mesh.components.len()), (8, 12, 1));
        assert!(mesh.is_closed());
        assert_eq!(parse("a.OBJ", CUBE.replace('\n', "\r\n").as_bytes()).unwrap(), mesh);
    }

    #[test]
    fn truncation_never_panics() {
        for length in 0..CUBE.len() {
            let _ = parse("a.obj", &CUBE.as_bytes()[..length]);
        }
    }

    #[test]
    fn wrong_lines_are_named() {
        let message = |text: &str| parse("a.obj", text.as_bytes()).unwrap_err().to_string();
        assert!(message("v 0 0 0\nf 1 2 3\n").starts_with("a.obj: line 2: got `f 1 2 3`, expected indices of the 1"));
        assert!(message("v 0 0 0\nf 0 1 1\n").contains("expected indices"));
        assert!(message("v 0 0 0\nf -2 1 1\n").contains("expected indices"));
        assert!(message("v 0 0\n").starts_with("a.obj: line 1: got `v 0 0`, expected `v x y z`"));
        assert!(message("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3").contains("vertex 0: got (0, 0, NaN)"));
        assert!(message("v 0 0 0\n").contains("no triangles"));
    }
}

//! Reads vertices and faces of Wavefront OBJ, through `tobj`; skips materials, normals and
//! textures.

use tobj::{LoadError, LoadOptions, Model};

use super::lines::CountedLines;
use super::soup::Soup;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::LoadLimits;

/// Parses vertices and faces; all objects and groups become one mesh.
pub(crate) fn parse(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Soup> {
    let text = String::from_utf8_lossy(bytes);
    let plain = plain(&text);
    let models = match load(&plain) {
        Ok(models) => models,
        Err((error, line)) => return Err(explain(file, &text, &plain, error, line)),
    };
    let mut soup = Soup::new(limits);
    for Model { mesh, .. } in models {
        let first = soup.vertices.len() as u32;
        soup.vertices.extend(mesh.positions.chunks_exact(3).map(Vec3::from_column_slice));
        let indices: Vec<u32> = mesh.indices.iter().map(|index| first + index).collect();
        if mesh.face_arities.is_empty() {
            soup.triangles.extend_from_slice(indices.as_chunks().0);
        }
        let mut rest = &indices[..];
        for (face, &corners) in mesh.face_arities.iter().enumerate() {
            let (polygon, others) = rest.split_at(corners as usize);
            soup.push_face(&[polygon], || line_of_face(&plain, face));
            rest = others;
        }
    }
    Ok(soup)
}

/// Returns the line of a face, counted among faces of three corners or more.
fn line_of_face(plain: &str, face: usize) -> String {
    let faces = plain.lines().zip(1..).filter(|(line, _)| line.starts_with('f') && line.split(' ').count() > 3);
    faces.map(|(_, number)| format!("line {number}")).nth(face).unwrap_or_else(|| "a line".into())
}

/// Reduces `text`, line by line, to what is used: `v` with three coordinates, `f` with the indices
/// of its vertices. `tobj` takes a comment at the end of a line for data, knows no continued lines,
/// divides by a fourth coordinate, and would read the rest.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let mut line = line.to_owned();
        let mut continued = 0;
        while line.ends_with('\\') {
            line.pop();
            line.push_str(lines.next().unwrap_or(""));
            continued += 1;
        }
        let mut words = line.split('#').next().unwrap_or("").split_whitespace();
        match words.next() {
            Some("v") => {
                plain.push('v');
                words.take(3).for_each(|word| plain.extend([" ", word]));
            }
            Some("f") => {
                let mut indices = words.map(|word| word.split('/').next().filter(|i| !i.is_empty()).unwrap_or(word));
                if let Some(index) = indices.next() {
                    plain.extend(["f ", index]);
                    indices.for_each(|index| plain.extend([" ", index]));
                }
            }
            _ => {}
        }
        (0..=continued).for_each(|_| plain.push('\n'));
    }
    plain
}

/// Returns what `tobj` reads, or its error and the line at which it occurred.
fn load(plain: &str) -> std::result::Result<Vec<Model>, (LoadError, usize)> {
    let options = LoadOptions { ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let mut lines = CountedLines::new(plain);
    let loaded = tobj::load_obj_buf(&mut lines, &options, |_| Ok(Default::default()));
    loaded.map(|(models, _)| models).map_err(|error| (error, lines.line))
}

fn explain(file: &str, text: &str, plain: &str, error: LoadError, line: usize) -> Error {
    let (line, expected) = match error {
        LoadError::PositionParseError => (line, "`v x y z`".into()),
        LoadError::FaceParseError => (line, "indices".into()),
        LoadError::FaceVertexOutOfBounds => {
            let (line, count) = bad_index(plain).unwrap_or((line, 0));
            (line, format!("indices of the {count} vertices before it (1 to {count}, or -1 back)"))
        }
        error => (line, format!("an OBJ file ({error})")),
    };
    let got = text.lines().nth(line.saturating_sub(1)).unwrap_or("").split('#').next().unwrap_or("").trim();
    Error::input(file, format!("line {line}"), format!("got `{}`, expected {expected}", quoted(got)))
}

/// Finds the first line with an index that no vertex before it has, and the number of these
/// vertices. `tobj` checks indices at the end of an object, and does not say which one is wrong.
fn bad_index(plain: &str) -> Option<(usize, u64)> {
    let mut count = 0;
    for (line, number) in plain.lines().zip(1..) {
        count += u64::from(line.starts_with('v'));
        let good = |word: &str| word.parse().is_ok_and(|index: i64| (1..=count).contains(&index.unsigned_abs()));
        if line.starts_with('f') && !line.split(' ').skip(1).all(good) {
            return Some((number, count));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::robot::formats::parse;

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
    fn what_tobj_would_take_for_data_is_left_out() {
        let triangle = parse("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        for same in [
            "v 0 0 0 2\nv 1 0 0 2\nv 0 1 0 0\nf 1 2 3\n",
            "v 0 0 0 .1 .2\nv 1 0 0 # right\nv 0 1 0\nvt x\nvn 1\nusemtl\nf 1/9 2//9 3/9/9 # 4\nf\nf 1\nf 1 2\n",
            "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n\\\n3",
        ] {
            assert_eq!(parse("a.obj", same.as_bytes()).unwrap(), triangle, "{same}");
        }
        assert_eq!(
            parse("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 2 0\nv -1 1 0\nf 1 2 3 4 5").unwrap().triangles.len(),
            3
        );
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
        assert!(message("v 0 0 0\nf /1 1 1\n").contains("line 2: got `f /1 1 1`, expected indices"));
        assert!(message("v 0 0 0\nf 1 1 x\n").starts_with("a.obj: line 2: got `f 1 1 x`, expected indices"));
        assert!(message("v 0 0\n").starts_with("a.obj: line 1: got `v 0 0`, expected `v x y z`"));
        assert!(message("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3").contains("vertex 0: got (0, 0, NaN)"));
        assert!(message("v 0 0 0\n").contains("no triangles"));
    }

    /// An L-shaped solid of height 1, whose two ends begin at the corner `start`.
    fn angle(start: usize) -> String {
        let ends = [[1, 2, 3, 4, 5, 6], [12, 11, 10, 9, 8, 7]].map(|mut end: [u32; 6]| {
            end.rotate_left(start);
            end.iter().map(|k| format!(" {k}")).collect::<String>()
        });
        let outline = [[0, 0], [0, 2], [1, 2], [1, 1], [2, 1], [2, 0]];
        let at = |z: u32| outline.map(|[x, y]| format!("v {x} {y} {z}\n")).concat();
        let side = |k: u32| format!("f {} {} {} {}\n", k, k + 6, k % 6 + 7, k % 6 + 1);
        let sides: String = (1..=6).map(side).collect();
        format!("{}{}f{}\nf{}\n{sides}", at(0), at(1), ends[0], ends[1])
    }

    #[test]
    fn concave_faces_keep_their_notch_wherever_they_begin() {
        for start in 0..6 {
            let mesh = parse("a.obj", angle(start).as_bytes()).unwrap();
            assert!(mesh.is_closed());
            let volume = crate::robot::Geometry::Mesh(mesh.into()).volume_moments().unwrap().measure;
            assert!((volume - 3.0).abs() < 1e-12, "{start}: {volume}");
        }
    }

    #[test]
    fn a_face_that_crosses_itself_is_named() {
        let mut warnings = Vec::new();
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1\nf 1 2\n\nf 1 2 3\nf 1 3 \\\n2 4\n";
        crate::robot::formats::parse_and_warn("a.obj", text.as_bytes(), &mut warnings).unwrap();
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].starts_with("a.obj: line 9: a face of 4 corners crosses itself"), "{}", warnings[0]);
    }
}

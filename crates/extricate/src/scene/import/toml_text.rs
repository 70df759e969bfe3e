//! Writes imported entries as the text of a scene file, their meshes and voxels as files beside it.

use std::fmt::Write;
use std::sync::Arc;

use crate::robot::{Geometry, TriangleMesh, Voxels};
use crate::scene::file::{PoseEntry, ScaleEntry, SceneFile, ShapeEntry};

/// A file of a mesh or of voxels that the text of a scene file names.
#[derive(Debug, Clone)]
pub struct ShapeFile {
    /// Path relative to the scene file, with `/` between folders.
    pub path: String,
    /// Contents: Wavefront OBJ, or a line `i,j,k` for each occupied cell.
    pub text: String,
}

/// Writes the text of a scene file with these obstacles, attached objects, disabled pairs, padding,
/// and the URDFs of the robots. Also returns the files that it names, whose paths are below
/// `folder`.
///
/// The text begins with `comments`, one line each.
pub fn to_toml(entries: &SceneFile, comments: &[String], folder: &str) -> (String, Vec<ShapeFile>) {
    let mut text = String::new();
    let mut files = Vec::new();
    for line in comments.iter().flat_map(|comment| comment.lines()) {
        let printed: String = line.chars().filter(|c| !c.is_control()).collect();
        push(&mut text, format!("# {printed}"));
    }
    if !entries.padding.is_empty() {
        let all: Vec<String> = entries.padding.iter().map(|(name, x)| format!("{} = {x:?}", quoted(name))).collect();
        push(&mut text, format!("\npadding = {{ {} }}", all.join(", ")));
    }
    for robot in &entries.robot {
        push(&mut text, format!("\n[[robot]]\nurdf = {}", quoted(&robot.urdf)));
    }
    for entry in &entries.obstacle {
        push(&mut text, format!("\n[[obstacle]]\nname = {}", quoted(&entry.name)));
        placed(&mut text, &entry.name, (&entry.shape, &entry.pose), folder, &mut files);
    }
    for entry in &entries.attached {
        push(&mut text, format!("\n[[attached]]\nname = {}\nlink = {}", quoted(&entry.name), quoted(&entry.link)));
        placed(&mut text, &entry.name, (&entry.shape, &entry.pose), folder, &mut files);
        if !entry.touch.is_empty() {
            let touch: Vec<String> = entry.touch.iter().map(|name| quoted(name)).collect();
            push(&mut text, format!("touch = [{}]", touch.join(", ")));
        }
    }
    if !entries.pairs.disable.is_empty() {
        push(&mut text, "\n[pairs]\ndisable = [".into());
        for [a, b] in &entries.pairs.disable {
            push(&mut text, format!("    [{}, {}],", quoted(a), quoted(b)));
        }
        push(&mut text, "]".into());
    }
    (text, files)
}

fn push(text: &mut String, line: String) {
    text.push_str(&line);
    text.push('\n');
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.into()).to_string()
}

fn placed(
    text: &mut String,
    name: &str,
    (shape, pose): (&ShapeEntry, &PoseEntry),
    folder: &str,
    files: &mut Vec<ShapeFile>,
) {
    let written = match (&shape.triangles, &shape.scenery) {
        (Some(mesh), _) => Some(("obj", obj(mesh))),
        (_, Some(Geometry::Voxels(voxels))) => Some(("csv", csv(voxels))),
        _ => None,
    };
    let path = match written {
        Some((extension, text)) => {
            files.push(ShapeFile { path: file_path(folder, name, extension, files), text });
            files.last().map(|file| file.path.clone())
        }
        None => shape.mesh.clone(),
    };
    push(text, format!("shape = {{ {} }}", shape_text(shape, path)));
    let mut parts = vec![format!("xyz = {:?}", pose.xyz)];
    parts.extend(pose.quat_xyzw.map(|quaternion| format!("quat_xyzw = {quaternion:?}")));
    if *pose != PoseEntry::default() {
        push(text, format!("pose = {{ {} }}", parts.join(", ")));
    }
}

/// Writes those keys of a shape that an import can set; `path` is that of its mesh or voxels.
fn shape_text(shape: &ShapeEntry, path: Option<String>) -> String {
    let mut parts: Vec<String> = Vec::new();
    parts.extend(shape.cuboid.map(|sides| format!("box = {sides:?}")));
    parts.extend(shape.sphere.map(|radius| format!("sphere = {radius:?}")));
    parts.extend(shape.cylinder.map(|sizes| format!("cylinder = {sizes:?}")));
    parts.extend(shape.half_space.map(|normal| format!("half-space = {normal:?}")));
    parts.extend(shape.offset.map(|offset| format!("offset = {offset:?}")));
    match (&shape.scenery, path) {
        (Some(Geometry::Voxels(voxels)), Some(path)) => {
            parts.push(format!("voxels = {}, size = {:?}", quoted(&path), voxels.size()));
        }
        (_, path) => parts.extend(path.map(|path| format!("mesh = {}", quoted(&path)))),
    }
    if let Some(ScaleEntry::Axes(scale)) = shape.scale {
        parts.push(format!("scale = {scale:?}"));
    }
    if shape.convex {
        parts.push("convex = true".into());
    }
    parts.join(", ")
}

/// Returns a path that every file system accepts and that no other file has.
fn file_path(folder: &str, name: &str, extension: &str, others: &[ShapeFile]) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let stem: String = name.chars().map(plain).collect();
    let candidates = (1..).map(|number| match number {
        1 => format!("{folder}/{stem}.{extension}"),
        _ => format!("{folder}/{stem}.{number}.{extension}"),
    });
    let is_free = |path: &String| others.iter().all(|other| !other.path.eq_ignore_ascii_case(path));
    candidates.into_iter().find(is_free).unwrap_or_default()
}

fn csv(voxels: &Voxels) -> String {
    let mut text = String::new();
    for [i, j, k] in voxels.cells() {
        let _ = writeln!(text, "{i},{j},{k}");
    }
    text
}

fn obj(mesh: &Arc<TriangleMesh>) -> String {
    let mut text = String::new();
    for v in &mesh.vertices {
        let _ = writeln!(text, "v {:?} {:?} {:?}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

//! Worlds that other programs wrote: reads them, or writes them anew as scene files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::files::{read_within, reader};
use super::lock::OutputLock;
use super::writing::{check_not_read, check_output, write_together};
use crate::error::{Error, Result, bounded};
use crate::robot::{LoadLimit, LoadLimits};
use crate::scene::Scene;
use crate::scene::file::world_file::{in_world_of_entries, obstacles_of_entries};
use crate::scene::file::{ObstacleEntry, SceneFile};
use crate::scene::import::{Imported, import, to_toml};

/// First words of an imported scene file; an import replaces no other file.
const MARK: &str = "# Imported by extricate from ";

/// Scene and files that an import wrote.
#[derive(Debug, Clone)]
pub struct ImportReport {
    /// Entries of the scene file.
    pub entries: SceneFile,
    /// Files of meshes and voxels written beside it.
    pub meshes: Vec<PathBuf>,
    /// Notes on what was read as something else, or left out, and why.
    pub notes: Vec<String>,
}

/// Reads a world that another program wrote.
///
/// # Errors
/// As [`import`]; [`Error::Read`] if the file cannot be read.
pub fn read_foreign(path: &Path, robots: Option<&Scene>, limits: &LoadLimits) -> Result<Imported> {
    let text = String::from_utf8(read_within(path, limits, LoadLimit::TextBytes)?).map_err(|error| {
        let at = format!("byte {}", error.utf8_error().valid_up_to());
        Error::input(path.display().to_string(), at, "got bytes that are not UTF-8, expected text")
    })?;
    import(path, &text, robots, limits)
}

/// Loads the robots of `robots` in a world that another program wrote. Notes on it become warnings
/// of the scene.
pub(crate) fn load_foreign(robots: &Scene, path: &Path, limits: &LoadLimits) -> Result<Scene> {
    in_world_of_imported(robots, path, read_foreign(path, Some(robots), limits)?, limits)
}

/// As [`load_foreign`], for the text of a file.
pub(crate) fn load_foreign_text(robots: &Scene, path: &Path, text: &str, limits: &LoadLimits) -> Result<Scene> {
    in_world_of_imported(robots, path, import(path, text, Some(robots), limits)?, limits)
}

fn in_world_of_imported(robots: &Scene, path: &Path, imported: Imported, limits: &LoadLimits) -> Result<Scene> {
    let Imported { entries, notes } = imported;
    let mut scene = in_world_of_entries(robots, path, &entries, &mut reader(limits))?;
    let file = path.display();
    scene.warnings.extend(notes.into_iter().map(|note| format!("{file}: {note}")));
    scene.warnings = bounded(scene.warnings);
    Ok(scene)
}

/// Writes a world that another program wrote as a scene file at `output`, with meshes and voxels in
/// a folder beside it. With `urdf` it is a scene of that robot; `robots` are those that it is
/// checked with.
///
/// # Errors
/// As [`import`], and if the robots have no such links. [`Error::Write`], also if no import wrote
/// the file at `output`, or if another import writes it.
pub fn import_world(
    path: &Path,
    output: &Path,
    robots: Option<&Scene>,
    urdf: Option<&Path>,
    limits: &LoadLimits,
) -> Result<ImportReport> {
    let read = [path].into_iter().chain(urdf);
    check_not_read(output, read)?;
    // Lock before unfinished files are removed: they may be those of a living run.
    let lock = OutputLock::take(output)?;
    check_output(output, "scene written by import", |head| head.starts_with(MARK.as_bytes()))?;
    let Imported { mut entries, mut notes } = read_foreign(path, robots, limits)?;
    match robots {
        Some(robots) => {
            let scene = in_world_of_entries(robots, path, &entries, &mut reader(limits))?;
            notes.extend(scene.warnings.into_iter().filter(|warning| !robots.warnings.contains(warning)));
        }
        None => check_shapes(path, &entries)?,
    }
    let notes = bounded(notes);
    let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_path_buf();
    let (from, to) = (folder(path), folder(output));
    if let Some(urdf) = urdf {
        let urdf = moved(urdf, Path::new(""), &to);
        let robot = toml::to_string(&toml::Table::from_iter([("urdf".to_string(), urdf.into())])).unwrap_or_default();
        entries.robot = crate::scene::file::parse("import", &format!("[[robot]]\n{robot}"))?.robot;
    }
    let obstacles = entries.obstacle.iter_mut().map(|entry| &mut entry.shape);
    for shape in obstacles.chain(entries.attached.iter_mut().map(|entry| &mut entry.shape)) {
        shape.mesh = shape.mesh.take().map(|mesh| moved(Path::new(&mesh), &from, &to));
    }
    let stem = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let source = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let head: Vec<String> =
        [format!("{}{source}", MARK.trim_start_matches("# "))].into_iter().chain(notes.iter().cloned()).collect();
    let (text, files) = to_toml(&entries, &head, &format!("{stem}-meshes"));
    let meshes: Vec<PathBuf> = files.iter().map(|file| to.join(&file.path)).collect();
    let texts = files.into_iter().map(|file| file.text).chain([text]);
    write_scene(&lock, &meshes.iter().cloned().chain([output.to_path_buf()]).zip(texts).collect::<Vec<_>>())?;
    Ok(ImportReport { entries, meshes, notes })
}

/// Writes meshes and the scene file that names them, which is the last of `files`.
fn write_scene(lock: &OutputLock, files: &[(PathBuf, String)]) -> Result<()> {
    let [meshes @ .., _] = files else { return Ok(()) };
    let folders: BTreeSet<&Path> = meshes.iter().filter_map(|(path, _)| path.parent()).collect();
    for folder in &folders {
        fs::create_dir_all(folder).map_err(|source| Error::Write { path: folder.to_path_buf(), source })?;
        lock.clear(folder);
    }
    let written = write_together(files);
    if written.is_err() {
        // This removes empty folders only.
        folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
    written
}

/// Whether a file is XML, as URDFs are.
///
/// # Errors
/// [`Error::Read`] if the file cannot be read.
pub fn is_urdf(path: &Path) -> Result<bool> {
    let bytes = read_within(path, &LoadLimits::default(), LoadLimit::FileBytes)?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    Ok(text.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<'))
}

/// Checks that every shape can be made, also of attached objects.
fn check_shapes(path: &Path, entries: &SceneFile) -> Result<()> {
    let held = entries.attached.iter().map(|entry| ObstacleEntry {
        name: entry.name.clone(),
        shape: entry.shape.clone(),
        pose: entry.pose,
    });
    let obstacle = entries.obstacle.iter().cloned().chain(held).collect();
    let all = SceneFile { obstacle, limits: entries.limits.clone(), ..SceneFile::default() };
    obstacles_of_entries(path, &all, &mut reader(&entries.limits)).map(drop)
}

/// Rewrites a path that starts from the folder `from` as one that starts from `to`.
fn moved(path: &Path, from: &Path, to: &Path) -> String {
    let here = |folder: &Path| if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() };
    let (Ok(target), Ok(start)) = (here(&from.join(path)).canonicalize(), here(to).canonicalize()) else {
        return path.display().to_string();
    };
    let (target, start): (Vec<Component>, Vec<Component>) =
        (target.components().collect(), start.components().collect());
    let shared = target.iter().zip(&start).take_while(|(a, b)| a == b).count();
    let up = start[shared..].iter().map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(target[shared..].iter().copied()).collect();
    path.display().to_string()
}

//! The only module that touches files: scenes in, models in and out.

mod files;
#[cfg(any(feature = "model-files", feature = "moveit"))]
mod growing;
mod load_options;
#[cfg(any(feature = "model-files", feature = "moveit"))]
mod lock;
#[cfg(feature = "model-files")]
pub mod model_file;
#[cfg(feature = "model-files")]
pub mod roadmap_file;
#[cfg(feature = "moveit")]
pub mod worlds;
#[cfg(any(feature = "model-files", feature = "moveit"))]
mod writing;

use std::path::Path;

use crate::collision::convex_parts;
use crate::error::{Error, Result};
#[cfg(feature = "model-files")]
use crate::model::Model;
use crate::robot::packages::PackageSearch;
use crate::robot::{LoadLimit, LoadLimits};
use crate::scene::assemble::{Visual, assemble_entries, visuals};
use crate::scene::file::world_file::{in_world_of_entries, obstacles_of_entries};
use crate::scene::file::{self, SceneFile};
#[cfg(feature = "moveit")]
use crate::scene::import::is_foreign;
use crate::scene::{Body, Scene};
pub use files::check_regular;
use files::{read, read_within, reader};
#[cfg(any(feature = "model-files", feature = "moveit"))]
pub use growing::GrowingFile;
use load_options::package_search;
pub use load_options::{LoadOptions, find_package};
#[cfg(any(feature = "model-files", feature = "moveit"))]
pub use lock::OutputLock;
#[cfg(feature = "model-files")]
pub use roadmap_file::{check_roadmap_output, load_roadmap, save_roadmap};
#[cfg(any(feature = "model-files", feature = "moveit"))]
pub use writing::{check_not_read, check_output, is_same_output, write_atomically, write_together};

/// Loads a scene file and everything that it names, or a URDF as a scene of that robot alone.
///
/// # Errors
/// [`crate::Error::Read`] if the file cannot be read, [`crate::Error::Input`] if it, or a file that
/// it names, cannot be used.
pub fn load_scene(path: impl AsRef<Path>) -> Result<Scene> {
    load_scene_within(path, &LoadLimits::default())
}

/// As [`load_scene`], with other limits on the contents of files.
///
/// # Errors
/// As [`load_scene`].
pub fn load_scene_within(path: impl AsRef<Path>, limits: &LoadLimits) -> Result<Scene> {
    load_scene_with(path, &LoadOptions { limits: limits.clone(), ..LoadOptions::default() })
}

/// As [`load_scene`], with other limits, and folders in which packages are looked up first.
///
/// # Errors
/// As [`load_scene`].
pub fn load_scene_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene> {
    let path = path.as_ref();
    assemble_entries(path, &entries_of(path, options)?, &mut reader(&options.limits))
}

/// Reads the shapes by which the links of a scene file or URDF are seen, for pictures of the scene
/// that [`load_scene_with`] makes of it.
///
/// # Errors
/// As [`load_scene`], for a mesh of a `<visual>` element too.
pub fn load_visuals(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Vec<Visual>> {
    let path = path.as_ref();
    visuals(path, &entries_of(path, options)?, &mut reader(&options.limits))
}

/// The entries of a scene file; a URDF is a scene of that robot alone.
fn entries_of(path: &Path, options: &LoadOptions) -> Result<SceneFile> {
    let text = match scene_text(path, &options.limits)? {
        SceneText::Toml(text) => text,
        // Debug formatting quotes a string as TOML does.
        SceneText::Urdf => format!("[[robot]]\nurdf = {:?}\n", path.file_name().unwrap_or_default().to_string_lossy()),
    };
    parsed(path, &text, options)
}

fn parsed(path: &Path, text: &str, options: &LoadOptions) -> Result<SceneFile> {
    let entries = file::parse_within(&path.display().to_string(), text, &options.limits)?;
    Ok(completed(&SceneFile { search: PackageSearch { given: options.packages.clone(), ..entries.search }, ..entries }))
}

/// Adds the collision checker's cutter for convex parts, and the folders in which this process
/// finds packages.
fn completed(entries: &SceneFile) -> SceneFile {
    SceneFile { cut: Some(convex_parts), search: package_search(&entries.search.given), ..entries.clone() }
}

/// Loads the scene of the robots of `robots` in the world of a scene file, see
/// [`crate::scene::file::world_file::in_world`], or in a world of another program, see
/// [`import`](crate::scene::import::import).
///
/// # Errors
/// As [`load_scene`].
pub fn load_world(robots: &Scene, path: &Path, options: &LoadOptions) -> Result<Scene> {
    let limits = &options.limits;
    #[cfg(feature = "moveit")]
    if is_foreign(path) {
        return worlds::load_foreign(robots, path, limits);
    }
    match scene_text(path, limits)? {
        SceneText::Toml(text) => in_world_of_entries(robots, path, &parsed(path, &text, options)?, &mut reader(limits)),
        SceneText::Urdf => {
            let problem = "got a URDF, expected a scene file with the world's obstacles (TOML)";
            Err(Error::input(path.display().to_string(), "file", problem))
        }
    }
}

/// As [`load_world`], for the `text` of a file, whose `name` sets the format by its extension and
/// stands in messages.
///
/// # Errors
/// As [`load_world`].
pub fn load_world_text(robots: &Scene, name: &str, text: &str, options: &LoadOptions) -> Result<Scene> {
    let (path, limits) = (Path::new(name), &options.limits);
    #[cfg(feature = "moveit")]
    if is_foreign(path) {
        return worlds::load_foreign_text(robots, path, text, limits);
    }
    in_world_of_entries(robots, path, &parsed(path, text, options)?, &mut reader(limits))
}

/// As [`load_world`], for entries that were not written as a file, see [`assemble_scene`].
///
/// # Errors
/// As [`load_scene`].
pub fn assemble_world(robots: &Scene, name: &str, entries: &SceneFile) -> Result<Scene> {
    in_world_of_entries(robots, Path::new(name), &completed(entries), &mut reader(&entries.limits))
}

/// Reads the obstacles of entries that were not written as a file, for [`Scene::with_obstacles`].
/// Also returns notes on the files that they are read from.
///
/// # Errors
/// As [`load_scene`].
pub fn read_obstacles(name: &str, entries: &SceneFile) -> Result<(Vec<Body>, Vec<String>)> {
    obstacles_of_entries(Path::new(name), &completed(entries), &mut reader(&entries.limits))
}

/// Text from which a scene is read.
enum SceneText {
    Toml(String),
    Urdf,
}

fn scene_text(path: &Path, limits: &LoadLimits) -> Result<SceneText> {
    let bytes = read_within(path, limits, LoadLimit::TextBytes)?;
    let name = path.display().to_string();
    #[cfg(feature = "moveit")]
    if is_foreign(path) {
        let problem =
            "got a world without a robot, expected a scene (TOML) or a URDF: give it as the world of one, or import it";
        return Err(Error::input(name, "file", problem));
    }
    #[cfg(feature = "model-files")]
    if model_file::is_model(&bytes) {
        return Err(Error::input(name, "file", "got a model file, expected a scene (TOML)"));
    }
    // A URDF may declare another encoding, so its bytes are not read as UTF-8.
    if bytes.trim_ascii_start().first() == Some(&b'<') {
        return Ok(SceneText::Urdf);
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = format!("byte {}", error.utf8_error().valid_up_to());
        Error::input(name, at, "got bytes that are not UTF-8, expected a scene (TOML)")
    })?;
    if text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
        return Ok(SceneText::Urdf);
    }
    Ok(SceneText::Toml(text))
}

/// Assembles a scene that was not written as a file; messages call it `name`. Paths in `entries`
/// start from the working directory. If a path is the first of a pair in `texts`, the second stands
/// for the file's contents.
///
/// # Errors
/// As [`load_scene`].
pub fn assemble_scene(name: &str, entries: &SceneFile, texts: &[(String, String)]) -> Result<Scene> {
    let entries = &completed(entries);
    assemble_entries(Path::new(name), entries, &mut |path| match texts.iter().find(|(at, _)| Path::new(at) == path) {
        Some((_, text)) => Ok(text.clone().into_bytes()),
        None => read_within(path, &entries.limits, LoadLimit::FileBytes),
    })
}

/// Loads a model file.
///
/// # Errors
/// [`crate::Error::Model`] if the file is truncated, altered, foreign or of another version.
#[cfg(feature = "model-files")]
pub fn load_model(path: impl AsRef<Path>) -> Result<Model> {
    let path = path.as_ref();
    model_file::decode(path, &read(path)?)
}

/// Writes a model file as [`write_atomically`] does.
///
/// # Errors
/// [`crate::Error::Write`]; the old file, if any, is then untouched.
#[cfg(feature = "model-files")]
pub fn save_model(model: &Model, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    write_atomically(path, &model_file::encode(model))
}

/// Checks that [`save_model`] can be expected to succeed; call it before learning.
///
/// # Errors
/// [`crate::Error::Write`] for a directory, a device, a folder that does not exist or accepts no
/// files, and an existing file that is no model: a scene given by mistake is not replaced.
#[cfg(feature = "model-files")]
pub fn check_model_output(path: &Path) -> Result<()> {
    check_output(path, "model", model_file::is_model)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scene::builtin;

    #[test]
    fn scenes_load_from_files_as_from_memory() {
        let folder = tempfile::tempdir().unwrap();
        let files = builtin::files("shelf-arm").unwrap();
        for (name, contents) in &files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, contents).unwrap();
        }
        let loaded = load_scene(folder.path().join(&files[0].0)).unwrap();
        let built = builtin::scene("shelf-arm").unwrap();
        assert_eq!(loaded.pairs, built.pairs);
        assert_eq!(serde_json::to_string(&loaded).unwrap(), serde_json::to_string(&built).unwrap());

        std::fs::remove_file(folder.path().join("robot/meshes/link_3.stl")).unwrap();
        let missing = load_scene(folder.path().join(&files[0].0)).unwrap_err().to_string();
        assert!(missing.contains("package://robot/meshes/link_3.stl") && missing.contains("tried"), "{missing}");
        assert!(matches!(load_scene(folder.path().join("none.toml")), Err(Error::Read { .. })));
    }

    #[test]
    fn scenes_need_no_files() {
        let urdf = "<robot name='r'><link name='a'/><link name='b'><collision><geometry><sphere radius='1'/></geometry>\
                    </collision></link><joint name='j' type='prismatic'><parent link='a'/><child link='b'/>\
                    <axis xyz='1 0 0'/><limit lower='0' upper='9' effort='1' velocity='1'/></joint></robot>";
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(crate::math::Vec3::from).to_vec();
        let mesh = crate::robot::TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        let text = "[[robot]]\nurdf = 'text'\n[[obstacle]]\nname = 'wedge'\nshape = {}";
        let mut entries = crate::scene::file::parse("s", text).unwrap();
        entries.obstacle[0].shape.triangles = Some(mesh.into());
        let assembled = |entries: &_, at: &str| assemble_scene("s", entries, &[(at.to_string(), urdf.to_string())]);
        let scene = assembled(&entries, "text").unwrap();
        assert_eq!((scene.space.nq(), scene.bodies.len(), scene.pairs.len()), (1, 2, 1));
        assert!(assembled(&entries, "other").unwrap_err().to_string().contains("robot 1: urdf: got text"));
        entries.clearance = Some(crate::scene::clearances::ClearanceEntry::Uniform(-1.0));
        assert!(assembled(&entries, "text").unwrap_err().to_string().contains("s: clearance: got -1"));
    }

    #[test]
    fn only_files_of_the_same_kind_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let is_own = |head: &[u8]| head.starts_with(b"own");
        let refused = |name: &str| check_output(&path(name), "thing", is_own).err().map(|e| e.to_string());
        fs::write(path("own"), "own 1").unwrap();
        fs::write(path("empty"), "").unwrap();
        fs::write(path("scene"), "clearance = 0").unwrap();
        assert_eq!((refused("own"), refused("empty"), refused("new")), (None, None, None));
        assert!(refused("scene").unwrap().contains("exists and is no thing"));
        assert!(refused("").unwrap().contains("is a directory"));
        assert!(refused("no/new").unwrap().contains("there is no directory"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left behind");
    }

    #[test]
    fn what_is_read_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("in"), "").unwrap();
        let other = folder.path().join(".").join("in");
        let refused = check_not_read(&path("in"), [path("a").as_path(), &other]).unwrap_err().to_string();
        assert!(refused.contains("in: the same command reads it"), "{refused}");
        check_not_read(&path("out"), [path("in").as_path()]).unwrap();
    }

    #[test]
    fn what_killed_runs_left_goes_and_what_others_write_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mine = [path(".extricate-a-Ab3xYz"), path(".extricate-b-Ab3xYz")];
        let others = [path(".extricate-a.b-Ab3xYz"), path(".extricate-a-Ab3x"), path("a-Ab3xYz")];
        let plant = |paths: &[std::path::PathBuf]| paths.iter().for_each(|path| fs::write(path, "half").unwrap());
        plant(&mine);
        plant(&others);
        let written_by_another = writing::temporary(folder.path(), &path("a")).unwrap();
        write_together(&[(path("b"), "new"), (path("a"), "new")]).unwrap();
        assert!(mine.iter().all(|path| !path.exists()) && others.iter().all(|path| path.exists()));
        assert!(written_by_another.path().exists());
        plant(&mine);
        write_atomically(&path("a"), b"newer").unwrap();
        check_output(&path("b"), "thing", |_| true).unwrap();
        assert!(mine.iter().all(|path| !path.exists()) && written_by_another.path().exists());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).unwrap();
        fs::write(path("far/file"), "old").unwrap();
        std::os::unix::fs::symlink(path("far/file"), path("link")).unwrap();
        write_atomically(&path("link"), b"new").unwrap();
        assert!(path("link").is_symlink());
        assert_eq!(fs::read(path("far/file")).unwrap(), b"new");
        let device = check_output(Path::new("/dev/null"), "thing", |_| true).unwrap_err().to_string();
        assert!(device.contains("/dev/null: it is a device"), "{device}");
        let endless = load_scene("/dev/zero").unwrap_err().to_string();
        assert!(endless.ends_with("it is a device or a pipe, expected a file"), "{endless}");
    }
}

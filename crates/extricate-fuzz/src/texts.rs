//! Targets for everything that is read as text: robots, scenes, worlds and queries. A scene that
//! was read is checked at some configurations.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::scene::assemble::assemble_entries;
use extricate::internals::scene::file::world_file::in_world_of_entries;
use extricate::internals::scene::file::{self, SceneFile};
use extricate::internals::scene::import::import;
use extricate::{CheckScratch, Checker, Error, Label, LoadLimit, LoadLimits, Result, Scene, builtin};
use extricate_cli::input::Configs;

use crate::seeds::{self, ARM, GROUPS, TETRAHEDRON};

const CHECKED_CONFIGS: u64 = 3;
const URDF_SCENE: &str = "[[robot]]\nurdf = 'fuzzed'\npackages = ['.']\n";
/// Lines of an input that are read.
const MAX_LINES: usize = 200;

/// Returns small limits, so that an input takes milliseconds, also if it is refused.
pub fn limits() -> LoadLimits {
    LoadLimits::default()
        .with(LoadLimit::Values, 20_000)
        .with(LoadLimit::Vertices, 20_000)
        .with(LoadLimit::Triangles, 20_000)
        .with(LoadLimit::MeshNodes, 2_000)
        .with(LoadLimit::Links, 100)
        .with(LoadLimit::Shapes, 100)
        .with(LoadLimit::Obstacles, 100)
        .with(LoadLimit::Pairs, 1_000)
}

/// Reads a URDF in a scene of that robot alone, and uses the scene.
pub fn urdf(bytes: &[u8]) {
    use_any(scene_of(URDF_SCENE, bytes));
}

/// Reads the SRDF of a robot whose group moves, and uses the scene.
pub fn srdf(bytes: &[u8]) {
    use_any(scene_of("[[robot]]\nurdf = 'arm.urdf'\nsrdf = 'fuzzed'\ngroup = 'arm'\n", bytes));
}

/// Reads a scene file and uses the scene; every file that it names exists.
pub fn scene(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        use_any(scene_of(text, b"0 0 3\n1 0 3\n"));
    }
}

/// Reads a scene file as a world of a robot, and uses the scene.
pub fn world(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let world = file::parse_within("w.toml", text, &limits());
    use_any(world.and_then(|world| in_world(&world)));
}

/// Reads a world of MoveIt in each of its three formats, and uses the scene.
pub fn moveit(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for name in ["w.scene", "w.yaml", "w.json"] {
        let imported = import(Path::new(name), text, Some(robot()), &limits());
        use_any(imported.and_then(|imported| in_world(&imported.entries)));
    }
}

/// Reads lines of configurations, and of segments.
pub fn queries(bytes: &[u8]) {
    let scene = robot();
    let open = || Configs::new(Box::new(Cursor::new(bytes.to_vec())), "fuzzed", None);
    let mut configs = open();
    for _ in 0..MAX_LINES {
        match configs.next(scene) {
            Ok(Some(Ok((_, config)))) => {
                assert!(config.len() == scene.space().nq() && config.iter().all(|x| x.abs() <= 1e9), "{:?}", &*config);
            }
            Ok(Some(Err(bad))) => assert!(bad.error.len() < 4000, "a message of {} bytes", bad.error.len()),
            Ok(None) | Err(_) => break,
        }
    }
    let mut segments = open();
    (0..MAX_LINES).take_while(|_| matches!(segments.next_segment(scene), Ok(Some(_)))).for_each(drop);
}

/// Returns the robot that worlds and queries are for.
fn robot() -> &'static Scene {
    static ROBOT: OnceLock<Scene> = OnceLock::new();
    ROBOT.get_or_init(|| builtin::scene("shelf-arm").expect("a built-in scene"))
}

fn in_world(world: &SceneFile) -> Result<Scene> {
    in_world_of_entries(robot(), Path::new("w.toml"), world, &mut |path| read(path, b"0 0 3\n1 0 3\n"))
}

fn scene_of(text: &str, fuzzed: &[u8]) -> Result<Scene> {
    let entries = file::parse_within("s.toml", text, &limits())?;
    assemble_entries(Path::new("s.toml"), &entries, &mut |path| read(path, fuzzed))
}

/// Returns content by the ending of the file's name; a name without an ending gets the input.
fn read(path: &Path, fuzzed: &[u8]) -> Result<Vec<u8>> {
    match path.extension().and_then(|extension| extension.to_str()) {
        None => Ok(fuzzed.to_vec()),
        Some("urdf") => Ok(ARM.into()),
        Some("srdf") => Ok(GROUPS.into()),
        Some("obj") => Ok(TETRAHEDRON.into()),
        Some("stl") => Ok(seeds::stl().swap_remove(0).1),
        Some("csv" | "xyz") => Ok(b"0 0 3\n1 0 3\n".to_vec()),
        Some(_) => Err(Error::Read { path: PathBuf::from(path), source: std::io::ErrorKind::NotFound.into() }),
    }
}

/// Uses a scene, or checks the length of the error message.
pub fn use_any(scene: Result<Scene>) {
    match scene {
        Ok(scene) => use_scene(scene),
        Err(error) => {
            let message = error.to_string();
            assert!(message.len() < 4000, "a message of {} bytes", message.len());
        }
    }
}

fn use_scene(scene: Scene) {
    assert!(scene.warnings().iter().all(|warning| warning.len() < 4000), "a long warning");
    let checker = Checker::new(Arc::new(scene));
    let space = checker.scene().space();
    let halton = Halton::new(space.nv(), 1);
    let mut scratch = CheckScratch::default();
    let mut q = vec![0.0; space.nq()];
    for index in 0..CHECKED_CONFIGS {
        halton.config(space, index, &mut q);
        let config = space.config(&q).expect("a sample of the space");
        let label = checker.label(&config, &mut scratch);
        let clearance = checker.clearance(&config, &mut scratch);
        assert!(!clearance.is_nan(), "a clearance that is no number");
        assert!(label != Label::Free || clearance > 0.0, "free, with a clearance of {clearance}");
        // Depths of meshes take longer than all else together.
        if index == 0 && checker.scene().pairs().len() < 50 {
            let distances = checker.signed_distances(&config, &mut scratch);
            assert!(distances.iter().all(|distance| !distance.is_nan()), "{distances:?}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_read() {
        for (name, bytes) in seeds::urdf() {
            assert!(scene_of(URDF_SCENE, &bytes).is_ok(), "urdf {name}");
        }
        for (name, bytes) in seeds::srdf() {
            let scene = "[[robot]]\nurdf = 'arm.urdf'\nsrdf = 'fuzzed'\ngroup = 'arm'\n";
            scene_of(scene, &bytes).unwrap_or_else(|error| panic!("srdf {name}: {error}"));
        }
        for (name, bytes) in seeds::scene() {
            let text = String::from_utf8(bytes).unwrap();
            scene_of(&text, b"").unwrap_or_else(|error| panic!("scene {name}: {error}"));
        }
        for (name, bytes) in seeds::world() {
            let world = file::parse_within("w.toml", &String::from_utf8(bytes).unwrap(), &limits()).unwrap();
            in_world(&world).unwrap_or_else(|error| panic!("world {name}: {error}"));
        }
        for ((name, bytes), file) in seeds::moveit().into_iter().zip(["w.scene", "w.yaml", "w.json"]) {
            let text = String::from_utf8(bytes).unwrap();
            let imported = import(Path::new(file), &text, Some(robot()), &limits());
            let imported = imported.unwrap_or_else(|error| panic!("moveit {name}: {error}"));
            in_world(&imported.entries).unwrap_or_else(|error| panic!("moveit {name}: {error}"));
        }
    }
}

//! The robots that scenes are drawn around, and the space about them where obstacles matter.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use extricate::builtin;

/// Distance between neighbouring arms \[m\]: more than twice their reach.
pub const ARM_SPACING_M: f64 = 3.0;

/// The space in which obstacles are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Space {
    /// Centre of the space \[m\].
    pub middle: [f64; 3],
    /// Approximate reach of the robot from the centre \[m\].
    pub reach: f64,
    /// Whether the robot only moves in the plane z = 0.
    pub flat: bool,
    /// Height \[m\] of the bottom of bars. If unset, bars extend above and below the robot.
    pub floor: Option<f64>,
}

#[derive(Debug, Clone)]
pub struct Robot {
    /// Part of the names of scenes.
    pub name: &'static str,
    /// Lines of the robot's entry in the scene file.
    pub entry: String,
    /// Lines of the scene file after the entry.
    pub pairs: &'static str,
    /// Paths, relative to the scene file, and contents of the robot's files.
    pub files: Vec<(String, Vec<u8>)>,
    /// Whether its meshes can be used without taking hulls.
    pub raw: bool,
    pub space: Space,
}

/// The built-in robots, and those of the folder `fetched`.
pub fn all(fetched: Option<&Path>) -> Result<Vec<Robot>> {
    let mut robots = built_in();
    if let Some(folder) = fetched {
        robots.extend(others(folder)?);
    }
    Ok(robots)
}

/// The robots of built-in scenes.
pub fn built_in() -> Vec<Robot> {
    let planar = Space { middle: [0.0; 3], reach: 1.2, flat: true, floor: None };
    // Bars stand above the palm, because those within reach of the fingers would pass through it.
    let hand = Space { middle: [0.0, 0.0, 0.06], reach: 0.12, flat: false, floor: Some(0.03) };
    vec![
        seven_joint_arm(),
        built_in_robot("planar-arm", "planar-arm", "arm", planar),
        built_in_robot("hand", "hand", "hand", hand),
    ]
}

/// The arm of the built-in scene `shelf-arm`.
pub fn seven_joint_arm() -> Robot {
    let space = Space { middle: [0.0, 0.0, 0.4], reach: 1.0, flat: false, floor: None };
    built_in_robot("seven-joint-arm", "shelf-arm", "arm", space)
}

fn built_in_robot(name: &'static str, scene: &str, urdf: &str, space: Space) -> Robot {
    let files = builtin::files(scene).expect("a built-in scene");
    let own = files.into_iter().filter(|(path, _)| path.starts_with("robot/"));
    Robot {
        name,
        entry: format!("urdf = \"{name}/robot/{urdf}.urdf\"\npackages = [\"{name}\"]\n"),
        pairs: "",
        files: own.map(|(path, contents)| (format!("{name}/{path}"), contents)).collect(),
        raw: true,
        space,
    }
}

/// Name, URDF, further lines, pairs, whether meshes may stay raw, middle and reach.
type Fetched = (&'static str, &'static str, &'static str, &'static str, bool, [f64; 3], f64);

/// The same robots as in bench/scenes.py.
const FETCHED: [Fetched; 3] = [
    (
        "panda",
        "panda_description/urdf/panda.urdf",
        "srdf = \"{robots}/panda_description/srdf/panda.srdf\"\nlocked = { panda_finger_joint1 = 0.02 }\n",
        "",
        true,
        [0.0, 0.0, 0.4],
        0.85,
    ),
    (
        "ur5",
        "ur_description/urdf/ur5_robot.urdf",
        "srdf = \"{robots}/ur_description/srdf/ur5.srdf\"\n",
        "",
        false,
        [0.0, 0.0, 0.2],
        0.9,
    ),
    (
        "allegro",
        "allegro_hand_description/urdf/allegro_right_hand.urdf",
        "",
        // The two boxes overlap by design of the model.
        "[pairs]\ndisable = [[\"palm_link\", \"link_13.0\"]]\n",
        true,
        [0.03, 0.0, 0.04],
        0.15,
    ),
];

/// Reads the robots that scripts/fetch-robots.py unpacks into `folder`.
fn others(folder: &Path) -> Result<Vec<Robot>> {
    let folder = folder.canonicalize().with_context(|| folder.display().to_string())?;
    let packages = folder.ancestors().nth(2).context("expected the folder that scripts/fetch-robots.py fills")?;
    let mut robots = Vec::new();
    for (name, urdf, more, pairs, raw, middle, reach) in FETCHED {
        ensure!(folder.join(urdf).exists(), "{}: not found; scripts/fetch-robots.py", folder.join(urdf).display());
        let shown = folder.display().to_string();
        let entry = format!(
            "urdf = \"{shown}/{urdf}\"\npackages = [\"{}\"]\n{}",
            packages.display(),
            more.replace("{robots}", &shown)
        );
        let space = Space { middle, reach, flat: false, floor: None };
        robots.push(Robot { name, entry, pairs, files: Vec::new(), raw, space });
    }
    Ok(robots)
}

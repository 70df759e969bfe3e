//! `hand`: three fingers whose tips follow their curl, without obstacles.

use std::f64::consts::PI;

use super::file::File;
use super::swept_meshes::End::Round;
use super::swept_meshes::{stl, tube};
use super::urdf_text::{JointText, Shape, UrdfText};

/// Name of each finger, its direction from the palm's centre \[rad\], and whether it spreads.
const FINGERS: [(&str, f64, bool); 3] = [("index", 0.9, true), ("middle", -0.9, true), ("thumb", PI, false)];
/// Distance of the knuckles from the palm's centre \[m\].
const KNUCKLE_RADIUS: f64 = 0.055;
/// Height of the knuckles above the palm's centre \[m\]; it leaves 3 mm between the proximal links
/// and the palm.
const KNUCKLE_HEIGHT: f64 = 0.027;
/// Distance from the knuckle to the last joint \[m\].
const PROXIMAL_LENGTH: f64 = 0.05;

/// Returns the scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    let mut urdf = UrdfText::new("hand");
    urdf.link("palm", &[(Shape::Cylinder([0.068, 0.03]), [0.0; 3])]);
    for finger in FINGERS {
        add_finger(&mut urdf, finger);
    }
    let proximal = tube(&[[0.0, 0.0, 0.0, 0.009], [-0.002, 0.0, 0.025, 0.008], [0.0, 0.0, 0.046, 0.0085]], [Round; 2]);
    let tip = tube(&[[0.0, 0.0, 0.0, 0.0085], [0.001, 0.0, 0.02, 0.0075], [0.004, 0.0, 0.035, 0.006]], [Round; 2]);
    let files = vec![
        ("robot/hand.urdf".into(), urdf.finish()),
        ("robot/meshes/proximal.stl".into(), stl(&[proximal])),
        ("robot/meshes/tip.stl".into(), stl(&[tip])),
    ];
    (SCENE.into(), files)
}

/// Adds a finger that points up (z) and curls about y, toward the palm's axis (x).
fn add_finger(urdf: &mut UrdfText, (finger, angle, spreads): (&str, f64, bool)) {
    let [spread, proximal, tip] = ["spread", "proximal", "tip"].map(|part| format!("{finger}_{part}"));
    let at_palm = JointText {
        xyz: [KNUCKLE_RADIUS * angle.cos(), KNUCKLE_RADIUS * angle.sin(), KNUCKLE_HEIGHT],
        rpy: [0.0, 0.0, angle + PI],
        ..Default::default()
    };
    let curl = JointText { name: &format!("{finger}_curl"), kind: "revolute", limits: Some([-0.2, 1.7]), ..at_palm };
    let curl = JointText { axis: [0.0, 1.0, 0.0], ..curl };
    if spreads {
        urdf.link(&spread, &[]);
        urdf.joint(&JointText {
            name: &spread,
            kind: "revolute",
            parent_child: ["palm", &spread],
            limits: Some([-0.9, 0.9]),
            ..at_palm
        });
    }
    urdf.link(&proximal, &[(Shape::Mesh("meshes/proximal.stl"), [0.0; 3])]);
    let parent = if spreads { spread.as_str() } else { "palm" };
    let (xyz, rpy) = if spreads { ([0.0; 3], [0.0; 3]) } else { (at_palm.xyz, at_palm.rpy) };
    urdf.joint(&JointText { parent_child: [parent, &proximal], xyz, rpy, ..curl });
    urdf.link(&tip, &[(Shape::Mesh("meshes/tip.stl"), [0.0; 3])]);
    urdf.joint(&JointText {
        name: &tip,
        kind: "revolute",
        parent_child: [&proximal, &tip],
        xyz: [0.0, 0.0, PROXIMAL_LENGTH],
        axis: [0.0, 1.0, 0.0],
        limits: Some([-0.2, 1.5]),
        mimic: Some((&format!("{finger}_curl"), 0.7, 0.1)),
        ..Default::default()
    });
}

const SCENE: &str = r#"# Three fingers whose tips follow their curl; nothing to touch but itself.
clearance = 1e-4
metric = { kind = "joint" }

[[robot]]
urdf = "robot/hand.urdf"
packages = ["."]
geometry = "convex-hull"
"#;

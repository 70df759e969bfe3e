//! `free-box`: a box that flies freely around and through a ring above a floor.

use super::file::File;
use super::swept_meshes::{stl, torus};
use super::urdf_text::{Shape, UrdfText};

/// Returns the scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    let mut urdf = UrdfText::new("free-box");
    urdf.link("body", &[(Shape::Box([0.3, 0.2, 0.1]), [0.0; 3])]);
    let ring = stl(&[torus(0.3, 0.1)]);
    (SCENE.into(), vec![("robot/box.urdf".into(), urdf.finish()), ("ring.stl".into(), ring)])
}

const SCENE: &str = r#"# A box that flies freely around and through a ring above a floor.
clearance = 1e-4
metric = { kind = "object-norm" }

[[robot]]
urdf = "robot/box.urdf"
base = "floating"
bounds = { min = [-0.8, -0.8, -0.5], max = [0.8, 0.8, 0.8] }

[[obstacle]]
name = "ring"
shape = { mesh = "ring.stl" }
pose = { rpy = [0, 1.5707963267948966, 0] }
[[obstacle]]
name = "floor"
shape = { box = [2, 2, 0.05] }
pose = { xyz = [0, 0, -0.525] }
"#;

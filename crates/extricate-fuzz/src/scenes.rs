//! Small scenes that together have every kind of joint and shape.

use std::io::ErrorKind;
use std::path::Path;

use extricate::internals::scene::assemble::assemble;
use extricate::{Error, Scene, builtin};

/// Two revolute links, one of them without limits, and one that slides as the last rotates.
const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="upper"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></collision></link>
<link name="lower"><collision><origin xyz="0.15 0 0" rpy="0 1.5708 0"/><geometry><capsule radius="0.03" length="0.3"/></geometry></collision></link>
<link name="tip"><collision><geometry><mesh filename="tetra.obj" scale="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="a" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
<joint name="b" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
<limit lower="-2.5" upper="2.5" effort="1" velocity="1"/></joint>
<joint name="c" type="prismatic"><parent link="lower"/><child link="tip"/><origin xyz="0.35 0 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="b" multiplier="0.02" offset="0.01"/></joint></robot>"#;

/// An OBJ of four triangles around a corner.
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// The arm among two obstacles.
const FEW: &str = r#"
[[robot]]
urdf = "arm.urdf"
[[obstacle]]
name = "ball"
shape = { sphere = 0.12 }
pose = { xyz = [0.5, 0.35, 0] }
[[obstacle]]
name = "post"
shape = { box = [0.1, 0.1, 0.4] }
pose = { xyz = [-0.4, -0.3, 0] }
"#;

/// The arm among obstacles of every kind.
const MANY: &str = r#"
clearance = { world = 0.001, self = 0.0005 }
padding = { rod = 0.002 }
metric = { kind = "max-displacement" }
[[robot]]
urdf = "arm.urdf"
[[obstacle]]
name = "rod"
shape = { cylinder = [0.05, 0.4] }
pose = { xyz = [0.5, 0.35, 0], rpy = [0.1, 0.2, 0.3] }
[[obstacle]]
name = "pill"
shape = { capsule = [0.05, 0.2] }
pose = { xyz = [-0.5, 0.35, 0] }
[[obstacle]]
name = "hull"
shape = { mesh = "tetra.obj", scale = 0.2, convex = true }
pose = { xyz = [0.0, 0.6, 0] }
[[obstacle]]
name = "star"
shape = { mesh = "star.obj", scale = 0.2 }
pose = { xyz = [0.0, -0.6, 0] }
[[obstacle]]
name = "cloud"
shape = { points = [[0.6, -0.3, 0], [0.65, -0.3, 0], [0.6, -0.35, 0.05]], radius = 0.03 }
[[obstacle]]
name = "grid"
shape = { voxels = [[-6, 4, 0], [-6, 5, 0]], size = 0.1 }
[[obstacle]]
name = "wall"
shape = { half-space = [1, 0, 0], offset = -0.75 }
[[obstacle]]
name = "ground"
shape = { height-field = [[-0.3, -0.3], [-0.3, -0.02]], size = 0.6 }
"#;

/// Names of all these scenes.
pub const NAMES: [&str; 3] = ["few", "many", "free-box"];

/// Writes a solid of 24 triangles that is not convex, and beside it a tetrahedron without one side:
/// a mesh that needs a tree and convex pieces.
fn star() -> String {
    let mut text = String::from("v 0 0 0.5\nv 0 0 -0.5\n");
    for k in 0..12 {
        let (angle, radius) = (f64::from(30 * k).to_radians(), if k % 2 == 0 { 1.0 } else { 0.4 });
        text += &format!("v {:.4} {:.4} 0\n", radius * angle.cos(), radius * angle.sin());
    }
    for k in 0..12 {
        let (one, next) = (k + 3, (k + 1) % 12 + 3);
        text += &format!("f 1 {one} {next}\nf 2 {next} {one}\n");
    }
    text + "v 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 15 17 16\nf 15 16 18\nf 15 18 17\n"
}

/// Returns the scene of this name.
///
/// # Panics
/// If there is no scene of this name.
pub fn scene(name: &str) -> Scene {
    let text = match name {
        "few" => FEW,
        "many" => MANY,
        _ => return builtin::scene(name).expect("a built-in scene"),
    };
    let mut read = |path: &Path| match path.to_str() {
        Some("arm.urdf") => Ok(ARM.as_bytes().to_vec()),
        Some("tetra.obj") => Ok(TETRAHEDRON.as_bytes().to_vec()),
        Some("star.obj") => Ok(star().into_bytes()),
        _ => Err(Error::Read { path: path.into(), source: ErrorKind::NotFound.into() }),
    };
    assemble(Path::new("scene.toml"), text, &mut read).expect("a scene without faults")
}

//! `dual-arm`: two 7-joint arms side by side at a table, with a box between them.

use super::file::File;
use super::seven_joint_arm;

/// Returns the scene file and the robots' files.
pub fn files() -> (String, Vec<File>) {
    (SCENE.into(), seven_joint_arm::files())
}

const SCENE: &str = r#"# Two 7-joint arms side by side at a table, with a box between them.
clearance = 1e-4
metric = { kind = "joint" }

[[robot]]
name = "left"
urdf = "robot/arm.urdf"
packages = ["."]
pose = { xyz = [0, 0.35, 0] }

[[robot]]
name = "right"
urdf = "robot/arm.urdf"
packages = ["."]
pose = { xyz = [0, -0.35, 0] }

[[obstacle]]
name = "table"
shape = { box = [1.8, 1.8, 0.05] }
pose = { xyz = [0.4, 0, -0.03] }
[[obstacle]]
name = "box"
shape = { box = [0.25, 0.2, 0.3] }
pose = { xyz = [0.5, 0, 0.15] }
"#;

//! `shelf-arm`: a 7-joint arm on a table, before a shelf and beside a post.

use super::file::File;
use super::seven_joint_arm;

/// Returns the scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    (SCENE.into(), seven_joint_arm::files())
}

const SCENE: &str = r#"# A 7-joint arm on a table, before a shelf and beside a post.
clearance = 1e-4
metric = { kind = "joint" }

[[robot]]
urdf = "robot/arm.urdf"
packages = ["."]

[[obstacle]]
name = "table"
shape = { box = [1.8, 1.6, 0.05] }
pose = { xyz = [0.3, 0, -0.03] }
[[obstacle]]
name = "shelf_left"
shape = { box = [0.3, 0.03, 0.9] }
pose = { xyz = [0.65, 0.4, 0.45] }
[[obstacle]]
name = "shelf_right"
shape = { box = [0.3, 0.03, 0.9] }
pose = { xyz = [0.65, -0.4, 0.45] }
[[obstacle]]
name = "shelf_back"
shape = { box = [0.03, 0.83, 0.9] }
pose = { xyz = [0.815, 0, 0.45] }
[[obstacle]]
name = "board_low"
shape = { box = [0.3, 0.77, 0.03] }
pose = { xyz = [0.65, 0, 0.15] }
[[obstacle]]
name = "board_middle"
shape = { box = [0.3, 0.77, 0.03] }
pose = { xyz = [0.65, 0, 0.5] }
[[obstacle]]
name = "board_top"
shape = { box = [0.3, 0.77, 0.03] }
pose = { xyz = [0.65, 0, 0.885] }
[[obstacle]]
name = "post"
shape = { cylinder = [0.04, 1.2] }
pose = { xyz = [-0.05, -0.5, 0.6] }
"#;

//! Builds robots in code, and scenes of them, for tests of this module.

use super::assemble::build;
use super::assemble::loaded::LoadedRobot;
use super::assemble::obstacles::others;
use super::names::robot_names;
use super::{Scene, file};
use crate::error::Result;
use crate::math::{Pose, Vec3};
use crate::robot::srdf::Srdf;
use crate::robot::{Geometry, Joint, JointKind, Link, LinkGeometry, Mimic, Robot};

/// Name of the scene file in messages.
pub const FILE: &str = "s.toml";

/// Creates a joint about (along) z from link `l<parent>` to `l<child>`, 1 m along x from its
/// parent. Revolute and prismatic joints get the limits -1 and 1.
pub fn joint(name: &str, kind: JointKind, parent: usize, child: usize) -> Joint {
    let limits = matches!(kind, JointKind::Revolute | JointKind::Prismatic).then_some((-1.0, 1.0));
    let pose_parent_joint = Pose::translation(Vec3::x());
    Joint { name: name.into(), kind, parent, child, pose_parent_joint, axis: Vec3::z(), limits, mimic: None }
}

/// Makes `joint` follow the joint of index `leader`.
pub fn following(joint: Joint, leader: usize, multiplier: f64, offset: f64) -> Joint {
    Joint { mimic: Some(Mimic { joint: leader, multiplier, offset }), ..joint }
}

/// Creates a robot `arm` with links `l0` (the root), `l1` and so on, each a ball of radius 0.1 m.
pub fn robot(joints: Vec<Joint>) -> Robot {
    let ball =
        LinkGeometry { pose_link_geometry: Pose::identity(), geometry: Geometry::Sphere { radius: 0.1 }, rgba: None };
    let link = |k| Link { name: format!("l{k}"), collision: vec![ball.clone()] };
    Robot { name: "arm".into(), links: (0..=joints.len()).map(link).collect(), joints, root: 0 }
}

/// Creates a chain of joints `j0`, `j1` and so on of the given kinds.
pub fn chain(kinds: &[JointKind]) -> Robot {
    robot(kinds.iter().enumerate().map(|(k, &kind)| joint(&format!("j{k}"), kind, k, k + 1)).collect())
}

/// Assembles a scene file whose `[[robot]]` entries stand for `robots`, in order.
pub fn scene(text: &str, robots: &[Robot]) -> Result<Scene> {
    scene_with(text, robots, &[], None)
}

/// As [`scene`], with disabled pairs and a group that an SRDF would give to every robot.
pub fn scene_with(text: &str, robots: &[Robot], disabled: &[[String; 2]], group: Option<Vec<usize>>) -> Result<Scene> {
    let file = file::parse(FILE, text)?;
    let names = robot_names(FILE, &file.robot, robots.iter().map(|robot| robot.name.as_str()))?;
    let loaded = file.robot.iter().zip(robots).zip(names).map(|((entry, robot), name)| LoadedRobot {
        name,
        urdf: "arm.urdf".into(),
        robot: robot.clone(),
        srdf: Srdf { disabled: disabled.to_vec(), ..Srdf::default() },
        group: group.clone(),
        entry,
    });
    let loaded: Vec<LoadedRobot> = loaded.collect();
    let mut warnings = Vec::new();
    let bodies = others(
        FILE,
        (&file.obstacle, &file.attached),
        &mut |_, path, _| panic!("no mesh {path} in this test"),
        &file,
        &mut warnings,
    )?;
    build(FILE, &file, &loaded, bodies, warnings)
}

/// A `[[robot]]` entry without options.
pub const PLAIN: &str = "[[robot]]\nurdf = 'arm.urdf'\n";

//! Reads obstacles and attached objects with the files that they name: meshes, lists of numbers,
//! and robot files without moving joints, which become bodies of several shapes.

use std::collections::BTreeMap;

use super::load::{Files, Source};
use super::obstacles::{Others, others};
use crate::error::{Error, Result};
use crate::math::Pose;
use crate::robot::{JointKind, Robot};
use crate::scene::Part;
use crate::scene::file::shape_entry::with_scenery;
use crate::scene::file::{AttachedEntry, ObstacleEntry, SceneFile, ShapeEntry};

/// Reads the obstacles of a scene file, and its attached objects if `with_attached`; `name` is the
/// name of the file in messages.
///
/// # Errors
/// As [`others`], and for a URDF with a joint that moves or without geometry.
pub fn read_others(
    name: &str,
    scene: &SceneFile,
    with_attached: bool,
    files: &mut Files,
    warnings: &mut Vec<String>,
) -> Result<Others> {
    let mut obstacles =
        with_scenery(name, &scene.obstacle, &scene.limits, &mut |element, path| files.bytes(element, path))?;
    let mut attached = if with_attached { scene.attached.clone() } else { Vec::new() };
    for ObstacleEntry { name: own, shape, .. } in &mut obstacles {
        read_parts(&format!("obstacle \"{own}\""), shape, files, warnings)?;
    }
    for AttachedEntry { name: own, shape, .. } in &mut attached {
        read_parts(&format!("attached \"{own}\""), shape, files, warnings)?;
    }
    let mut load_mesh = |element: &str, path: &str, scale: [f64; 3]| files.mesh(element, path, scale);
    others(name, (&obstacles, &attached), &mut load_mesh, scene, warnings)
}

fn read_parts(element: &str, shape: &mut ShapeEntry, files: &mut Files, warnings: &mut Vec<String>) -> Result<()> {
    let Some(urdf) = &shape.urdf else { return Ok(()) };
    let source = Source {
        element: &format!("{element}: urdf"),
        urdf,
        packages: &shape.packages,
        geometry: shape.geometry.unwrap_or_default(),
        links: &BTreeMap::new(),
        is_replaced: &|_| false,
    };
    let (file, robot) = files.links(&source, warnings)?;
    shape.parts = Some(parts(&file, &robot)?);
    Ok(())
}

/// Returns all shapes of a robot without moving joints, in the coordinates of its root link.
fn parts(file: &str, robot: &Robot) -> Result<Vec<Part>> {
    if let Some(joint) = robot.joints.iter().find(|joint| joint.kind != JointKind::Fixed) {
        let problem = "got one that moves, expected fixed joints only in an obstacle: what moves is a [[robot]], its joints \
                       `locked` where they shall not";
        return Err(Error::input(file, format!("joint \"{}\"", joint.name), problem));
    }
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    robot.joints.iter().enumerate().for_each(|(index, joint)| below[joint.parent].push(index));
    let mut parts = Vec::new();
    let mut stack = vec![(robot.root, Pose::identity())];
    while let Some((link, pose)) = stack.pop() {
        parts.extend(robot.links[link].collision.iter().map(|shape| Part {
            pose_frame_part: pose.then(&shape.pose_link_geometry),
            geometry: shape.geometry.clone(),
        }));
        let below = below[link].iter().map(|joint| &robot.joints[*joint]);
        stack.extend(below.map(|joint| (joint.child, pose.then(&joint.pose_parent_joint))));
    }
    if parts.is_empty() {
        return Err(Error::input(file, "robot", "got no collision geometry, expected an obstacle to have some"));
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::cspace::Manifold;
    use crate::error::Result;
    use crate::math::Vec3;
    use crate::robot::Geometry;
    use crate::scene::Scene;
    use crate::scene::assemble::assemble;

    const ARM: &str = "<robot name='arm'><link name='base'/><link name='cart'><collision><geometry><box size='1 1 1'/>\
        </geometry></collision></link><joint name='j' type='prismatic'><parent link='base'/><child link='cart'/>\
        <axis xyz='1 0 0'/><limit lower='-5' upper='5'/></joint></robot>";
    const TABLE: &str = "<robot name='table'><link name='top'><collision><geometry><box size='2 2 0.1'/></geometry>\
        </collision></link><link name='leg'><collision><origin xyz='0 0 -1'/><geometry><cylinder radius='0.1' length='2'/>\
        </geometry></collision></link><link name='floor'><collision><geometry><plane/></geometry></collision></link>\
        <joint name='a' type='fixed'><origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/><parent link='top'/><child link='leg'/>\
        </joint><joint name='b' type='fixed'><origin xyz='0 0.5 -2'/><parent link='leg'/><child link='floor'/></joint></robot>";

    fn scene(more: &str, table: &str) -> Result<Scene> {
        let text = format!("[[robot]]\nurdf = 'arm.urdf'\n{more}");
        assemble(Path::new("s.toml"), &text, &mut |path: &Path| {
            Ok(if path == Path::new("arm.urdf") { ARM } else { table }.as_bytes().to_vec())
        })
    }

    #[test]
    fn limits_of_the_scene_stand_in_for_those_of_a_file_that_make_no_sense() {
        let read = |limits: &str, kind: &str, more: &str| {
            let arm = ARM.replace("lower='-5' upper='5'", limits).replace("prismatic", kind);
            let text = format!("[[robot]]\nurdf = 'arm.urdf'\n{more}");
            assemble(Path::new("s.toml"), &text, &mut |_: &Path| Ok(arm.clone().into_bytes()))
        };
        let manifold = |scene: &Scene| scene.space.factors()[0].manifold;
        for limits in
            ["lower='1' upper='-1'", "lower='-inf' upper='inf'", "lower='nan' upper='x'", "lower='0' upper='inf'"]
        {
            for kind in ["prismatic", "revolute"] {
                let replaced = read(limits, kind, "limits = { j = [-1, 1] }").unwrap();
                assert_eq!(manifold(&replaced), Manifold::Interval { lower: -1.0, upper: 1.0 }, "{limits} {kind}");
            }
            let message = read(limits, "prismatic", "").unwrap_err().to_string();
            assert!(message.contains("joint \"j\": got "), "{message}");
            assert!(limits.contains("nan") || message.contains("`limits = { j = [lower, upper] }`"), "{message}");
        }
        let turning = read("lower='-inf' upper='inf'", "revolute", "").unwrap();
        assert_eq!(manifold(&turning), Manifold::Circle);
        assert!(
            turning.warnings.iter().any(|told| told.contains("its limits -inf and inf are taken for none: continuous"))
        );
    }

    const OBSTACLE: &str = "[[obstacle]]\nname = 'table'\nshape = { urdf = 't.urdf' }\npose = { xyz = [0, 0, 3] }";

    #[test]
    fn a_robot_file_in_which_nothing_moves_is_an_obstacle() {
        let scene = scene(OBSTACLE, TABLE).unwrap();
        let table = scene.bodies.iter().find(|body| body.name == "table").unwrap();
        assert!(table.is_obstacle() && table.parts.len() == 3);
        let at = |kind: fn(&Geometry) -> bool| table.parts.iter().find(|p| kind(&p.geometry)).unwrap().pose_frame_part;
        assert_eq!(at(|g| matches!(g, Geometry::Box { .. })).translation, Vec3::new(0.0, 0.0, 3.0));
        assert_eq!(at(|g| matches!(g, Geometry::Cylinder { .. })).translation, Vec3::new(1.0, 0.0, 2.0));
        let floor = at(|g| matches!(g, Geometry::HalfSpace { .. })).translation;
        assert!((floor - Vec3::new(0.5, 0.0, 1.0)).norm() < 1e-15, "{floor}");
        assert_eq!(scene.pairs.len(), 1);
    }

    #[test]
    fn what_cannot_stand_still_is_told() {
        let message = |more: &str, table: &str| scene(more, table).unwrap_err().to_string();
        assert!(message(OBSTACLE, ARM).contains("t.urdf: joint \"j\": got one that moves, expected fixed joints only"));
        assert!(
            message(OBSTACLE, "<robot><link name='a'/></robot>").contains("t.urdf: robot: got no collision geometry")
        );
        let held = OBSTACLE.replace("obstacle", "attached").replace("shape", "link = 'cart'\nshape");
        assert!(message(&held, TABLE).contains("attached \"table\": shape: got a urdf with a <plane>"));
        let without_plane = TABLE.replace("<plane/>", "<sphere radius='1'/>");
        assert_eq!(scene(&held, &without_plane).unwrap().bodies.last().unwrap().parts.len(), 3);
        let wrong = OBSTACLE.replace("urdf = 't.urdf'", "box = [1, 1, 1], packages = ['.']");
        assert!(message(&wrong, TABLE).contains("`packages` and `geometry` belong to a urdf, got them with a box"));
    }
}

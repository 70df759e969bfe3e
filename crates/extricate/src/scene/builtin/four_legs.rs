//! `four-legs`: a fixed torso with four legs, each between two blocks.

use std::fmt::Write;

use super::file::File;
use super::swept_meshes::End::Round;
use super::swept_meshes::{stl, tube};
use super::urdf_text::{JointText, Shape, UrdfText};

/// Name of each leg, and signs of its hip's x and y from the torso's centre.
const LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("front_right", [1.0, -1.0]),
    ("hind_left", [-1.0, 1.0]),
    ("hind_right", [-1.0, -1.0]),
];
/// Distance of a hip from the torso's centre along x and y \[m\].
const HIP_OFFSET: [f64; 2] = [0.4, 0.25];
/// Height of the torso's centre above the ground \[m\].
const HEIGHT: f64 = 0.5;
/// Length of the thigh, and of the shin \[m\].
const LENGTH: f64 = 0.22;

/// The two blocks of each leg: full sides, and position \[m\] relative to the ground below the hip,
/// with x and y pointing away from the torso's centre. Other legs cannot reach them.
const BLOCKS: [[[[f64; 3]; 2]; 2]; 4] = [
    [[[0.14, 0.3, 0.26], [0.17, 0.0, 0.13]], [[0.36, 0.12, 0.24], [0.0, 0.18, 0.12]]],
    [[[0.12, 0.3, 0.22], [-0.14, 0.03, 0.11]], [[0.14, 0.3, 0.28], [0.19, 0.0, 0.14]]],
    [[[0.14, 0.28, 0.28], [0.18, 0.02, 0.14]], [[0.14, 0.3, 0.22], [-0.16, 0.02, 0.11]]],
    [[[0.32, 0.1, 0.28], [0.04, 0.17, 0.14]], [[0.12, 0.26, 0.26], [-0.15, 0.0, 0.13]]],
];

/// Returns the scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    let mut urdf = UrdfText::new("four-legs");
    urdf.link("torso", &[(Shape::Box([0.9, 0.3, 0.12]), [0.0; 3])]);
    for leg in LEGS {
        add_leg(&mut urdf, leg);
    }
    let shin = tube(&[[0.0, 0.0, 0.0, 0.025], [0.0, 0.0, -0.1, 0.02], [0.0, 0.0, -LENGTH, 0.022]], [Round; 2]);
    (scene(), vec![("robot/legs.urdf".into(), urdf.finish()), ("robot/meshes/shin.stl".into(), stl(&[shin]))])
}

/// Adds a leg that hangs down; it spreads about x, and swings and bends its knee about y.
fn add_leg(urdf: &mut UrdfText, (leg, [front, left]): (&str, [f64; 2])) {
    let [hip, thigh, shin] = ["hip", "thigh", "shin"].map(|part| format!("{leg}_{part}"));
    let [spread, swing, knee] = ["spread", "swing", "knee"].map(|joint| format!("{leg}_{joint}"));
    let revolute = JointText { kind: "revolute", axis: [0.0, 1.0, 0.0], ..Default::default() };
    urdf.link(&hip, &[]);
    urdf.joint(&JointText {
        name: &spread,
        parent_child: ["torso", &hip],
        xyz: [front * HIP_OFFSET[0], left * HIP_OFFSET[1], 0.0],
        // Positive angles move the leg away from the torso.
        axis: [left, 0.0, 0.0],
        limits: Some([-0.4, 0.9]),
        ..revolute
    });
    urdf.link(&thigh, &[(Shape::Box([0.06, 0.05, LENGTH - 0.05]), [0.0, 0.0, -LENGTH / 2.0])]);
    let xyz = [0.0; 3];
    urdf.joint(&JointText { name: &swing, parent_child: [&hip, &thigh], xyz, limits: Some([-1.2, 1.2]), ..revolute });
    urdf.link(&shin, &[(Shape::Mesh("meshes/shin.stl"), [0.0; 3])]);
    let xyz = [0.0, 0.0, -LENGTH];
    urdf.joint(&JointText { name: &knee, parent_child: [&thigh, &shin], xyz, limits: Some([-0.2, 2.2]), ..revolute });
}

fn scene() -> String {
    let mut scene = format!(
        "# A torso held in the world, with four legs that each stand between blocks of their own.\n\
         clearance = 1e-4\nmetric = {{ kind = \"joint\" }}\n\n[[robot]]\nurdf = \"robot/legs.urdf\"\n\
         packages = [\".\"]\ngeometry = \"convex-hull\"\npose = {{ xyz = [0, 0, {HEIGHT}] }}\n"
    );
    for ((leg, [front, left]), blocks) in LEGS.into_iter().zip(BLOCKS) {
        for (k, [size, [x, y, z]]) in blocks.into_iter().enumerate() {
            // Rounds to 0.1 mm, because sums of decimals are not exact.
            let at = [front * (HIP_OFFSET[0] + x), left * (HIP_OFFSET[1] + y), z].map(|v| (v * 1e4).round() / 1e4);
            // Writing to a `String` cannot fail.
            let _ = write!(
                scene,
                "\n[[obstacle]]\nname = \"{leg}_block_{}\"\nshape = {{ box = {size:?} }}\npose = {{ xyz = {at:?} }}\n",
                k + 1
            );
        }
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn every_block_is_named_after_the_leg_whose_it_is() {
        let scene = builtin::scene("four-legs").unwrap();
        for (leg, _) in LEGS {
            assert_eq!(scene.bodies.iter().filter(|body| body.name.starts_with(&format!("{leg}_block"))).count(), 2);
        }
    }
}

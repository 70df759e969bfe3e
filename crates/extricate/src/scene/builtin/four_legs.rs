//! `four-legs`: a torso held in the world, with four legs that each stand between blocks of their
//! own.

use std::fmt::Write;

use super::file::File;
use super::loft::End::Round;
use super::loft::{stl, tube};
use super::urdf_text::{JointText, Shape, UrdfText};

/// Name, and on which side of the torso's centre the hip is: front or hind, left or right.
const LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("front_right", [1.0, -1.0]),
    ("hind_left", [-1.0, 1.0]),
    ("hind_right", [-1.0, -1.0]),
];
/// The hip from the torso's centre \[m\].
const HIP: [f64; 2] = [0.4, 0.25];
/// Height of the torso's centre above the ground \[m\].
const HEIGHT: f64 = 0.5;
/// Length of the thigh, and of the shin \[m\].
const LENGTH: f64 = 0.22;

/// Of each leg, its two blocks: sides, and position from below its hip \[m\], x and y away from
/// the torso's centre. No block is within reach of another leg.
const BLOCKS: [[[[f64; 3]; 2]; 2]; 4] = [
    [[[0.14, 0.3, 0.26], [0.17, 0.0, 0.13]], [[0.36, 0.12, 0.24], [0.0, 0.18, 0.12]]],
    [[[0.12, 0.3, 0.22], [-0.14, 0.03, 0.11]], [[0.14, 0.3, 0.28], [0.19, 0.0, 0.14]]],
    [[[0.14, 0.28, 0.28], [0.18, 0.02, 0.14]], [[0.14, 0.3, 0.22], [-0.16, 0.02, 0.11]]],
    [[[0.32, 0.1, 0.28], [0.04, 0.17, 0.14]], [[0.12, 0.26, 0.26], [-0.15, 0.0, 0.13]]],
];

/// The scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    let mut urdf = UrdfText::new("four-legs");
    urdf.link("torso", &[(Shape::Box([0.9, 0.3, 0.12]), [0.0; 3])]);
    for leg in LEGS {
        add_leg(&mut urdf, leg);
    }
    let shin = tube(&[[0.0, 0.0, 0.0, 0.025], [0.0, 0.0, -0.1, 0.02], [0.0, 0.0, -LENGTH, 0.022]], [Round; 2]);
    (scene(), vec![("robot/legs.urdf".into(), urdf.finish()), ("robot/meshes/shin.stl".into(), stl(&[shin]))])
}

/// A leg hangs down; it spreads about x, and swings and bends its knee about y.
fn add_leg(urdf: &mut UrdfText, (leg, [front, left]): (&str, [f64; 2])) {
    let [hip, thigh, shin] = ["hip", "thigh", "shin"].map(|part| format!("{leg}_{part}"));
    let [spread, swing, knee] = ["spread", "swing", "knee"].map(|joint| format!("{leg}_{joint}"));
    let revolute = JointText { kind: "revolute", axis: [0.0, 1.0, 0.0], ..Default::default() };
    urdf.link(&hip, &[]);
    urdf.joint(&JointText {
        name: &spread,
        parent_child: ["torso", &hip],
        xyz: [front * HIP[0], left * HIP[1], 0.0],
        // Positive is away from the torso.
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
            // To the tenth of a millimetre, as sums of decimals are not exact.
            let at = [front * (HIP[0] + x), left * (HIP[1] + y), z].map(|v| (v * 1e4).round() / 1e4);
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

//! `planar-arm`: three revolute joints in a plane (the first without limits), among cylinders.

use std::fmt::Write;

use super::file::File;
use super::urdf_text::{JointText, Shape, UrdfText};

/// Length of a link \[m\].
const LENGTH: f64 = 0.4;
/// Width and height of a link \[m\].
const WIDTH: f64 = 0.08;
/// Limit of the second and third joint \[rad\].
const LIMIT: f64 = 2.6;
/// x, y and radius of each cylinder \[m\].
const CYLINDERS: [[f64; 3]; 6] = [
    [0.62, 0.3, 0.12],
    [0.1, 0.75, 0.15],
    [-0.55, 0.35, 0.1],
    [-0.6, -0.45, 0.16],
    [0.1, -0.55, 0.1],
    [0.8, -0.35, 0.14],
];

/// Returns the scene file and the robot's files.
pub fn files() -> (String, Vec<File>) {
    let mut scene = String::from(
        "# Three revolute joints in a plane, the first without limits, among cylinders.\nclearance = 1e-4\n\
         metric = { kind = \"joint\" }\n\n[[robot]]\nurdf = \"robot/arm.urdf\"\n",
    );
    for (k, [x, y, radius]) in CYLINDERS.into_iter().enumerate() {
        // Writing to a `String` cannot fail.
        let _ = write!(
            scene,
            "\n[[obstacle]]\nname = \"cylinder_{}\"\nshape = {{ cylinder = [{radius}, 0.4] }}\npose = {{ xyz = [{x}, {y}, 0] }}\n",
            k + 1
        );
    }
    (scene, vec![("robot/arm.urdf".into(), urdf())])
}

fn urdf() -> Vec<u8> {
    let mut urdf = UrdfText::new("planar-arm");
    urdf.link("base", &[]);
    let names = ["base", "link_1", "link_2", "link_3"];
    for k in 1..names.len() {
        let bar = Shape::Box([LENGTH - 2.0 * WIDTH, WIDTH, WIDTH]);
        let hub = Shape::Cylinder([0.6 * WIDTH, WIDTH]);
        urdf.link(names[k], &[(bar, [LENGTH / 2.0, 0.0, 0.0]), (hub, [0.0; 3])]);
        urdf.joint(&JointText {
            name: &format!("joint_{k}"),
            kind: if k == 1 { "continuous" } else { "revolute" },
            parent_child: [names[k - 1], names[k]],
            xyz: [if k == 1 { 0.0 } else { LENGTH }, 0.0, 0.0],
            limits: (k > 1).then_some([-LIMIT, LIMIT]),
            ..Default::default()
        });
    }
    urdf.finish()
}

//! A 7-joint arm with a gripper; it has the published kinematics of the KUKA LBR iiwa 7 R800, and
//! shapes of our own.

use super::file::File;
use super::swept_meshes::End::{Flat, Round};
use super::swept_meshes::{Station, stl, tube};
use super::urdf_text::{JointText, Shape, UrdfText};

/// Height of each joint above the one before it at the zero position \[m\], its axis, and its limit
/// [degrees].
///
/// # Source
/// KUKA, "LBR iiwa 7 R800, LBR iiwa 14 R820: specification", axis data and principal dimensions:
/// the shoulder is 0.340 above the base, then 0.400 to the elbow, 0.400 to the wrist and 0.126 to
/// the flange. How two links share a distance is our choice; it has no effect on the motion.
const JOINTS: [(f64, [f64; 3], f64); 7] = [
    (0.15, [0.0, 0.0, 1.0], 170.0),
    (0.19, [0.0, 1.0, 0.0], 120.0),
    (0.21, [0.0, 0.0, 1.0], 170.0),
    (0.19, [0.0, -1.0, 0.0], 120.0),
    (0.21, [0.0, 0.0, 1.0], 170.0),
    (0.19, [0.0, 1.0, 0.0], 120.0),
    (0.081, [0.0, 0.0, 1.0], 175.0),
];
/// Distance from the last joint to the flange \[m\].
const FLANGE_DISTANCE: f64 = 0.045;

/// Middle line and radius of every link, base first. Links alternate sides at the bending joints,
/// because forearm and upper arm pass each other there.
const LINKS: [&[Station]; 8] = [
    &[[0.0, 0.0, 0.0, 0.105], [0.0, 0.0, 0.07, 0.1], [0.0, 0.0, 0.13, 0.08]],
    &[[0.0, 0.0, -0.015, 0.075], [0.0, 0.0, 0.09, 0.072], [0.0, -0.035, 0.19, 0.06]],
    &[[0.0, 0.045, 0.0, 0.06], [0.0, 0.03, 0.08, 0.06], [0.0, 0.0, 0.2, 0.056]],
    &[[0.0, 0.0, 0.0, 0.056], [0.0, 0.0, 0.09, 0.058], [0.0, 0.03, 0.19, 0.054]],
    &[[0.0, -0.04, 0.0, 0.054], [0.0, -0.025, 0.08, 0.052], [0.0, 0.0, 0.2, 0.048]],
    &[[0.0, 0.0, 0.0, 0.048], [0.0, 0.0, 0.05, 0.045], [0.0, -0.055, 0.12, 0.038], [0.0, -0.07, 0.19, 0.038]],
    &[[0.0, 0.01, 0.0, 0.045], [0.0, 0.0, 0.06, 0.042]],
    &[[0.0, 0.0, -0.01, 0.04], [0.0, 0.0, 0.045, 0.038]],
];

/// Middle line and radius of palm and fingers, in the flange's frame.
const GRIPPER: [&[Station]; 3] = [
    &[[0.0, -0.06, 0.02, 0.022], [0.0, 0.0, 0.025, 0.026], [0.0, 0.06, 0.02, 0.022]],
    &[[0.0, -0.058, 0.03, 0.012], [0.0, -0.062, 0.08, 0.012], [0.0, -0.04, 0.135, 0.008]],
    &[[0.0, 0.058, 0.03, 0.012], [0.0, 0.062, 0.08, 0.012], [0.0, 0.04, 0.135, 0.008]],
];

/// Returns `robot/arm.urdf` and its meshes. The links are `base`, `link_1` to `link_7` and
/// `gripper`, the moving joints `joint_1` to `joint_7`.
pub fn files() -> Vec<File> {
    let mut urdf = UrdfText::new("seven-joint-arm");
    let mut meshes = Vec::new();
    let name = |k: usize| if k == 0 { "base".to_string() } else { format!("link_{k}") };
    for (k, stations) in LINKS.iter().enumerate() {
        let path = format!("meshes/{}.stl", name(k));
        urdf.link(&name(k), &[(Shape::Mesh(&path), [0.0; 3])]);
        let ends = if k == 0 || k == 7 { [Flat; 2] } else { [Round; 2] };
        meshes.push((format!("robot/{path}"), stl(&[tube(stations, ends)])));
    }
    urdf.link("gripper", &[(Shape::Mesh("meshes/gripper.stl"), [0.0; 3])]);
    meshes.push(("robot/meshes/gripper.stl".into(), stl(&GRIPPER.map(|stations| tube(stations, [Round; 2])))));
    for (k, (height, axis, degrees)) in JOINTS.into_iter().enumerate() {
        let limit = f64::to_radians(degrees);
        urdf.joint(&JointText {
            name: &format!("joint_{}", k + 1),
            kind: "revolute",
            parent_child: [&name(k), &name(k + 1)],
            xyz: [0.0, 0.0, height],
            axis,
            limits: Some([-limit, limit]),
            ..Default::default()
        });
    }
    urdf.joint(&JointText {
        name: "flange",
        parent_child: ["link_7", "gripper"],
        xyz: [0.0, 0.0, FLANGE_DISTANCE],
        ..Default::default()
    });
    meshes.insert(0, ("robot/arm.urdf".into(), urdf.finish()));
    meshes
}

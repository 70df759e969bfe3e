//! Tests where the meshes of `package://` addresses are found, and the message if they are not.

use std::fs;
use std::path::Path;

use crate::process::{Finished, Workspace};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// Writes a URDF at `path`, whose one mesh is `package://PACKAGE/meshes/a.obj`.
fn urdf(workspace: &Workspace, path: &str, package: &str) {
    let text = format!(
        "<robot name='r'><link name='a'/><link name='b'><collision><geometry><mesh filename='package://{package}/meshes/a.obj'/>\
         </geometry></collision></link><joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>"
    );
    write(workspace, path, &text);
}

fn write(workspace: &Workspace, path: &str, text: &str) {
    fs::create_dir_all(workspace.path(path).parent().unwrap()).unwrap();
    workspace.write(path, text);
}

/// Runs `info` on `line`; `ros` is a variable of ROS that names package folders, and its value.
fn info(workspace: &Workspace, line: &str, ros: Option<(&str, &Path)>) -> Finished {
    let mut command = workspace.command(&format!("info {line}"));
    command.env_remove("AMENT_PREFIX_PATH").env_remove("ROS_PACKAGE_PATH").envs(ros);
    Finished::new(command.output().unwrap())
}

#[test]
fn packages_are_found_without_a_scene_file() {
    let workspace = Workspace::new();
    let mesh = |folder: &str| write(&workspace, &format!("{folder}/meshes/a.obj"), OBJ);
    // The package that contains the URDF, by its folder's name and by its package.xml.
    mesh("ws/arm");
    urdf(&workspace, "ws/arm/urdf/r.urdf", "arm");
    write(&workspace, "ws/vendor/package.xml", "<package><name>named</name></package>");
    mesh("ws/vendor");
    urdf(&workspace, "ws/vendor/urdf/deep/r.urdf", "named");
    // A package beside it, and one of an installed prefix.
    urdf(&workspace, "ws/leg/r.urdf", "arm");
    mesh("ws/share/installed");
    urdf(&workspace, "ws/leg/installed.urdf", "installed");
    for line in ["ws/arm/urdf/r.urdf", "ws/vendor/urdf/deep/r.urdf", "ws/leg/r.urdf", "ws/leg/installed.urdf"] {
        info(&workspace, line, None).expect_code(0);
    }
    // Folders of the command line, and those of ROS.
    mesh("far/a/hand");
    urdf(&workspace, "ws/hand.urdf", "hand");
    info(&workspace, "ws/hand.urdf --packages ws --packages far/a", None).expect_code(0);
    info(&workspace, "ws/hand.urdf --packages far/a/hand", None).expect_code(0);
    info(&workspace, "ws/hand.urdf", Some(("ROS_PACKAGE_PATH", &workspace.path("far/a")))).expect_code(0);
    info(&workspace, "ws/hand.urdf", Some(("AMENT_PREFIX_PATH", &workspace.path("far/a")))).expect_code(1);
    mesh("far/b/share/hand");
    info(&workspace, "ws/hand.urdf", Some(("AMENT_PREFIX_PATH", &workspace.path("far/b")))).expect_code(0);
    write(&workspace, "s.toml", "[[robot]]\nurdf = 'ws/hand.urdf'\npackages = ['far/a']\n");
    info(&workspace, "s.toml", None).expect_code(0);
    workspace.run("view ws/hand.urdf --packages far/a --q 0 -o page.html").expect_code(0);
}

#[test]
fn what_is_given_comes_first() {
    let workspace = Workspace::new();
    urdf(&workspace, "ws/arm/r.urdf", "arm");
    write(&workspace, "ws/arm/meshes/a.obj", "no mesh");
    info(&workspace, "ws/arm/r.urdf", None).expect_code(1);
    write(&workspace, "better/arm/meshes/a.obj", OBJ);
    info(&workspace, "ws/arm/r.urdf --packages better", None).expect_code(0);
}

#[test]
fn what_was_tried_is_told_in_one_line() {
    let workspace = Workspace::new();
    urdf(&workspace, "ws/r.urdf", "arm");
    let prefix = workspace.path("opt");
    let failed = info(&workspace, "ws/r.urdf --packages far", Some(("AMENT_PREFIX_PATH", &prefix))).expect_code(1);
    let expected = format!(
        "extricate: error: ws/r.urdf: mesh \"package://arm/meshes/a.obj\": not found, tried the package `arm` in `packages`: far; \
         the URDF's folders: {} and the folders above it; AMENT_PREFIX_PATH: {}; ROS_PACKAGE_PATH: not set; add the folder that \
         holds `arm`, or the one whose package.xml calls it so, to `packages`\n",
        workspace.path("ws").canonicalize().unwrap().display(),
        prefix.display(),
    );
    assert_eq!(failed.stderr, expected);
    for (package, told) in [("..", "expected the name of a folder"), ("arm/..", "expected one inside the package")] {
        urdf(&workspace, "ws/r.urdf", package);
        info(&workspace, "ws/r.urdf", None).expect_failure(&[told]);
    }
}

//! Files as strangers write them: walls inside solids, byte order marks, clouds of sensors,
//! senseless limits; and the message if nothing can be free.

use crate::process::Workspace;

/// A ball of radius 0.1 m that can be anywhere.
fn with_a_ball() -> Workspace {
    let workspace = Workspace::new();
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='{axis}'/>\
             <limit lower='-5' upper='5'/></joint>"
        )
    };
    let joints = joint("jx", "w", "x", "1 0 0") + &joint("jy", "x", "y", "0 1 0") + &joint("jz", "y", "ball", "0 0 1");
    workspace.write(
        "ball.urdf",
        format!(
            "<robot name='ball'><link name='w'/><link name='x'/><link name='y'/><link name='ball'><collision><geometry>\
             <sphere radius='0.1'/></geometry></collision></link>{joints}</robot>"
        ),
    );
    workspace
}

/// Clearance of the ball at `q` from an obstacle of this shape, and the warnings.
fn clearance(workspace: &Workspace, shape: &str, q: &str) -> (f64, String) {
    let scene = format!("[[robot]]\nurdf = 'ball.urdf'\n[[obstacle]]\nname = 'm'\nshape = {shape}\n");
    workspace.write("m.toml", scene);
    let done = workspace.run(&format!("check m.toml --q {q} --json")).expect_code(0);
    (done.json()[0]["clearance"].as_f64().unwrap(), done.stderr.clone())
}

/// Two boxes glued along x = 0, which share one wall; a cube with a diagonal wall.
const GLUED: &str = "v -1 -1 -1\nv -1 -1 1\nv -1 1 -1\nv -1 1 1\nv 0 -1 -1\nv 0 -1 1\nv 0 1 -1\nv 0 1 1\nv 1 -1 -1\nv 1 -1 1\n\
    v 1 1 -1\nv 1 1 1\nf 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\nf 9 11 12 10\nf 5 9 10 6\nf 7 8 12 11\n\
    f 5 7 11 9\nf 6 10 12 8\n";
const DIVIDED: &str = "v -1 -1 -1\nv -1 -1 1\nv -1 1 -1\nv -1 1 1\nv 1 -1 -1\nv 1 -1 1\nv 1 1 -1\nv 1 1 1\nf 1 2 4 3\nf 5 7 8 6\n\
    f 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\nf 1 5 8 4\n";

#[test]
fn walls_inside_a_solid_are_left_out_and_told() {
    let workspace = with_a_ball();
    for obj in [GLUED, DIVIDED] {
        workspace.write("m.obj", obj);
        let (clearance, told) = clearance(&workspace, "{ mesh = 'm.obj' }", "0.5,0.3,0.2");
        assert!((clearance + 0.6).abs() < 1e-9, "{clearance}");
        assert!(
            told.contains("m.obj: 2 triangles hang inside a solid by edges with three triangles or more"),
            "{told}"
        );
        assert!(!told.contains("open"), "{told}");
    }
    // Three sheets that meet at one edge enclose nothing, and that edge is not open.
    workspace.write("m.obj", "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n");
    let (_, told) = clearance(&workspace, "{ mesh = 'm.obj' }", "2,2,2");
    assert!(told.contains("its mesh is open: it is a surface, not a solid (open edges are up to "), "{told}");
    assert!(told.contains("; 1 edge has 3 triangles or more: a wall inside, or sheets that meet)"), "{told}");
}

#[test]
fn texts_may_begin_with_a_byte_order_mark() {
    let workspace = with_a_ball();
    workspace.write("m.obj", format!("\u{feff}{GLUED}"));
    assert!((clearance(&workspace, "{ mesh = 'm.obj' }", "0.5,0.3,0.2").0 + 0.6).abs() < 1e-9);
    for (file, text) in [("p.csv", "0,0,0\n1,0,0\n"), ("p.txt", "x y z\n0 0 0\n")] {
        workspace.write(file, format!("\u{feff}{text}"));
        let (clearance, _) = clearance(&workspace, &format!("{{ points = '{file}', radius = 0.1 }}"), "0,0,1");
        assert!((clearance - 0.8).abs() < 1e-9, "{file} {clearance}");
    }
}

#[test]
fn clouds_of_sensors_are_read_without_what_was_not_seen() {
    let workspace = with_a_ball();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        end_header\n0 0 0 9\nnan nan nan 0\n1 0 0 9\n";
    let pcd = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n\
        VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0 9\nnan nan nan 0\n1 0 0 9\n";
    let text = "0 0 0 255 0 0\nnan nan nan 0 0 0\n1 0 0 255 0 0\n";
    for (file, content) in [("c.ply", ply), ("c.pcd", pcd), ("c.xyz", text)] {
        workspace.write(file, content);
        let (clearance, told) = clearance(&workspace, &format!("{{ points = '{file}', radius = 0.05 }}"), "0,0,1");
        assert!((clearance - 0.85).abs() < 1e-9, "{file} {clearance}");
        assert!(told.contains("obstacle `m`: 1 of 3 points is left out: it has a coordinate that is NaN"), "{told}");
    }
    // The error for a mesh without faces advises points.
    workspace.write("m.toml", "[[robot]]\nurdf = 'ball.urdf'\n[[obstacle]]\nname = 'm'\nshape = { mesh = 'c.ply' }\n");
    workspace.run("check m.toml --q 0,0,1").expect_failure(&["an obstacle takes such a file as `points`"]);
}

#[test]
fn limits_of_the_scene_replace_those_that_make_no_sense() {
    let workspace = with_a_ball();
    let ball = std::fs::read_to_string(workspace.path("ball.urdf")).unwrap();
    for limits in ["lower='1' upper='-1'", "lower='-inf' upper='inf'"] {
        workspace.write("ball.urdf", ball.replacen("lower='-5' upper='5'", limits, 1));
        let obstacle = "[[obstacle]]\nname = 'm'\nshape = { sphere = 0.1 }\n";
        workspace.write("m.toml", format!("[[robot]]\nurdf = 'ball.urdf'\nlimits = {{ jx = [-1, 1] }}\n{obstacle}"));
        let done = workspace.run("check m.toml --q 0.05,0,0 --json").expect_code(0);
        assert!((done.json()[0]["clearance"].as_f64().unwrap() + 0.15).abs() < 1e-9);
        workspace.write("m.toml", format!("[[robot]]\nurdf = 'ball.urdf'\n{obstacle}"));
        let key = "`limits = { jx = [lower, upper] }`";
        workspace.run("check m.toml --q 0.05,0,0").expect_failure(&["joint \"jx\": got ", key]);
    }
}

/// The first link is inside the ground at every configuration.
#[test]
fn what_collides_wherever_one_looks_is_named_by_query_and_escape() {
    let workspace = Workspace::new();
    workspace.write(
        "arm.urdf",
        "<robot name='arm'><link name='base'/><link name='l1'><collision><origin xyz='0 0 0.1'/><geometry><capsule \
         radius='0.06' length='0.2'/></geometry></collision></link><link name='l2'><collision><origin xyz='0.2 0 0' \
         rpy='0 1.5708 0'/><geometry><capsule radius='0.04' length='0.3'/></geometry></collision></link><joint name='j1' \
         type='revolute'><parent link='base'/><child link='l1'/><axis xyz='0 0 1'/><limit lower='-3' upper='3'/></joint>\
         <joint name='j2' type='revolute'><origin xyz='0 0 0.2'/><parent link='l1'/><child link='l2'/><axis xyz='0 1 0'/>\
         <limit lower='-2' upper='2'/></joint></robot>",
    );
    let ground = "[[obstacle]]\nname = 'ground'\nshape = { half-space = [0, 0, 1] }\n";
    workspace.write("ground.toml", format!("[[robot]]\nurdf = 'arm.urdf'\n{ground}"));
    let line = "[pairs] disable = [[\"l1\", \"ground\"]]";
    for command in ["query", "escape"] {
        let done = workspace.run(&format!("{command} ground.toml --q=0,0.2 --json"));
        assert!(done.stderr.contains(line), "{}", done.stderr);
        let rows = done.expect_code(1).json();
        assert!(rows[0]["error"].as_str().unwrap().contains(line), "{}", rows[0]);
        let text = workspace.run(&format!("{command} ground.toml --q=0,0.2")).expect_code(1).stderr;
        assert!(text.lines().last().unwrap().contains(line), "{text}");
    }
    workspace.write("ground.toml", format!("[[robot]]\nurdf = 'arm.urdf'\n{ground}{}\n", line.replace("] d", "]\nd")));
    let rows = workspace.run("escape ground.toml --q=0,0.9 --json").expect_code(0).json();
    assert!(rows[0].get("error").is_none() && rows[0]["method"] != serde_json::Value::Null, "{}", rows[0]);
}

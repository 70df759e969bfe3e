//! Tests robots that are written here, valid and broken.

use std::sync::Arc;

use crate::math::{Pose, Vec3};
use crate::robot::urdf::*;
use crate::robot::{Geometry, JointKind, TriangleMesh};

const LINKS: &str = "<link name='a'/><link name='b'/><link name='c'/>";

fn joint(name: &str, kind: &str, parent: &str, child: &str, more: &str) -> String {
    format!("<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{more}</joint>")
}

fn robot(content: &str) -> Result<Robot> {
    parse("r.urdf", &format!("<robot name='r'>{content}</robot>"), Shapes::Collision, &mut tetrahedron, &mut vec![])
}

fn tetrahedron(name: &str, scale: [f64; 3]) -> Result<Arc<TriangleMesh>> {
    if name != "t.stl" {
        return Err(Error::input(name, "file", "missing"));
    }
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].to_vec();
    Ok(Arc::new(TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).scaled(scale)))
}

#[track_caller]
fn assert_error(content: &str, expected: &str) {
    let message = robot(content).unwrap_err().to_string();
    assert!(message.contains(expected), "{message}");
    assert!(message.starts_with("r.urdf: "), "{message}");
}

#[test]
fn every_joint_type_is_read() {
    let links: String = (0..8).map(|k| format!("<link name='{k}'/>")).collect();
    let limit = "<limit effort='1' lower='-1' upper='2'/><safety_controller soft_lower_limit='0' k_velocity='1'/>";
    let kinds = ["fixed", "revolute", "continuous", "prismatic", "planar", "spherical", "floating"];
    let joints: String = kinds
        .iter()
        .enumerate()
        .map(|(k, kind)| joint(kind, kind, "0", &(k + 1).to_string(), &format!("<axis xyz='0 0 2'/>{limit}")))
        .collect();
    let robot = robot(&(links + &joints)).unwrap();
    let limits: Vec<bool> = robot.joints.iter().map(|joint| joint.limits == Some((-1.0, 2.0))).collect();
    assert_eq!(limits, [false, true, false, true, true, false, true]);
    assert!(robot.joints.iter().all(|joint| joint.axis == Vec3::z() && joint.parent == 0));
    assert_eq!(robot.joints[5].kind, JointKind::Spherical);
    assert_eq!((robot.root, robot.name.as_str()), (0, "r"));
}

#[test]
fn every_geometry_is_read() {
    let collision = |origin: &str, shape: &str| format!("<collision>{origin}<geometry>{shape}</geometry></collision>");
    let origin = "<origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>";
    let content = [
        "<visual><geometry><mesh filename='none'/></geometry><material name='m'><texture/></material></visual>".into(),
        collision(origin, "<box size='2 4 6'/>"),
        collision("<origin quat_xyzw='0 0 2 2'/>", "<sphere radius='.5'/>"),
        collision("", "<cylinder radius='1' length='3'/>"),
        collision("", "<capsule radius='1' length='3'/>"),
        collision("", "<mesh filename='t.stl' scale='-1 2 1e0'/>"),
        collision("", "<mesh filename='t.stl' scale='-1 2 1'/>"),
        "<collision/>".into(),
    ];
    let mut warnings = vec![];
    let text =
        format!("<robot name='r'><link name='a'>{}</link><material><texture/></material></robot>", content.concat());
    let robot = parse("r.urdf", &text, Shapes::Collision, &mut tetrahedron, &mut warnings).unwrap();
    let parts = &robot.links[0].collision;
    let quaternion = Pose::from_xyz_rpy([0.0; 3], [0.0, 0.0, std::f64::consts::FRAC_PI_2]).rotation;
    assert!((parts[1].pose_link_geometry.rotation - quaternion).norm() < 1e-15);
    assert_eq!(warnings, ["r.urdf: link \"a\": a <collision> without geometry is ignored"]);
    assert!((parts[0].pose_link_geometry.point(&Vec3::x()) - Vec3::new(1., 3., 3.)).norm() < 1e-15);
    assert!((parts[1].pose_link_geometry.point(&Vec3::x()) - Vec3::y()).norm() < 1e-15);
    assert!(matches!(parts[0].geometry, Geometry::Box { half_extents } if half_extents == [1., 2., 3.]));
    assert!(matches!(parts[1].geometry, Geometry::Sphere { radius: 0.5 }));
    assert!(matches!(parts[2].geometry, Geometry::Cylinder { radius: 1.0, half_length: 1.5 }));
    assert!(matches!(parts[3].geometry, Geometry::Capsule { radius: 1.0, half_length: 1.5 }));
    let (Geometry::Mesh(first), Geometry::Mesh(second)) = (&parts[4].geometry, &parts[5].geometry) else { panic!() };
    assert_eq!(first, second);
    let moments = parts[4].geometry.volume_moments().unwrap();
    assert!((moments.measure - 1.0 / 3.0).abs() < 1e-15);
    assert!((moments.centroid - Vec3::new(-0.25, 0.5, 0.25)).norm() < 1e-15);
}

#[test]
fn shapes_that_make_no_sense_are_named() {
    for (shape, expected) in [
        ("<box size='1 -1 1'/>", "link \"a\": got size=\"1 -1 1\", expected positive sizes"),
        ("<box size='1 x 2 3'/>", "got size=\"1 x 2 3\", expected 3 finite numbers"),
        ("<box size='1 1'/>", "got size=\"1 1\", expected 3 finite numbers"),
        ("<sphere radius='-1'/>", "got radius=\"-1\", expected a positive size"),
        ("<cylinder radius='0' length='-1'/>", "expected a positive size"),
        ("<sphere radius='NaN'/>", "got radius=\"NaN\", expected a finite number"),
        ("<sphere radius='${r}'/>", "xacro"),
        ("<cylinder radius='1'/>", "got <cylinder> without the attribute `length`"),
        ("<mesh filename='t.stl' scale='1 0 1'/>", "expected factors of size 1e-9 to 1e9, not zero"),
        ("<mesh/>", "without the attribute `filename`"),
        ("<plane normal='0 0 0'/>", "got the normal [0.0, 0.0, 0.0], expected one that points somewhere"),
        ("<plane><normal>up</normal></plane>", "got normal=\"up\", expected 3 finite numbers"),
        ("<cone/>", "got geometry <cone>, expected box, sphere"),
    ] {
        assert_error(&format!("<link name='a'><collision><geometry>{shape}</geometry></collision></link>"), expected);
    }
    let missing = "<link name='a'><collision><geometry><mesh filename='x'/></geometry></collision></link>";
    assert_eq!(robot(missing).unwrap_err().to_string(), "x: file: missing");
}

#[test]
fn shapes_without_volume_are_told() {
    let read = |shape: &str| {
        let mut warnings = vec![];
        let text = format!("<link name='a'><collision><geometry>{shape}</geometry></collision></link>");
        let robot = parse(
            "r.urdf",
            &format!("<robot name='r'>{text}</robot>"),
            Shapes::Collision,
            &mut tetrahedron,
            &mut warnings,
        )
        .unwrap();
        (robot.links[0].collision.first().map(|part| part.geometry.clone()), warnings)
    };
    for (shape, told) in [
        ("<box size='0 0 0'/>", "size=\"0 0 0\""),
        ("<box size='1 0 0'/>", "size=\"1 0 0\""),
        ("<sphere radius='0'/>", "radius=\"0\""),
        ("<cylinder radius='0' length='1'/>", "radius=\"0\" length=\"1\""),
        ("<capsule radius='0.0' length='1'/>", "radius=\"0\" length=\"1\""),
    ] {
        let warnings = vec![format!("r.urdf: link \"a\": a collision geometry with {told} is taken for none")];
        assert_eq!(read(shape), (None, warnings));
    }
    let (plate, warnings) = read("<box size='1 0 2'/>");
    assert_eq!(plate, Some(Geometry::Box { half_extents: [0.5, 5e-7, 1.0] }));
    assert!(warnings[0].contains("size=\"1 0 2\" is taken for 1e-6 m thick"), "{warnings:?}");
    let (disc, _) = read("<cylinder radius='1' length='0'/>");
    assert_eq!(disc, Some(Geometry::Cylinder { radius: 1.0, half_length: 5e-7 }));
    assert_eq!(read("<capsule radius='1' length='0'/>"), (Some(Geometry::Sphere { radius: 1.0 }), vec![]));
}

#[test]
fn planes_are_half_spaces() {
    let read = |plane: &str| {
        let text = format!("<link name='a'><collision><geometry>{plane}</geometry></collision></link>");
        robot(&text).unwrap().links[0].collision[0].geometry.clone()
    };
    let below = |normal: Vec3| Geometry::HalfSpace { normal: normal.into(), offset: 0.0 };
    assert_eq!(read("<plane/>"), below(Vec3::z()));
    assert_eq!(read("<plane normal='0 2 0'/>"), below(Vec3::y()));
    assert_eq!(read("<plane normal='0,0,-1'><size>5 5</size></plane>"), below(-Vec3::z()));
    assert_eq!(read("<plane><normal>1 0 0</normal><size>1 1</size></plane>"), below(Vec3::x()));
}

#[test]
fn robots_that_can_only_be_seen_are_told_and_visuals_may_be_taken() {
    let shape = "<geometry><sphere radius='1'/></geometry>";
    let link = |name: &str, tag: &str| format!("<link name='{name}'><{tag}>{shape}</{tag}></link>");
    let read = |links: &str, shapes: Shapes| {
        let mut warnings = vec![];
        let text = format!("<robot name='r'>{links}{}</robot>", joint("j", "fixed", "a", "b", ""));
        let robot = parse("r.urdf", &text, shapes, &mut tetrahedron, &mut warnings).unwrap();
        (robot.links.iter().map(|link| link.collision.len()).collect::<Vec<_>>(), warnings)
    };
    let seen = link("a", "visual") + &link("b", "visual");
    let (parts, warnings) = read(&seen, Shapes::Collision);
    assert_eq!((parts, warnings.len()), (vec![0, 0], 1));
    assert!(warnings[0].starts_with("r.urdf: no link has <collision> geometry") && warnings[0].contains("(a, b)"));
    assert_eq!(read(&seen, Shapes::Visual), (vec![1, 1], vec![]));
    let mixed = link("a", "visual") + &link("b", "collision");
    assert_eq!(read(&mixed, Shapes::Collision), (vec![0, 1], vec![]));
    assert_eq!(read(&mixed, Shapes::Visual), (vec![1, 0], vec![]));
    assert_eq!(read("<link name='a'/><link name='b'/>", Shapes::Collision).1, Vec::<String>::new());
}

#[test]
fn visuals_have_the_colours_of_their_materials() {
    let visual = |material: &str| format!("<visual><geometry><sphere radius='1'/></geometry>{material}</visual>");
    let own = "<material name='own'><color rgba='0.1 0.2 0.3 1'/></material>";
    let materials = [
        "<material name='late'/>",
        own,
        "<material name='own'/>",
        "<material name='nobody'/>",
        "",
        "<material name='wrong'><color rgba='255 0 0 1'/></material>",
        "<material><color rgba='1 0'/></material>",
    ];
    let shapes: String = materials.map(visual).concat();
    let late = "<material name='late'><color rgba='1 0 0 0.5'/></material>";
    let text = format!("<robot name='r'><link name='a'>{shapes}</link>{late}</robot>");
    let robot = parse("r.urdf", &text, Shapes::Visual, &mut tetrahedron, &mut vec![]).unwrap();
    let colours: Vec<_> = robot.links[0].collision.iter().map(|shape| shape.rgba).collect();
    let (late, own) = (Some([1.0, 0.0, 0.0, 0.5]), Some([0.1, 0.2, 0.3, 1.0]));
    assert_eq!(colours, [late, own, own, None, None, None, None]);
}

#[test]
fn what_is_not_one_tree_is_named() {
    let with = |joints: &[String]| LINKS.to_owned() + &joints.concat();
    let fixed = |name, parent, child| joint(name, "fixed", parent, child, "");
    assert_error("", "robot: got no links");
    assert_error(LINKS, "robot: got 3 root links (\"a\", \"b\", \"c\"), expected one");
    assert_error(
        &with(&[fixed("j", "a", "b"), fixed("k", "c", "b")]),
        "link \"b\": got two parent joints, \"j\" and \"k\"",
    );
    assert_error(&with(&[fixed("j", "a", "b"), fixed("k", "b", "c"), fixed("l", "c", "a")]), "got a cycle through all");
    assert_error(&with(&[fixed("j", "b", "c"), fixed("k", "c", "b")]), "got a cycle of joints (\"b\", \"c\")");
    assert_error(&with(&[fixed("j", "a", "a")]), "got");
    assert_error(&with(&[fixed("j", "a", "d")]), "joint \"j\": got child link=\"d\", expected a link of this robot");
    assert_error(&with(&["<joint name='j' type='fixed'/>".into()]), "joint \"j\": got no <parent>");
    assert_error(&with(&[fixed("j", "a", "b"), fixed("j", "b", "c")]), "joint \"j\": got a second joint of this name");
    assert_error("<link name='a'/><link name='a'/>", "link \"a\": got a second link of this name");
    assert_error("<link/>", "<link> in line 1: got <link> without the attribute `name`");
}

#[test]
fn joints_that_make_no_sense_are_named() {
    let error = |kind: &str, more: &str, expected: &str| {
        assert_error(&format!("<link name='a'/><link name='b'/>{}", joint("j", kind, "a", "b", more)), expected);
    };
    error("hinge", "", "joint \"j\": got type=\"hinge\", expected fixed, revolute");
    error("prismatic", "<limit lower='2' upper='1'/>", "got limits 2 to 1, expected lower <= upper");
    error(
        "revolute",
        "<limit lower='-inf' upper='1'/>",
        "got limits -inf to 1, expected `lower` and `upper`, both finite",
    );
    error("revolute", "<limit lower='nan' upper='1'/>", "got lower=\"nan\", expected a finite number");
    error("prismatic", "<limit lower='2' upper='1'/>", "or `limits = { j = [lower, upper] }` in its [[robot]]");
    error("continuous", "<axis xyz='0 0 0'/>", "got axis xyz=\"0 0 0\", expected one that is not zero");
    error("continuous", "<origin xyz='0 0 x'/>", "got xyz=\"0 0 x\"");
    error("continuous", "<mimic joint='j'/>", "joint \"j\": got mimic joint=\"j\" in a cycle");
    error("floating", "<mimic joint='j'/>", "got mimic on the Floating joint \"j\"");
    let mut warnings = vec![];
    let alone = joint("j", "revolute", "a", "b", "<mimic joint='k'/><limit lower='0' upper='1'/>");
    let text = format!("<robot><link name='a'/><link name='b'/>{alone}</robot>");
    let robot = parse("r.urdf", &text, Shapes::Collision, &mut tetrahedron, &mut warnings).unwrap();
    assert!(robot.joints[0].mimic.is_none() && robot.joints[0].limits == Some((0.0, 1.0)));
    assert!(warnings[0].contains("joint \"j\": it follows \"k\", which is no joint of this robot"), "{warnings:?}");
    error("continuous", "<origin xyz='0 0 1e300'/>", "expected 3 finite numbers within 1e9");
    let mut warnings = vec![];
    let still = format!(
        "<robot>{LINKS}{}{}</robot>",
        joint("j", "revolute", "a", "b", "<limit/>"),
        joint("k", "fixed", "b", "c", "")
    );
    let robot = parse("r.urdf", &still, Shapes::Collision, &mut tetrahedron, &mut warnings).unwrap();
    assert_eq!(robot.joints[0].limits, Some((0.0, 0.0)));
    assert_eq!((robot.joints[0].axis, warnings.len()), (Vec3::x(), 1));
}

#[test]
fn limits_that_bound_nothing_are_none() {
    let read = |kind: &str, limit: &str, warned: usize| {
        let mut warnings = vec![];
        let text =
            format!("<robot name='r'><link name='a'/><link name='b'/>{}</robot>", joint("j", kind, "a", "b", limit));
        let joint =
            parse("r.urdf", &text, Shapes::Collision, &mut tetrahedron, &mut warnings).unwrap().joints.remove(0);
        assert_eq!(warnings.len(), warned, "{warnings:?}");
        (joint.kind, joint.limits)
    };
    let wide = "<limit lower='-1e+16' upper='1e+16'/>";
    assert_eq!(read("revolute", wide, 1), (JointKind::Continuous, None));
    assert_eq!(read("prismatic", wide, 0), (JointKind::Prismatic, None));
    let infinite = "<limit lower=' -inf' upper='+Infinity '/>";
    assert_eq!(read("revolute", infinite, 1), (JointKind::Continuous, None));
    assert_eq!(read("prismatic", infinite, 0), (JointKind::Prismatic, None));
    assert_eq!(read("planar", infinite, 0), (JointKind::Planar, None));
    assert_eq!(read("revolute", "", 0), (JointKind::Revolute, None));
    assert_eq!(read("planar", "", 0), (JointKind::Planar, None));
}

#[test]
fn limits_that_are_not_stated_are_zero_before_version_1_2_and_an_error_from_then_on() {
    let read = |version: &str, kind: &str, limit: &str| {
        let joint = joint("j", kind, "a", "b", limit);
        let text = format!("<robot version='{version}'><link name='a'/><link name='b'/>{joint}</robot>");
        parse("r.urdf", &text, Shapes::Collision, &mut tetrahedron, &mut vec![]).map(|robot| robot.joints[0].limits)
    };
    for version in ["1.0", "1.1", "new"] {
        assert_eq!(read(version, "revolute", "<limit upper='1' effort='-1' velocity='x'/>").unwrap(), Some((0.0, 1.0)));
    }
    let message = read("1.2", "revolute", "<limit upper='1'/>").unwrap_err().to_string();
    assert!(message.contains("joint \"j\": got limits -inf to 1, expected `lower` and `upper`"), "{message}");
    let message = read("1.2", "revolute", "<limit lower='2' upper='1'/>").unwrap_err().to_string();
    assert!(message.contains("joint \"j\": got limits 2 to 1, expected lower <= upper"), "{message}");
    assert_eq!(read("1.2", "prismatic", "<limit lower='-1' upper='1'/>").unwrap(), Some((-1.0, 1.0)));
    assert_eq!(read("1.2", "prismatic", "<limit/>").unwrap(), None);
    for version in ["1.0", "1.2"] {
        assert_eq!(read(version, "planar", "").unwrap(), None);
        assert_eq!(read(version, "floating", "<limit lower='1'/>").unwrap(), None);
        assert_eq!(read(version, "planar", "<limit lower='0' upper='0'/>").unwrap(), Some((0.0, 0.0)));
    }
}

#[test]
fn names_keep_every_character() {
    let name = "a&amp;&lt;b&gt; \"c&apos; \u{2028}\u{e9}&#10;&#9;d";
    let text = format!("<robot><link name='{name}'/><link name='b'/>{}</robot>", joint("j", "fixed", name, "b", ""));
    let robot = parse("r.urdf", &text, Shapes::Collision, &mut tetrahedron, &mut vec![]).unwrap();
    assert_eq!(robot.links[0].name, "a&<b> \"c' \u{2028}\u{e9}\n\td");
    assert_eq!(robot.joints[0].parent, 0);
}

#[test]
fn truncation_never_panics() {
    let part =
        "<collision><origin quat_xyzw='0 0 2 2'/><geometry><capsule radius='1' length='3'/></geometry></collision>";
    let mimic = joint("k", "prismatic", "b", "c", "<axis xyz='0 0 1'/><mimic joint='j' offset='1'/>");
    let joint = joint("j", "revolute", "a", "b", "<limit lower='-1' upper='1'/>");
    let good = format!("<robot name='r'><link name='a'>{part}</link>{LINKS}{joint}{mimic}</robot>").replacen(
        "<link name='a'/>",
        "",
        1,
    );
    for length in 0..=good.len() {
        assert_eq!(
            parse("r.urdf", &good[..length], Shapes::Collision, &mut tetrahedron, &mut vec![]).is_ok(),
            length == good.len()
        );
    }
}

#[test]
fn mimic_chains_end_at_an_independent_joint() {
    let links: String = "abcd".chars().map(|c| format!("<link name='{c}'/>")).collect();
    let leader = joint("l", "prismatic", "a", "b", "<limit lower='0' upper='1'/>");
    let middle = joint("m", "revolute", "a", "c", "<mimic joint='l' multiplier='2' offset='3'/>");
    let follower = joint("f", "revolute", "a", "d", "<mimic joint='m' multiplier='-5' offset='7'/>");
    let found = robot(&format!("{links}{follower}{middle}{leader}")).unwrap();
    let mimic = found.joints[0].mimic.unwrap();
    assert_eq!((mimic.joint, mimic.multiplier, mimic.offset), (2, -10.0, -8.0));
    assert!(found.joints[0].limits.is_none() && found.joints[2].mimic.is_none());
    let still = joint("l", "fixed", "a", "b", "");
    let found = robot(&format!("{links}{follower}{middle}{still}")).unwrap();
    let mimic = found.joints[0].mimic.unwrap();
    assert_eq!((found.joints[mimic.joint].kind, mimic.offset), (JointKind::Fixed, -8.0));
    let ball = joint("l", "spherical", "a", "b", "");
    assert_error(&format!("{links}{follower}{middle}{ball}"), "got mimic of the Spherical joint \"l\"");
    let back = joint("l", "continuous", "a", "b", "<mimic joint='f'/>");
    assert_error(&format!("{links}{follower}{middle}{back}"), "in a cycle");
    let large = |name, of, kind| joint(name, kind, "a", "c", &format!("<mimic joint='{of}' multiplier='1e6'/>"));
    let [once, twice] = [large("m", "l", "revolute"), large("f", "m", "revolute").replace("'c'", "'d'")];
    let beyond = format!("{links}{once}{twice}{leader}");
    assert_error(&beyond, "joint \"f\": got a position of 1000000000000 times that of joint \"l\" and 0 more");
    let far = joint("l", "prismatic", "a", "b", "<limit lower='0' upper='1e5'/>");
    let slide = large("f", "l", "prismatic").replace("'c'", "'d'");
    assert_error(&format!("{links}{middle}{slide}{far}"), "which comes to 100000000000");
}

#[test]
fn macros_are_not_urdf() {
    let parse =
        |text: &str| parse("r.xacro", text, Shapes::Collision, &mut tetrahedron, &mut vec![]).unwrap_err().to_string();
    assert!(parse("<robot><xacro:include filename='x'/></robot>").contains("line 1: got a xacro macro"));
    let declared = "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>\n<xacro:include filename='x'/></robot>";
    assert!(parse(declared).contains("line 2: got a xacro macro"));
    assert!(parse("<mujoco/>").contains("root: got <mujoco>, expected <robot>: this is MJCF; in Python"));
    assert!(parse("<sdf/>").contains("root: got <sdf>, expected <robot>: this is SDF; in Python"));
    assert!(parse("<a/>").contains("root: got <a>, expected <robot>"));
    assert!(parse("<robot><link").contains("expected URDF"));
}

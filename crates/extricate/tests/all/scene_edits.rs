//! Edited scenes, attached objects, clearances of pairs, and solvers that share what is prepared.

use std::path::Path;

use extricate::geometry::{Body, Geometry, Pose};
use extricate::internals::math::Vec3;
use extricate::internals::scene::assemble::assemble;
use extricate::internals::scene::file::world_file::in_world;
use extricate::{Answer, PairId, Scene, Solver, builtin};

use crate::baselines::PAIR_CLEARANCE_BOUND_METRES;

/// A robot: a palm on a rail along x, with two fingers that open along y.
const GRIPPER: &str = r#"<robot name="gripper"><link name="rail"/>
    <link name="palm"><collision><geometry><box size="0.1 0.2 0.1"/></geometry></collision></link>
    <link name="left"><collision><geometry><box size="0.1 0.02 0.05"/></geometry></collision></link>
    <link name="right"><collision><geometry><box size="0.1 0.02 0.05"/></geometry></collision></link>
    <link name="tip"/>
    <joint name="slide" type="prismatic"><parent link="rail"/><child link="palm"/><axis xyz="1 0 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="tip_joint" type="fixed"><parent link="palm"/><child link="tip"/><origin xyz="0.3 0 0"/></joint>
    <joint name="grip" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>
      <limit lower="0.01" upper="0.08" effort="1" velocity="1"/></joint>
    <joint name="grip2" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>
      <mimic joint="grip"/><limit lower="0.01" upper="0.08" effort="1" velocity="1"/></joint></robot>"#;

const WALL: &str = "[[obstacle]]\nname = 'wall'\nshape = { box = [0.2, 1.0, 1.0] }\npose = { xyz = [0.6, 0, 0] }\n";
const ROD: &str = "[[attached]]\nname = 'rod'\nlink = 'palm'\nshape = { box = [0.4, 0.04, 0.04] }\n\
                   pose = { xyz = [0.3, 0, 0] }\ntouch = ['left', 'right']\n";

fn gripper(head: &str, tail: &str) -> Scene {
    try_gripper(head, tail).unwrap()
}

fn try_gripper(head: &str, tail: &str) -> extricate::Result<Scene> {
    let text = format!("{head}\n[[robot]]\nurdf = 'gripper.urdf'\n{WALL}{tail}");
    assemble(Path::new("scene.toml"), &text, &mut |_: &Path| Ok(GRIPPER.as_bytes().to_vec()))
}

fn ask(world: &Solver, q: &[f64]) -> Answer {
    let q = world.scene().space().config(q).unwrap();
    world.query(&q).unwrap()
}

fn colliding(answer: &Answer, scene: &Scene) -> Vec<String> {
    answer.colliding.iter().map(|pair| scene.pair_names(*pair).join(" ")).collect()
}

fn rod() -> Body {
    let half_extents = [0.2, 0.02, 0.02];
    Body::obstacle("rod", Geometry::Box { half_extents }, Pose::translation(Vec3::new(0.3, 0.0, 0.0)))
}

#[test]
fn what_a_link_holds_moves_with_it_and_may_touch_what_is_named() {
    let from_tip = {
        let mut rod = rod();
        rod.parts[0].pose_frame_part = Pose::identity();
        gripper("", "").attached(rod, "tip", &["left", "right"]).unwrap()
    };
    for scene in [gripper("", ROD), gripper("", "").attached(rod(), "palm", &["left", "right"]).unwrap(), from_tip] {
        let world = Solver::new(scene);
        let answer = ask(&world, &[0.05, 0.025]);
        assert_eq!(colliding(&answer, world.scene()), ["wall rod"]);
        assert!((answer.depth - 0.0501).abs() < 1e-5, "{}", answer.depth);
        assert!((answer.witness[0] + 1e-4).abs() < 1e-5 && answer.lower_bound <= answer.depth);
        assert!(ask(&world, &[-0.001, 0.025]).is_free());
    }
    // Without the exceptions for the fingers, a bar across the palm's side hits them.
    let held = gripper("", "").attached(rod(), "palm", &[]).unwrap();
    assert_eq!(colliding(&ask(&Solver::new(held.clone()), &[-0.5, 0.025]), &held), ["left rod", "right rod"]);
    let let_go = held.without(["rod"]).unwrap();
    assert_eq!((let_go.bodies(), let_go.pairs()), (gripper("", "").bodies(), gripper("", "").pairs()));
}

#[test]
fn pairs_keep_clearances_of_their_own() {
    for (head, tail) in [
        ("clearance = 0.02", "[pairs]\nclearance = [['left', 'right', 1e-4]]"),
        ("clearance = { self = 1e-4, world = 0.02 }", ""),
        ("padding = { left = 0.0199, right = 0.0199 }", ""),
        ("padding = { wall = 0.0199 }", ""),
    ] {
        let world = Solver::new(gripper(head, tail));
        let answer = ask(&world, &[0.34, 0.015]);
        assert_eq!(colliding(&answer, world.scene()), ["left wall", "right wall"], "{head}");
        assert!((answer.witness[0] - 0.33).abs() < 1e-4 && (answer.witness[1] - 0.015).abs() < 1e-9, "{answer:?}");
        assert!((answer.depth - 0.01).abs() < 1e-5 && answer.lower_bound <= answer.depth);
        assert!(answer.lower_bound > PAIR_CLEARANCE_BOUND_METRES, "{answer:?}");
        for contact in &answer.contacts {
            assert!((contact.distance - 0.02).abs() < 2e-4, "{contact:?}");
        }
        assert!(ask(&world, &[0.32, 0.0102]).is_free());
    }
    // Shallow queries of a wide clearance: the bodies are near and do not overlap.
    let world = Solver::new(gripper("clearance = 0.05", ""));
    for by in [1e-4, 0.01, 0.04, 0.049, 0.06] {
        let answer = ask(&world, &[0.3 + by, 0.06]);
        assert!((answer.depth - by).abs() < 2e-6, "{by}: {answer:?}");
    }
    // With one clearance for all pairs, the fingers are too near each other.
    let world = Solver::new(gripper("clearance = 0.02", ""));
    assert!(colliding(&ask(&world, &[0.34, 0.015]), world.scene()).contains(&"left right".to_string()));
}

#[test]
fn faults_in_clearances_and_attached_objects_are_named() {
    let message = |head: &str, tail: &str| try_gripper(head, tail).unwrap_err().to_string();
    assert!(message("clearance = { world = -1 }", "").contains("clearance: got -1, expected 0 to 1e9"));
    assert!(message("clearance = { wrld = 1 }", "").contains("`wrld`"));
    assert!(message("clearance = 'x'", "").contains("expected a number, or a table `{ world = .., self = .. }`"));
    assert!(message("padding = { pam = 0.1 }", "").contains("padding: got `pam`, expected one of"));
    assert!(message("padding = { palm = -0.1 }", "").contains("padding: palm: got -0.1"));
    let pair = message("", "[pairs]\nclearance = [['left', 'wal', 0.1]]");
    assert!(pair.contains("pairs: clearance [\"left\", \"wal\"]: got `wal`"), "{pair}");
    assert!(message("", &ROD.replace("palm", "plam")).contains("attached \"rod\": link: got `plam`"));
    assert!(message("", &ROD.replace("'right'", "'rght'")).contains("attached \"rod\": touch"));
    assert!(message("", &ROD.replace("'rod'", "'wall'")).contains("occurs twice"));
    assert!(message("", &ROD.replace("'rod'", "'left'")).contains("a link has the same name"));
    let scene = gripper("", "");
    let refused = |scene: extricate::Result<Scene>| scene.unwrap_err().to_string();
    assert!(refused(scene.attached(rod(), "plam", &[])).contains("got `plam`, expected one of `rail`"));
    assert!(refused(scene.moved([("left", Pose::identity())])).contains("got `left`, expected one of `wall`"));
    assert!(refused(scene.moved([("wall", Pose::translation(Vec3::new(f64::NAN, 0.0, 0.0)))])).contains("NaN"));
    assert!(refused(scene.without(["box"])).contains("obstacle \"box\": got `box`"));
    assert!(refused(scene.disabled([["left", "box"]])).contains("pair [\"left\", \"box\"]"));
    let twice = Body { name: "palm".into(), ..rod() };
    assert!(refused(scene.with_obstacles([twice])).contains("the name is taken"));
    // A link without geometry has a name too.
    let tip = || Body { name: "tip".into(), ..rod() };
    assert!(refused(scene.with_obstacles([tip()])).contains("the name is taken"));
    assert!(refused(scene.attached(tip(), "palm", &[])).contains("the name is taken"));
}

#[test]
fn a_world_may_enable_neighbours_and_disable_pairs() {
    let scene = gripper("", "");
    let mut read = |_: &Path| -> extricate::Result<Vec<u8>> { panic!("nothing to read") };
    let mut pairs = |text: &str| {
        let text = format!("[pairs]\n{text}");
        in_world(&scene, Path::new("w.toml"), &text, &mut read).map_err(|error| error.to_string()).map(|scene| {
            let names = (0..scene.pairs().len()).map(|pair| scene.pair_names(PairId::new(pair)).join(" "));
            (names.collect::<Vec<_>>(), scene.warnings().to_vec())
        })
    };
    assert_eq!(pairs("disable = []").unwrap().0, ["left right"]);
    assert_eq!(pairs("enable = [['left', 'palm']]").unwrap().0, ["palm left", "left right"]);
    let swapped = pairs("enable = [['right', 'palm']]\ndisable = [['right', 'left']]").unwrap();
    assert_eq!((swapped.0, swapped.1.is_empty()), (vec!["palm right".to_string()], true));
    assert!(pairs("enable = [['tip', 'palm']]").unwrap().1[0].contains("without geometry touches nothing"));
    assert!(
        pairs("enable = [['left', 'plam']]").unwrap_err().contains("pairs: enable [\"left\", \"plam\"]: got `plam`")
    );
    assert!(pairs("disable = [['left', 'plam']]").unwrap_err().contains("w.toml: pairs: disable [\"left\", \"plam\"]"));
    let both = "enable = [['left', 'palm']]\ndisable = [['palm', 'left']]";
    assert!(pairs(both).unwrap_err().contains("`disable` or `touch` takes out"));
}

#[test]
fn changed_scenes_tell_of_what_came_and_no_more_of_what_went() {
    let scene = gripper("", "");
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let half_extents = [200.0; 3];
    let vast = || Body::obstacle("vast", Geometry::Box { half_extents }, Pose::translation(Vec3::new(900.0, 0.0, 0.0)));
    let told = scene.with_obstacles([vast()]).unwrap();
    assert!(told.warnings().len() == 1 && told.warnings()[0].contains("obstacle `vast` is 400 m thick"));
    assert_eq!(told.moved([("vast", Pose::identity())]).unwrap().warnings(), told.warnings());
    assert_eq!(told.without(["wall"]).unwrap().warnings(), told.warnings());
    assert!(told.without(["vast"]).unwrap().warnings().is_empty());
    assert!(scene.attached(vast(), "palm", &[]).unwrap().warnings()[0].contains("attached `vast` is 400 m thick"));
    let bare = scene.without_obstacles().disabled([["left", "right"]]).unwrap();
    assert!(bare.warnings().len() == 1 && bare.warnings()[0].contains("no pair of bodies is checked"));
    assert!(bare.with_obstacles([rod()]).unwrap().warnings().is_empty());
}

#[test]
fn a_world_of_a_file_takes_the_place_of_the_obstacles() {
    let scene = gripper("clearance = { self = 1e-4, world = 0.02 }", "");
    let mut read = |_: &Path| -> extricate::Result<Vec<u8>> { panic!("nothing to read") };
    let mut world = |text: &str| in_world(&scene, Path::new("world.toml"), text, &mut read);
    let text = format!("{}{ROD}[pairs]\ndisable = [['palm', 'post']]", WALL.replace("wall", "post"));
    let made = world(&text).unwrap();
    let names: Vec<&str> = made.bodies().iter().map(|body| body.name.as_str()).collect();
    assert_eq!((names, made.clearance()), (vec!["palm", "left", "right", "post", "rod"], 0.02));
    assert_eq!(colliding(&ask(&Solver::new(made.clone()), &[0.05, 0.025]), &made), ["post rod"]);
    assert_eq!(world("clearance = 0.03").unwrap().clearance(), 0.03);
    let refused = world("metric = { kind = 'joint' }").unwrap_err().to_string();
    assert!(refused.contains("world.toml: metric: got one in a world without a [[robot]]"), "{refused}");
    let refused = world(&ROD.replace("palm", "plam")).unwrap_err().to_string();
    assert!(refused.starts_with("world.toml: attached \"rod\": link: got `plam`"), "{refused}");
}

fn table() -> Body {
    Body::obstacle(
        "table",
        Geometry::Box { half_extents: [0.2, 0.2, 0.02] },
        Pose::translation(Vec3::new(0.15, 0.1, 0.1)),
    )
}

/// Compares answers of shared and of new preparation, to the last bit.
#[test]
fn solvers_that_share_answer_as_new_ones() {
    for name in ["shelf-arm", "hand", "dual-arm"] {
        let scene = match builtin::scene(name).unwrap() {
            bare if bare.bodies().iter().any(Body::is_obstacle) => bare,
            bare => bare.with_obstacles([table()]).unwrap(),
        };
        let world = Solver::new(scene.clone());
        world.prepare();
        let obstacle = scene.bodies().iter().rfind(|body| body.is_obstacle()).unwrap();
        let pose = |by: f64| Pose::translation(Vec3::new(by, 0.0, 0.3 * by)).then(&obstacle.parts[0].pose_frame_part);
        let block = Body::obstacle("block", Geometry::Box { half_extents: [0.05; 3] }, pose(0.3));
        let link = scene.links().last().unwrap();
        let tool = Body::obstacle("tool", Geometry::Sphere { radius: 0.03 }, Pose::identity());
        let pair = scene.pair_names(PairId::new(scene.pairs().len() / 2));
        for changed in [
            scene.moved([(obstacle.name.as_str(), pose(0.04))]).unwrap(),
            scene.with_obstacles([block]).unwrap(),
            scene.without([obstacle.name.as_str()]).unwrap(),
            scene.disabled([pair]).unwrap(),
            scene.attached(tool, &link.name, &[]).unwrap(),
            scene.with_clearance(5e-3).unwrap(),
        ] {
            let (shared, new) = (world.with_scene(changed.clone()).unwrap(), Solver::new(changed));
            let halton = extricate::internals::cspace::sampling::Halton::new(scene.space().nv(), 7);
            let mut q = vec![0.0; scene.space().nq()];
            for index in 0..40 {
                halton.config(scene.space(), index, &mut q);
                let q = scene.space().config(&q).unwrap();
                assert_eq!(shared.query(&q), new.query(&q), "{name}");
            }
        }
    }
}

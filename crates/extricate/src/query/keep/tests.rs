//! Tests of kept links against closed forms, differences and samples.

use std::path::Path;

use super::*;
use crate::cspace::Config;
use crate::cspace::sampling::Halton;
use crate::kinematics::Twists;
use crate::query::context::Context;
use crate::query::evaluate::Evaluator;
use crate::query::prepared::Prepared;
use crate::query::{Answer, QueryOptions, QueryScratch, Unproved, query};
use crate::scene::assemble::assemble;

/// An arm of two links of 1 m in the plane, with a point as its tool, and balls in its way.
fn arm(balls: &[[f64; 2]]) -> Prepared {
    let link = |name: &str, x: f64| {
        format!(
            "<link name='{name}'><collision><origin xyz='{x} 0 0'/><geometry><box size='{} 0.02 0.02'/></geometry>\
             </collision></link>",
            2.0 * x
        )
    };
    let joint = |name: &str, parent: &str, child: &str, x: f64| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
             <origin xyz='{x} 0 0'/><axis xyz='0 0 1'/><limit lower='-7' upper='7' effort='1' velocity='1'/></joint>"
        )
    };
    let urdf = format!(
        "<robot name='arm'><link name='base'/>{}{}<link name='tool'/>{}{}\
         <joint name='tip' type='fixed'><parent link='lower'/><child link='tool'/><origin xyz='1 0 0'/></joint></robot>",
        link("upper", 0.5),
        link("lower", 0.5),
        joint("shoulder", "base", "upper", 0.0),
        joint("elbow", "upper", "lower", 1.0),
    );
    let mut toml = String::from("[[robot]]\nurdf = 'r.urdf'\n");
    for (k, [x, y]) in balls.iter().enumerate() {
        toml += &format!("[[obstacle]]\nname = 'b{k}'\nshape = {{ sphere = 0.1 }}\npose = {{ xyz = [{x}, {y}, 0] }}\n");
    }
    let scene = assemble(Path::new("scene.toml"), &toml, &mut |_: &Path| Ok(urdf.as_bytes().to_vec()));
    Prepared::new(scene.unwrap())
}

fn ask(world: &Prepared, q: &[f64], keep: &str) -> (Config, Option<Answer>) {
    let q = world.scene().config(q).unwrap();
    let options = QueryOptions::default().keep(KeptLink::from_text(world.scene(), keep).unwrap());
    let answer = query(&world.context(), &q, &options, &mut QueryScratch::default());
    (q, answer)
}

const HELD: &str = r#"{"link": "tool", "rotation": null}"#;

/// The only other way for the arm to hold its tool is with its elbow on the other side. Whole turns
/// lead there too, but farther.
#[test]
fn the_elbow_flips_where_the_tool_stays() {
    let (shoulder, elbow) = (0.7, -1.2);
    let at_elbow = [f64::cos(shoulder), f64::sin(shoulder)];
    let world = arm(&[at_elbow]);
    let (q, answer) = ask(&world, &[shoulder, elbow], HELD);
    let answer = answer.unwrap();
    // The triangle of both links is mirrored at the line to the tool.
    let exact = [shoulder + elbow, -elbow];
    let depth = world.metric().distance(&q, &exact);
    assert!((answer.depth - depth).abs() < 1e-3, "{} {depth}", answer.depth);
    assert!(answer.kept[0].position <= 1e-4 && answer.verified && answer.lower_bound <= depth);
    // If both are blocked, there is none; the tool may then only move within a wide tolerance.
    let mirrored = [f64::cos(shoulder + elbow), f64::sin(shoulder + elbow)];
    let blocked = arm(&[at_elbow, mirrored]);
    assert_eq!(ask(&blocked, &[shoulder, elbow], HELD).1, None);
    let wide = ask(&blocked, &[shoulder, elbow], r#"{"link": "tool", "position": 0.3, "rotation": null}"#).1.unwrap();
    assert!(wide.kept[0].position <= 0.3 && wide.depth < depth, "{wide:?}");
    let whole = query(&blocked.context(), &q, &QueryOptions::default(), &mut QueryScratch::default()).unwrap();
    assert!(whole.depth <= wide.depth * (1.0 + 1e-3));
}

/// A pose that the query does not have: the nearest solution of the inverse kinematics.
#[test]
fn a_free_query_is_moved_to_a_given_pose() {
    let world = arm(&[[-5.0, 0.0]]);
    let given = r#"{"link": "tool", "pose": {"xyz": [1.2, 0.8, 0]}, "rotation": null}"#;
    let (q, answer) = ask(&world, &[0.1, 0.3], given);
    let answer = answer.unwrap();
    let (x, y): (f64, f64) = (1.2, 0.8);
    let elbow = f64::acos((x * x + y * y - 2.0) / 2.0);
    let shoulder = f64::atan2(y, x) - f64::atan2(f64::sin(elbow), 1.0 + f64::cos(elbow));
    let exact = world.metric().distance(&q, &[shoulder, elbow]);
    assert!((answer.depth - exact).abs() < 1e-3, "{} {exact}", answer.depth);
    assert!(!answer.is_free() && answer.colliding.is_empty() && answer.off == [0], "{answer:?}");
    assert_eq!(answer.unproved, Some(Unproved::Off));
    // Where it is already, it is free.
    let there = ask(&world, &[shoulder, elbow], given).1.unwrap();
    assert!(there.is_free() && there.depth == 0.0);
    // Nothing reaches so far.
    assert_eq!(ask(&world, &[0.1, 0.3], r#"{"link": "tool", "pose": {"xyz": [3, 0, 0]}}"#).1, None);
}

/// Slopes of all rows, for the world and for another link, against differences.
#[test]
fn rows_are_the_slopes_of_offsets() {
    let scene = crate::scene::builtin::scene("four-legs").unwrap();
    let links: Vec<usize> = (0..scene.links.len()).filter(|at| scene.links[*at].frame > 0).collect();
    let world = Prepared::new(scene);
    let (scene, space) = (world.scene(), &world.scene().space);
    let (halton, mut q, mut poses) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()], Vec::new());
    let (mut twists, mut rows, mut moved) = (Twists::default(), KeptRows::default(), q.clone());
    for index in 0..20 {
        let link = |k: usize| links[(5 * index as usize + k) % links.len()];
        let keep = [
            KeptLink::link(link(0)),
            KeptLink::link(link(1)).axis([0.3, -1.0, 0.4]),
            KeptLink::link(link(2)).relative_to(link(4)),
        ];
        halton.config(space, index, &mut q);
        let kept = LinkConstraint::all(scene, &keep, &q);
        let mut at = |q: &[f64], rows: &mut KeptRows| {
            forward(scene, q, &mut poses);
            twists.set(scene, &poses);
            rows.set(scene, &kept, &poses, &twists);
        };
        at(&q, &mut rows);
        assert!(rows.offsets.len() == 17 && rows.offsets.iter().all(|offset| offset.abs() < 1e-12));
        let (slopes, mut step) = (rows.rows.clone(), vec![0.0; space.nv()]);
        for v in 0..space.nv() {
            let mut change = [0.0; 17];
            for sign in [1.0, -1.0] {
                step[v] = sign * 1e-5;
                space.integrate(&q, &step, &mut moved);
                at(&moved, &mut rows);
                change.iter_mut().zip(&rows.offsets).for_each(|(change, offset)| *change += sign * offset / 2e-5);
            }
            step[v] = 0.0;
            for (row, change) in change.iter().enumerate() {
                let slope = slopes[row * space.nv() + v];
                assert!((slope - change).abs() < 1e-6, "{index} {row} {v}: {slope} {change}");
            }
        }
    }
}

#[test]
fn projections_keep_links_limits_and_locked_joints() {
    let world = Prepared::new(crate::scene::builtin::scene("four-legs").unwrap());
    let (scene, space) = (world.scene(), &world.scene().space);
    let (halton, mut q, mut from) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()], vec![0.0; space.nq()]);
    let tip = (0..scene.links.len()).max_by_key(|at| scene.links[*at].frame).unwrap();
    let mut locked = vec![false; space.nv()];
    locked[0] = true;
    let (mut evaluator, mut found) = (Evaluator::default(), 0);
    for index in 0..100 {
        halton.config(space, index, &mut q);
        halton.config(space, index + 1000, &mut from);
        let kept = LinkConstraint::all(scene, &[KeptLink::link(tip).rotation(None)], &q);
        let context = Context { kept: &kept, locked: &locked, ..world.context() };
        context.hold(&q, &mut from);
        let before = from.clone();
        if evaluator.project(&context, &mut from) {
            found += 1;
            let mut poses = Vec::new();
            forward(scene, &from, &mut poses);
            assert!(kept[0].error(&poses).position <= 1e-4 && space.is_within(&from));
            let mut held = from.clone();
            context.hold(&before, &mut held);
            assert_eq!(held, from);
        }
    }
    assert!(found > 60, "{found}");
}

#[test]
fn half_a_turn_has_an_axis() {
    for axis in [Vec3::x(), Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.48, -0.6, 0.64)] {
        for angle in [0.0, 1e-10, 0.3, 3.0, std::f64::consts::PI - 1e-10, std::f64::consts::PI] {
            let turned = rotation_vector(&crate::math::axis_rotation(&axis, angle));
            let off = (turned - axis * angle).norm().min((turned + axis * angle).norm());
            assert!(off < 1e-7, "{axis} {angle}: {turned}");
        }
    }
    assert!((between(&Vec3::x(), &-Vec3::x()).norm() - std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn what_makes_no_sense_is_named() {
    let world = arm(&[]);
    for (text, part) in [
        ("tol", "keep: got `tol`, expected one of"),
        (r#"{"link": "tool", "width": 1}"#, "unknown field `width`"),
        (r#"{"link": "tool", "position": 0}"#, "got position 0, expected a position tolerance of 1e-9 to 1e9 [m]"),
        (r#"{"link": "tool", "rotation": -1}"#, "got rotation -1"),
        (r#"{"link": "tool", "position": null, "rotation": null}"#, "got neither position nor rotation"),
        (r#"{"link": "tool", "axis": [0, 0, 0]}"#, "got axis [0.0, 0.0, 0.0], expected three finite numbers"),
        (r#"{"link": "tool", "axis": [0, 0, 1], "rotation": null}"#, "without rotation"),
        (r#"{"link": "tool", "pose": {"xyz": [0, 0, 0], "quat_xyzw": [0, 0, 0, 2]}}"#, "pose"),
        ("[{}]", "missing field `link`"),
    ] {
        let message = KeptLink::from_text(world.scene(), text).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let pose = crate::math::Pose::at([f64::NAN, 0.0, 0.0]);
    let refused = KeptLink::link(1).pose(pose).check().unwrap_err().to_string();
    assert!(refused.contains("got a pose, expected finite numbers, and a rotation"), "{refused}");
    let both = KeptLink::from_text(world.scene(), r#"[{"link": "tool"}, {"link": "upper", "relative_to": "tool"}]"#);
    assert_eq!(both.unwrap().len(), 2);
    let refused = KeptLink::link(99).check_links(world.scene()).unwrap_err().to_string();
    assert!(refused.contains("got link 99, expected indices below the 4 links"), "{refused}");
}

/// All joints that move the link are at limits, or locked: there is no projection, and no number
/// that is none.
#[test]
fn a_link_that_cannot_move_is_not_brought_anywhere() {
    let world = arm(&[[-5.0, 0.0]]);
    let (scene, space) = (world.scene(), &world.scene().space);
    let elsewhere = KeptLink::from_text(scene, r#"{"link": "tool", "pose": {"xyz": [1, 1, 0]}}"#).unwrap();
    let base = KeptLink::from_text(scene, r#"{"link": "base", "pose": {"xyz": [1, 1, 0]}}"#).unwrap();
    let all = vec![true; space.nv()];
    for (keep, locked, q) in
        [(&elsewhere, &all[..], [0.1, 0.2]), (&base, &[][..], [0.1, 0.2]), (&elsewhere, &[], [7.0, 7.0])]
    {
        let kept = LinkConstraint::all(scene, keep, &q);
        let context = Context { kept: &kept, locked, ..world.context() };
        let mut config = q.to_vec();
        let is_found = Evaluator::default().project(&context, &mut config);
        assert!(config.iter().all(|x| x.is_finite()) && (!is_found || keep == &elsewhere), "{config:?}");
    }
    assert_eq!(ask(&world, &[0.1, 0.3], r#"{"link": "base", "pose": {"xyz": [1, 1, 0]}}"#).1, None);
}

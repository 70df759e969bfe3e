//! Equal queries have equal answers to the last bit: whatever was computed before, in whatever
//! order, with whatever memory, and for raw meshes too.

use std::fmt::Debug;
use std::sync::Arc;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::io;
use extricate::{
    CheckScratch, Config, Effort, EscapeOptions, Hand, Label, PlanOptions, QueryOptions, ReleaseOptions, RepairOptions,
    Rows, Scene, SegmentOptions, Solver, StreamOptions, Termination,
};

use crate::memory::learn;

/// Makes two fingers of two links each, all of them brackets of triangles, and a ring of triangles
/// between them.
pub fn gripper() -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    // The bracket is an extruded L.
    let corners = [[0.0, 0.0], [0.02, 0.0], [0.02, 0.05], [0.045, 0.05], [0.045, 0.07], [0.0, 0.07]];
    let mut bracket = String::new();
    for y in [-0.01, 0.01] {
        corners.iter().for_each(|[x, z]| bracket += &format!("v {x} {y} {z}\n"));
    }
    bracket += "f 1 2 3\nf 1 3 6\nf 3 4 5\nf 3 5 6\nf 9 8 7\nf 12 9 7\nf 11 10 9\nf 12 11 9\n";
    for at in 1..=6 {
        let next = at % 6 + 1;
        bracket += &format!("f {at} {} {} {next}\n", at + 6, next + 6);
    }
    write("bracket.obj", &bracket);
    write("ring.obj", &ring(12, [0.018, 0.03], 0.02));
    let link = |name: &str| {
        format!("<link name='{name}'><collision><geometry><mesh filename='bracket.obj'/></geometry></collision></link>")
    };
    let joint = |child: &str, parent: &str, at: &str| {
        format!(
            "<joint name='j_{child}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
             <origin xyz='{at}'/><axis xyz='0 1 0'/><limit lower='-1.6' upper='1.6' effort='1' velocity='1'/></joint>"
        )
    };
    let mut urdf = String::from(
        "<robot name='g'><link name='palm'><collision><origin xyz='0 0 -0.02'/><geometry><box size='0.14 0.03 0.02'/>\
         </geometry></collision></link>",
    );
    for (finger, x) in [("left", "-0.05"), ("right", "0.05")] {
        let (near, far) = (format!("{finger}_near"), format!("{finger}_far"));
        urdf += &(link(&near) + &link(&far));
        urdf += &(joint(&near, "palm", &format!("{x} 0 0")) + &joint(&far, &near, "0 0 0.075"));
    }
    write("g.urdf", &(urdf + "</robot>"));
    write(
        "s.toml",
        "[[robot]]\nurdf = 'g.urdf'\n[[obstacle]]\nname = 'ring'\nshape = { mesh = 'ring.obj' }\n\
         pose = { xyz = [0.0, 0.0, 0.09] }\n",
    );
    io::load_scene(folder.path().join("s.toml")).unwrap()
}

/// Writes a ring around y with this number of sides, as an OBJ.
fn ring(sides: usize, radii: [f64; 2], half: f64) -> String {
    let mut text = String::new();
    for side in 0..sides {
        let (sine, cosine) = (std::f64::consts::TAU * side as f64 / sides as f64).sin_cos();
        for (radius, y) in [(radii[0], -half), (radii[1], -half), (radii[1], half), (radii[0], half)] {
            text += &format!("v {} {y} {}\n", radius * cosine, radius * sine);
        }
    }
    for side in 0..sides {
        let (here, next) = (4 * side + 1, 4 * ((side + 1) % sides) + 1);
        for k in 0..4 {
            let l = (k + 1) % 4;
            text += &format!("f {} {} {} {}\n", here + k, next + k, next + l, here + l);
        }
    }
    text
}

/// One kind of query. It shares the memory of the solver and of checks with the other kinds.
type Question = fn(&Solver, &Config, &mut CheckScratch) -> String;

fn text(answer: impl Debug) -> String {
    format!("{answer:?}")
}

fn query(solver: &Solver, q: &Config, options: QueryOptions) -> String {
    text(solver.clone().options(options).unwrap().query(q))
}

/// Queries of every kind, by name; the fixed configurations have the gripper's four joints.
const QUESTIONS: [(&str, Question); 10] = [
    ("refined", |solver, q, _| query(solver, q, QueryOptions::default())),
    ("exits", |solver, q, _| query(solver, q, QueryOptions::default().exits(3).segment(true).free_radius(true))),
    ("proved", |solver, q, _| {
        let termination = Termination::after_checks(150);
        query(solver, q, QueryOptions::default().effort(Effort::Proved).termination(termination))
    }),
    ("clearance", |solver, q, _| query(solver, q, QueryOptions::default().clearance(0.003))),
    ("escape", |solver, q, _| text(solver.escape(q, &EscapeOptions::default().tree_checks(500)))),
    ("release", |solver, q, _| {
        let hand = Hand::new(solver.scene(), "ring").unwrap();
        text(solver.release(&hand, q, &ReleaseOptions::default()))
    }),
    ("repair", |solver, q, _| {
        let rows = [&[0.0; 4][..], q, &[0.4, 0.0, -0.4, 0.0]].concat();
        let options = RepairOptions::default().termination(Termination::after_checks(1_000));
        text(solver.repair(Rows::new(&rows, 4).unwrap(), &options))
    }),
    ("plan", |solver, q, _| {
        let answer = solver.query(q).unwrap();
        let [from, to] = [&answer.witness[..], &[-1.2, 0.0, 1.2, 0.0]].map(|q| solver.scene().config(q).unwrap());
        let options = PlanOptions::default().termination(Termination::after_checks(2_000));
        text(solver.plan(&from, &to, &options))
    }),
    ("checks", |solver, q, memory| {
        let checker = solver.checker();
        let middle = vec![0.1; q.len()];
        let label = checker.label(q, memory);
        let clearance = checker.clearance(q, memory);
        text((label, clearance, checker.segment(q, &middle, &SegmentOptions::default(), memory)))
    }),
    ("stream", |solver, q, _| {
        let mut stream = solver.stream(StreamOptions::default().continuous(true)).unwrap();
        text([0, 1].map(|_| stream.query(q)))
    }),
];

fn colliding(world: &Solver, count: usize) -> Vec<Config> {
    let space = world.scene().space();
    let (halton, mut q, mut scratch) = (Halton::new(space.nv(), 5), vec![0.0; space.nq()], CheckScratch::default());
    let drawn = (0..).filter_map(|index| {
        halton.config(space, index, &mut q);
        let is_colliding = world.checker().label(&q, &mut scratch) == Label::Colliding;
        is_colliding.then(|| space.config(&q).unwrap())
    });
    drawn.take(count).collect()
}

/// Answers all questions about all configurations, in this order of the questions.
fn asked<'a>(solver: &Solver, configs: &[Config], order: impl Iterator<Item = &'a usize>) -> Vec<Vec<String>> {
    let (mut memory, mut answers) =
        (CheckScratch::default(), vec![vec![String::new(); configs.len()]; QUESTIONS.len()]);
    for question in order {
        for (at, q) in configs.iter().enumerate() {
            answers[*question][at] = QUESTIONS[*question].1(solver, q, &mut memory);
        }
    }
    answers
}

fn assert_equal(expected: &[Vec<String>], found: &[Vec<String>], how: &str) {
    for ((expected, found), (name, _)) in expected.iter().zip(found).zip(QUESTIONS) {
        for (at, (expected, found)) in expected.iter().zip(found).enumerate() {
            assert_eq!(expected, found, "{name}, {how}, configuration {at}");
        }
    }
}

#[test]
fn answers_do_not_depend_on_what_was_asked_before() {
    let scene = gripper();
    let configs = colliding(&Solver::new(scene.clone()), 6);
    let forward: Vec<usize> = (0..QUESTIONS.len()).collect();
    let world = Solver::new(scene.clone());
    let expected = asked(&world, &configs, forward.iter());
    assert_equal(&expected, &asked(&world, &configs, forward.iter()), "asked again");
    let other = Solver::new(scene.clone());
    assert_equal(&expected, &asked(&other, &configs, forward.iter().rev()), "the last question first");
    for question in &forward {
        let alone = Solver::new(scene.clone());
        let found = asked(&alone, &configs, std::iter::once(question));
        assert_equal(&expected[*question..=*question], &found[*question..=*question], "asked alone");
    }
    // This solver is prepared for another scene, which shares the pieces of links.
    let moved = world.with_scene(scene.with_obstacles([]).unwrap()).unwrap();
    moved.prepare();
    assert_equal(&expected, &asked(&moved.with_scene(scene).unwrap(), &configs, forward.iter()), "shared bodies");
}

#[test]
fn with_a_model_neither() {
    let model = Arc::new(learn(gripper(), 4_000, 0));
    let (solver, other) = (Solver::of_model(Arc::clone(&model)), Solver::of_model(Arc::clone(&model)));
    let configs = colliding(&solver, 6);
    let forward: Vec<usize> = (0..QUESTIONS.len()).collect();
    let expected = asked(&solver, &configs, forward.iter());
    assert_equal(&expected, &asked(&other, &configs, forward.iter().rev()), "the last question first");
    let file = tempfile::NamedTempFile::new().unwrap();
    io::save_model(&model, file.path()).unwrap();
    let again = Solver::of_model(io::load_model(file.path()).unwrap());
    assert_equal(&expected, &asked(&again, &configs, forward.iter()), "written and read");
}

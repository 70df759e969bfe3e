//! Meshes with hollows: the nearest exit leads back into the hollow, by closed form.

use std::path::Path;

use extricate::internals::io;
use extricate::{Effort, QueryOptions, Solver};

use crate::query::ask;

/// Radius of the ball that slides along x, y and z \[m\].
const BALL_RADIUS_M: f64 = 0.05;

/// Makes the scene of the ball among one mesh, given as an OBJ.
fn world(mesh: &str) -> Solver {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let slide = |axis: &str, parent: &str, child: &str, along: &str| {
        format!(
            "<joint name='{axis}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='{along}'/>\
             <limit lower='-5' upper='5' effort='1' velocity='1'/></joint>"
        )
    };
    let ball = format!("<collision><geometry><sphere radius='{BALL_RADIUS_M}'/></geometry></collision>");
    let joints = slide("x", "w", "a", "1 0 0") + &slide("y", "a", "b", "0 1 0") + &slide("z", "b", "ball", "0 0 1");
    let links = format!("<link name='w'/><link name='a'/><link name='b'/><link name='ball'>{ball}</link>");
    write("r.urdf", &format!("<robot name='r'>{links}{joints}</robot>"));
    write("m.obj", mesh);
    write("s.toml", "[[robot]]\nurdf = 'r.urdf'\n[[obstacle]]\nname = 'm'\nshape = { mesh = 'm.obj' }\n");
    Solver::new(io::load_scene(folder.path().join(Path::new("s.toml"))).unwrap())
}

/// Writes boxes, given by their ends along the axes, into one OBJ; they may overlap.
fn boxes(all: &[[[f64; 2]; 3]]) -> String {
    let mut text = String::new();
    for ends in all {
        for k in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| ends[axis][k >> axis & 1]);
            text += &format!("v {x} {y} {z}\n");
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            text += &format!("f {} {} {} {}\n", a - 8, b - 8, c - 8, d - 8);
        }
    }
    text
}

/// An OBJ of two sheets and a floor between them, of no thickness.
const CHANNEL: &str = "v 0 -2 -1\nv 0 2 -1\nv 0 2 1\nv 0 -2 1\nv 1.5 -2 -1\nv 1.5 2 -1\nv 1.5 2 1\nv 1.5 -2 1\n\
                       f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\n";

fn assert_depth(world: &Solver, q: [f64; 3], expected: f64, what: &str) {
    let q = world.scene().config(&q).unwrap();
    for effort in [Effort::Refined, Effort::Exhaustive] {
        let options = QueryOptions::default().effort(effort);
        let answer = ask(world, &q, &options);
        let is_near = (answer.depth - expected).abs() < 1e-3 * expected + 1e-6;
        assert!(is_near && answer.lower_bound <= expected + 1e-9, "{what} {q:?}: {} for {expected}", answer.depth);
    }
}

/// A shelf of three by three cells, a metre wide, of boards of 2 cm.
#[test]
fn a_ball_in_a_shelf_goes_back_into_its_cell() {
    let ends = |k: usize| [k as f64 / 3.0 - 0.01, k as f64 / 3.0 + 0.01];
    let upright = (0..4).map(|k| [ends(k), [0.0, 0.4], [-0.01, 1.01]]);
    let boards = (0..4).map(|k| [[-0.01, 1.01], [0.0, 0.4], ends(k)]);
    let world = world(&boxes(&upright.chain(boards).collect::<Vec<_>>()));
    for (column, row) in [(0, 0), (1, 1), (2, 1), (1, 2)] {
        let middle = |k: usize| (k as f64 + 0.5) / 3.0;
        for overlap in [0.005, 0.02] {
            // Moves into the wall on the right, whose face is a centimetre before its middle plane.
            let x = (column + 1) as f64 / 3.0 - 0.01 - BALL_RADIUS_M + overlap;
            assert_depth(&world, [x, 0.2, middle(row)], overlap + 1e-4, "shelf");
        }
    }
}

#[test]
fn a_ball_in_a_channel_of_sheets_goes_back_into_it() {
    let world = world(CHANNEL);
    for inside in [0.045, 0.02, 0.01] {
        assert_depth(&world, [inside, 0.3, 0.2], BALL_RADIUS_M - inside + 1e-4, "channel");
        assert_depth(&world, [1.5 - inside, 0.3, 0.2], BALL_RADIUS_M - inside + 1e-4, "channel");
    }
}

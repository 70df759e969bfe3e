//! Depths in closed form. Answers err by at most 1e-3, or that share of depths above 1 (the
//! precision of last descents along raw meshes). The proved bound is below them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use extricate::Solver;
use extricate::internals::cspace::sampling::Halton;

use crate::baselines::ANALYTIC_COLLIDING_SHARE;
use crate::memory::{chain, collision, learned, scene};

pub const CLEARANCE: f64 = 1e-4;

/// Queries `count` low-discrepancy configurations and compares with `exact`, which is 0 for free
/// ones.
pub fn compare(model: &Solver, count: u64, exact: impl Fn(&[f64]) -> f64) {
    let space = model.scene().space();
    let halton = Halton::new(space.nv(), 99);
    let mut q = vec![0.0; space.nq()];
    let mut colliding = 0;
    for i in 0..count {
        halton.config(space, i, &mut q);
        let depth = exact(&q);
        let answer = model.query(&space.config(&q).unwrap()).unwrap();
        assert!((answer.depth - depth).abs() < 1e-3 * depth.max(1.0), "at {q:?}: got {}, exact {depth}", answer.depth);
        assert!(answer.lower_bound <= depth * (1.0 + 1e-9) + 1e-12, "at {q:?}: bound {}", answer.lower_bound);
        assert!(answer.verified);
        colliding += usize::from(depth > 0.0);
    }
    assert!(colliding as f64 > ANALYTIC_COLLIDING_SHARE * count as f64, "only {colliding} of {count} collide");
}

#[test]
fn box_in_a_box_by_translation() {
    let side = "<box size=\"0.2 0.3 0.4\"/>";
    let shape = collision([0.0; 3], [0.0; 3], side);
    let urdf = chain(&[
        ("prismatic", [0.0; 3], [1.0, 0.0, 0.0], -1.0, 1.0, ""),
        ("prismatic", [0.0; 3], [0.0, 1.0, 0.0], -1.0, 1.0, ""),
        ("prismatic", [0.0; 3], [0.0, 0.0, 1.0], -1.0, 1.0, &shape),
    ]);
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"block\"\nshape = { box = [0.6, 0.5, 0.4] }\n";
    let model = learned(scene(toml, &[("r.urdf", urdf)]), 40_000, 1);
    let answer = model.query(&model.scene().space().config(&[0.3, 0.1, 0.2]).unwrap()).unwrap();
    assert!(answer.lower_bound > 0.999 * answer.depth, "for a translation the bound is tight: {answer:?}");
    let reach = [0.1 + 0.3, 0.15 + 0.25, 0.2 + 0.2];
    compare(&model, 400, |q| (0..3).map(|k| reach[k] + CLEARANCE - q[k].abs()).fold(f64::INFINITY, f64::min).max(0.0));
}

/// An annulus of inner radius 0.3 and outer radius 0.9 is free; the wall outside it is a mesh of
/// 512 sides.
#[test]
fn disc_in_an_annulus() {
    let disc = collision([0.0; 3], [0.0; 3], "<cylinder radius=\"0.1\" length=\"0.2\"/>");
    let urdf = chain(&[
        ("prismatic", [0.0; 3], [1.0, 0.0, 0.0], -1.0, 1.0, ""),
        ("prismatic", [0.0; 3], [0.0, 1.0, 0.0], -1.0, 1.0, &disc),
    ]);
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n\
                [[obstacle]]\nname = \"core\"\nshape = { cylinder = [0.3, 0.4] }\n\
                [[obstacle]]\nname = \"wall\"\nshape = { mesh = \"wall.obj\" }\n";
    let model = learned(scene(toml, &[("r.urdf", urdf), ("wall.obj", ring(0.9, 2.0, 0.2, 512))]), 40_000, 2);
    compare(&model, 400, |q| {
        let radius = q[0].hypot(q[1]);
        f64::max(0.3 + 0.1 + CLEARANCE - radius, radius + 0.1 + CLEARANCE - 0.9).max(0.0)
    });
}

/// Writes a closed ring along z with a rectangular cross-section and apothem `inner`.
pub fn ring(inner: f64, outer: f64, half_height: f64, sides: usize) -> String {
    let mut text = String::new();
    let stretch = 1.0 / (PI / sides as f64).cos();
    for i in 0..sides {
        let (sin, cos) = (TAU * i as f64 / sides as f64).sin_cos();
        for (radius, z) in [
            (inner * stretch, -half_height),
            (outer, -half_height),
            (outer, half_height),
            (inner * stretch, half_height),
        ] {
            text += &format!("v {} {} {z}\n", radius * cos, radius * sin);
        }
    }
    for i in 0..sides {
        for k in 0..4 {
            let at = |i: usize, k: usize| 4 * (i % sides) + k % 4 + 1;
            text += &format!("f {} {} {} {}\n", at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
        }
    }
    text
}

const RADIUS: f64 = 0.05;

/// Writes a capsule from the joint along x.
fn arm_link(length: f64) -> String {
    collision(
        [length / 2.0, 0.0, 0.0],
        [0.0, FRAC_PI_2, 0.0],
        &format!("<capsule radius=\"{RADIUS}\" length=\"{length}\"/>"),
    )
}

/// A scene with the half-plane `x >= 0.5`, as a block that no arm here reaches around.
const WALL: &str = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"wall\"\nshape = { box = [4, 20, 4] }\n\
                    pose = { xyz = [2.5, 0, 0] }\n";

/// Largest x that the end of a link may reach \[m\].
const REACH: f64 = 0.5 - RADIUS - CLEARANCE;

#[test]
fn one_joint_before_a_half_plane() {
    let link = arm_link(0.8);
    let urdf = chain(&[("revolute", [0.0; 3], [0.0, 0.0, 1.0], -3.0, 3.0, &link)]);
    let model = learned(scene(WALL, &[("r.urdf", urdf)]), 5_000, 3);
    compare(&model, 300, |q| ((REACH / 0.8).acos() - q[0].abs()).max(0.0));
}

#[test]
fn two_joints_before_a_half_plane() {
    let (a, b) = (0.4, 0.5);
    let (first, second) = (arm_link(a), arm_link(b));
    let urdf = chain(&[
        ("revolute", [0.0; 3], [0.0, 0.0, 1.0], -3.0, 3.0, &first),
        ("revolute", [a, 0.0, 0.0], [0.0, 0.0, 1.0], -2.5, 2.5, &second),
    ]);
    let model = learned(scene(WALL, &[("r.urdf", urdf)]), 40_000, 4);
    compare(&model, 200, |q| {
        // The elbow cannot reach the wall (a < REACH); the tip must stay before it.
        let tip = a * q[0].cos() + b * (q[0] + q[1]).cos();
        if tip <= REACH {
            return 0.0;
        }
        // On the boundary the second angle is a function of the first.
        let mut best = f64::INFINITY;
        for i in 0..200_001 {
            let first = -3.0 + 6.0 * f64::from(i) / 200_000.0;
            let cosine = (REACH - a * first.cos()) / b;
            if cosine.abs() > 1.0 {
                continue;
            }
            for turn in [-TAU, 0.0, TAU] {
                for sign in [-1.0, 1.0] {
                    let second = sign * cosine.acos() - first + turn;
                    if second.abs() <= 2.5 {
                        best = best.min((first - q[0]).hypot(second - q[1]));
                    }
                }
            }
        }
        best
    });
}

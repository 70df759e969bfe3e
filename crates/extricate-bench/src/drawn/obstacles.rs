//! Kinds of obstacles, drawn around the space that a robot reaches.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use extricate::geometry::Pose;
use extricate::internals::math::Vec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::entry::{Obstacle, Shape};
use super::robots::Space;
use crate::exact::drawn_poses::direction;
use crate::exact::meshes::{bumpy, torus};

type Kind = fn(&mut ChaCha8Rng, &Space) -> Vec<Obstacle>;

/// Kinds of obstacles that every robot is drawn with.
pub const KINDS: [(&str, Kind); 5] =
    [("boxes", boxes), ("shelf", shelf), ("cage", cage), ("ring", ring), ("mesh", mesh)];

/// 3 to 12 boxes in random orientations.
fn boxes(rng: &mut ChaCha8Rng, space: &Space) -> Vec<Obstacle> {
    let count = rng.random_range(3..=12);
    let box_at = |k| {
        let sides = [0; 3].map(|_| space.reach * rng.random_range(0.08..0.4));
        named(format!("box_{k}"), Shape::Box(sides), around(rng, space, 0.3..1.0), turn(rng))
    };
    (1..=count).map(box_at).collect()
}

/// A shelf: sides, a back and 2 to 5 boards at random heights.
fn shelf(rng: &mut ChaCha8Rng, space: &Space) -> Vec<Obstacle> {
    let r = space.reach;
    let [wide, deep, high] = [0.5..1.0, 0.2..0.4, 0.6..1.1].map(|range| r * rng.random_range(range));
    let (thick, away) = (r * rng.random_range(0.02..0.05), r * rng.random_range(0.45..0.8));
    let low = -r * rng.random_range(0.2..0.5);
    // The shelf's x axis leads from the robot to its back, z from board to board. For a planar
    // robot the boards stand upright, side by side; otherwise its plane would not cross two of
    // them.
    let roll = if space.flat { FRAC_PI_2 } else { 0.0 };
    let rpy = [roll, 0.0, rng.random_range(-PI..PI)];
    let middle = Vec3::from(space.middle);
    let frame = Pose { translation: middle, ..Pose::from_xyz_rpy([0.0; 3], rpy) };
    let height = low + high / 2.0;
    let mut parts = vec![
        ("back".to_string(), [thick, wide, high], [away + deep / 2.0, 0.0, height]),
        ("side_1".to_string(), [deep, thick, high], [away, wide / 2.0, height]),
        ("side_2".to_string(), [deep, thick, high], [away, -wide / 2.0, height]),
    ];
    for k in 1..=rng.random_range(2..=5) {
        let z = low + high * rng.random_range(0.0..1.0);
        parts.push((format!("board_{k}"), [deep, wide, thick], [away, 0.0, z]));
    }
    let placed = |(name, sides, at)| named(name, Shape::Box(sides), frame.point(&Vec3::from(at)).into(), rpy);
    parts.into_iter().map(placed).collect()
}

/// 5 to 14 bars on a circle, each slightly slanted.
fn cage(rng: &mut ChaCha8Rng, space: &Space) -> Vec<Obstacle> {
    let count = rng.random_range(5..=14);
    let away = if space.floor.is_some() { rng.random_range(0.3..0.7) } else { rng.random_range(0.45..0.8) };
    let [x, y, z] = space.middle;
    let bar = |k| {
        let (angle, radius) = (TAU * rng.random::<f64>(), space.reach * (away + rng.random_range(-0.05..0.05)));
        let size = [space.reach * rng.random_range(0.02..0.05), space.reach * rng.random_range(1.4..2.2)];
        let z = space.floor.map_or(z, |floor| floor + size[1] / 2.0);
        let aslant = [rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3), 0.0];
        named(
            format!("bar_{k}"),
            Shape::Cylinder(size),
            [x + radius * angle.cos(), y + radius * angle.sin(), z],
            aslant,
        )
    };
    (1..=count).map(bar).collect()
}

fn ring(rng: &mut ChaCha8Rng, space: &Space) -> Vec<Obstacle> {
    let (major, minor) = (rng.random_range(0.2..0.45), rng.random_range(0.04..0.12));
    let shape = Shape::Mesh(torus(space.reach * major, space.reach * minor, 48, 16));
    vec![named("ring".into(), shape, around(rng, space, 0.3..0.8), turn(rng))]
}

/// 2 or 3 bumpy meshes, or their hulls.
fn mesh(rng: &mut ChaCha8Rng, space: &Space) -> Vec<Obstacle> {
    let count = rng.random_range(2..=3);
    let mesh_at = |k| {
        let sizes = [0; 3].map(|_| space.reach * rng.random_range(0.12..0.35));
        let body = bumpy(3, TAU * rng.random::<f64>()).scaled(sizes);
        let shape = if rng.random::<bool>() { Shape::Hull(body) } else { Shape::Mesh(body) };
        named(format!("mesh_{k}"), shape, around(rng, space, 0.35..0.9), turn(rng))
    };
    (1..=count).map(mesh_at).collect()
}

/// Small cubes all over the space of the seven-joint arm, outside of the volume that its first link
/// sweeps.
pub fn cubes(rng: &mut ChaCha8Rng, count: usize, side: f64) -> Vec<Obstacle> {
    let mut place = |_| loop {
        let at = [0; 3].map(|_| rng.random_range(-1.2_f64..1.2));
        let [x, y, z] = at;
        let clear = x.hypot(y) > 0.2 + side || !(-0.2..0.7).contains(&z);
        if clear && (0.35..1.2).contains(&Vec3::from(at).norm()) {
            break [x, y, z + 0.34];
        }
    };
    let places: Vec<[f64; 3]> = (0..count).map(&mut place).collect();
    let cube = |(k, at)| named(format!("cube_{}", k + 1), Shape::Box([side; 3]), at, turn(rng));
    places.into_iter().enumerate().map(cube).collect()
}

/// One obstacle in front of a robot: a box, a post or a bumpy mesh.
pub fn before(rng: &mut ChaCha8Rng, space: &Space) -> Obstacle {
    let r = space.reach;
    let shape = match rng.random_range(0..3) {
        0 => Shape::Box([0; 3].map(|_| r * rng.random_range(0.25..0.5))),
        1 => Shape::Cylinder([r * rng.random_range(0.08..0.15), r * rng.random_range(0.8..1.4)]),
        _ => Shape::Mesh(bumpy(3, TAU * rng.random::<f64>()).scaled([r * rng.random_range(0.18..0.28); 3])),
    };
    named("obstacle".into(), shape, around(rng, space, 0.35..0.6), turn(rng))
}

fn named(name: String, shape: Shape, xyz: [f64; 3], rpy: [f64; 3]) -> Obstacle {
    Obstacle { name, shape, xyz, rpy }
}

/// Draws a position at a share of the reach from the middle, not below it.
fn around(rng: &mut ChaCha8Rng, space: &Space, shares: std::ops::Range<f64>) -> [f64; 3] {
    let away = space.reach * rng.random_range(shares);
    let d = if space.flat {
        let angle = TAU * rng.random::<f64>();
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    } else {
        let d = direction(rng);
        Vec3::new(d.x, d.y, d.z.abs())
    };
    (Vec3::from(space.middle) + d * away).into()
}

/// Roll, pitch and yaw of a uniformly distributed rotation.
fn turn(rng: &mut ChaCha8Rng) -> [f64; 3] {
    [rng.random_range(-PI..PI), rng.random_range(-1.0_f64..1.0).asin(), rng.random_range(-PI..PI)]
}

//! Scenes with a known depth or a fixed construction: carts before walls, and a ball among voxels.

use std::fmt::Write as _;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::entry::{Obstacle, Shape, Written};

/// Number and side \[m\] of the cubes that clutter the space of an arm.
pub const CLUTTERS: [(usize, f64); 2] = [(100, 0.12), (1000, 0.055)];
pub const CART_COUNTS: [usize; 4] = [4, 8, 12, 20];
/// Kinds of walls: the number of boxes that a wall consists of, or `wide`.
pub const WALLS: [&str; 3] = ["1", "5", "wide"];
/// Cells of the voxel block along each axis, and how many of them are occupied.
const CELLS: [usize; 3] = [16, 16, 5];
const TAKEN_CELLS: usize = 645;
const VOXEL_SIDE_M: f64 = 0.05;

/// Cubes of 0.2 m on parallel rails, each with a wall of 1 m across its rail.
///
/// The depth of q is `sqrt(sum_k max(0, 0.6001 - |q_k|)^2)`: half the wall, half the cart and the
/// clearance. Narrow walls are as wide as carts, so the shortest separation of an overlap leads
/// across the rail, where carts cannot go; for wide walls it leads along the rail.
pub fn carts(count: usize, wall: &str) -> Written {
    let mut scene = Written::new(&format!("carts-{count}-{wall}"));
    let (apart, across) = if wall == "wide" { (3.0, 2.5) } else { (1.0, 0.2) };
    let urdf = format!("carts/carts-{count}-{wall}.urdf");
    let _ = writeln!(scene.text, "\n[[robot]]\nurdf = \"{urdf}\"");
    scene.files.push((urdf, carts_urdf(count, apart).into_bytes()));
    let pieces: usize = wall.parse().unwrap_or(1);
    let length = 1.0 / pieces as f64;
    for k in 0..count {
        for i in 0..pieces {
            let at = [(i as f64 + 0.5) * length - 0.5, apart * k as f64, 0.0];
            let shape = Shape::Box([length, across, across]);
            scene.obstacles(&[still(format!("wall_{}_{}", k + 1, i + 1), shape, at)]);
        }
    }
    scene
}

fn carts_urdf(count: usize, apart: f64) -> String {
    let mut text = String::from("<robot name=\"carts\">\n<link name=\"base\"/>\n");
    for k in 0..count {
        let (n, y) = (k + 1, apart * k as f64);
        let cube = "<collision><geometry><box size=\"0.2 0.2 0.2\"/></geometry></collision>";
        // Writing to a `String` cannot fail.
        let _ = writeln!(text, "<link name=\"cart_{n}\">{cube}</link>");
        text += &slider(&format!("rail_{n}"), ["base", &format!("cart_{n}")], [0.0, y, 0.0], "1 0 0", 1.0);
    }
    text + "</robot>\n"
}

/// A ball on three sliders in a block of which half the cells are voxels: free space is many small
/// pockets.
pub fn voxels(rng: &mut ChaCha8Rng, name: &str) -> Written {
    let mut scene = Written::new(name);
    let _ = writeln!(scene.text, "\n[[robot]]\nurdf = \"ball/ball.urdf\"");
    scene.files.push(("ball/ball.urdf".into(), ball_urdf().into_bytes()));
    let [nx, ny, nz] = CELLS;
    let mut cells: Vec<usize> = (0..nx * ny * nz).collect();
    // The beginning of a shuffle by R. Durstenfeld, Algorithm 235, 1964.
    for k in 0..TAKEN_CELLS {
        let other = rng.random_range(k..cells.len());
        cells.swap(k, other);
    }
    cells.truncate(TAKEN_CELLS);
    cells.sort_unstable();
    for cell in cells {
        let [x, y, z] = [cell / (ny * nz), cell / nz % ny, cell % nz].map(|v| v as f64 * VOXEL_SIDE_M);
        let shape = Shape::Box([VOXEL_SIDE_M; 3]);
        scene.obstacles(&[still(format!("voxel_{cell}"), shape, [x - 0.4, y - 0.4, z])]);
    }
    scene
}

fn ball_urdf() -> String {
    let mut text =
        String::from("<robot name=\"ball\">\n<link name=\"world\"/>\n<link name=\"x\"/>\n<link name=\"y\"/>\n");
    text += "<link name=\"ball\"><collision><geometry><sphere radius=\"0.02\"/></geometry></collision></link>\n";
    for (name, links, axis) in
        [("x", ["world", "x"], "1 0 0"), ("y", ["x", "y"], "0 1 0"), ("z", ["y", "ball"], "0 0 1")]
    {
        text += &slider(&format!("slide_{name}"), links, [0.0; 3], axis, 0.5);
    }
    text + "</robot>\n"
}

fn slider(name: &str, [parent, child]: [&str; 2], [x, y, z]: [f64; 3], axis: &str, most: f64) -> String {
    format!(
        "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"{x} {y} {z}\"/><axis xyz=\"{axis}\"/>\
         <limit lower=\"-{most}\" upper=\"{most}\" effort=\"1\" velocity=\"1\"/></joint>\n"
    )
}

fn still(name: String, shape: Shape, xyz: [f64; 3]) -> Obstacle {
    Obstacle { name, shape, xyz, rpy: [0.0; 3] }
}

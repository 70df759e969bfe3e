//! Random robots and worlds for the test of the bounds: trees of all joint types with shapes of all
//! kinds, open meshes and flat sheets included, from millimetres to kilometres.

use std::fmt::Write;
use std::io::{Error as IoError, ErrorKind};
use std::path::Path;

use extricate::internals::scene::assemble::assemble;
use extricate::{Error, Scene};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Corners and outward faces of a box; faces count corners from 1, as OBJ files do.
const CORNERS: [[f64; 3]; 8] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [1., 1., -1.],
    [-1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [1., 1., 1.],
    [-1., 1., 1.],
];
const FACES: [[usize; 4]; 6] = [[1, 4, 3, 2], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]];

/// Returns the robot and world of a seed.
pub fn chain(number: u64) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(number);
    let scale = 10f64.powf(rng.random_range(-3.0..3.0));
    let mut files: Vec<(String, String)> = Vec::new();
    let joints = rng.random_range(1..=7);
    let mut urdf = String::from("<robot name=\"r\"><link name=\"l0\"/>");
    for joint in 1..=joints {
        let parent = if rng.random_bool(0.7) { joint - 1 } else { rng.random_range(0..joint) };
        let kind = ["revolute", "revolute", "revolute", "continuous", "prismatic"][rng.random_range(0..5)];
        let reach = if kind == "prismatic" { scale } else { 2.5 };
        let mimic = if joint > 1 && rng.random_bool(0.15) {
            format!("<mimic joint=\"j1\" multiplier=\"{}\" offset=\"0\"/>", rng.random_range(-1.0..1.0))
        } else {
            String::new()
        };
        let _ = write!(
            urdf,
            "<link name=\"l{joint}\">{}</link><joint name=\"j{joint}\" type=\"{kind}\"><parent link=\"l{parent}\"/>\
             <child link=\"l{joint}\"/><origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"{}\" upper=\"{reach}\" effort=\"1\" velocity=\"1\"/>{mimic}</joint>",
            collision(&mut rng, scale, &mut files),
            triple(&mut rng, 0.6 * scale),
            triple(&mut rng, 3.0),
            triple(&mut rng, 1.0),
            -reach,
        );
    }
    urdf.push_str("</robot>");
    let base = match rng.random_range(0..4) {
        0 => {
            format!("base = \"floating\"\nbounds = {{ min = [{0}, {0}, {0}], max = [{1}, {1}, {1}] }}\n", -scale, scale)
        }
        1 => format!("base = \"planar\"\nbounds = {{ min = [{0}, {0}], max = [{1}, {1}] }}\n", -scale, scale),
        _ => String::new(),
    };
    let mut toml = format!("[[robot]]\nurdf = \"r.urdf\"\n{base}");
    for obstacle in 0..rng.random_range(1..=3) {
        let size = |rng: &mut ChaCha8Rng| scale * rng.random_range(0.1..0.6);
        let shape = match rng.random_range(0..3) {
            0 => format!("{{ box = [{}, {}, {}] }}", size(&mut rng), size(&mut rng), size(&mut rng)),
            1 => format!("{{ sphere = {} }}", size(&mut rng)),
            _ => format!("{{ cylinder = [{}, {}] }}", size(&mut rng), size(&mut rng)),
        };
        let [x, y, z] = std::array::from_fn(|_| scale * rng.random_range(-0.8..0.8));
        let _ =
            write!(toml, "[[obstacle]]\nname = \"o{obstacle}\"\nshape = {shape}\npose = {{ xyz = [{x}, {y}, {z}] }}\n");
    }
    files.push(("r.urdf".into(), urdf));
    let mut read = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        let missing = || Error::Read { path: path.into(), source: IoError::new(ErrorKind::NotFound, "not in memory") };
        found.map(|(_, text)| text.clone().into_bytes()).ok_or_else(missing)
    };
    assemble(Path::new("scene.toml"), &toml, &mut read).expect("a scene")
}

fn triple(rng: &mut ChaCha8Rng, reach: f64) -> String {
    let [x, y, z]: [f64; 3] = std::array::from_fn(|_| reach * rng.random_range(-1.0..1.0));
    format!("{x} {y} {z}")
}

/// Writes one random shape, or none.
fn collision(rng: &mut ChaCha8Rng, scale: f64, files: &mut Vec<(String, String)>) -> String {
    let mut size = || scale * rng.random_range(0.05..0.4);
    let (a, b, c) = (size(), size(), size());
    let geometry = match rng.random_range(0..8) {
        0 => return String::new(),
        1 | 2 => format!("<box size=\"{a} {b} {c}\"/>"),
        3 => format!("<sphere radius=\"{}\"/>", 0.5 * a),
        4 => format!("<cylinder radius=\"{}\" length=\"{b}\"/>", 0.5 * a),
        kind => {
            // A closed mesh, an open one, or a flat sheet.
            let (faces, flat) = [(6, 1.0), (5, 1.0), (1, 0.0)][kind - 5];
            let name = format!("m{}.obj", files.len());
            let mut text = String::new();
            for [x, y, z] in CORNERS {
                let _ = writeln!(text, "v {} {} {}", 0.5 * a * x, 0.5 * b * y, 0.5 * c * z * flat);
            }
            for face in &FACES[..faces] {
                let _ = writeln!(text, "f {} {} {} {}", face[0], face[1], face[2], face[3]);
            }
            files.push((name.clone(), text));
            format!("<mesh filename=\"{name}\"/>")
        }
    };
    let (xyz, rpy) = (triple(rng, 0.1 * scale), triple(rng, 3.0));
    format!("<collision><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><geometry>{geometry}</geometry></collision>")
}

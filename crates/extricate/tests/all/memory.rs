//! Scenes assembled from files in memory, and models learned in them.

use std::io::{Error as IoError, ErrorKind};

use std::path::Path;

use extricate::internals::scene::assemble::assemble;
use extricate::{Error, LearnOptions, Model, Scene, Solver};

/// Assembles `scene.toml` among `files` (path relative to the scene, contents).
pub fn scene(toml: &str, files: &[(&str, String)]) -> Scene {
    let mut read = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        found.map(|(_, text)| text.clone().into_bytes()).ok_or_else(|| Error::Read {
            path: path.into(),
            source: IoError::new(ErrorKind::NotFound, "no such file in memory"),
        })
    };
    assemble(Path::new("scene.toml"), toml, &mut read).unwrap()
}

/// Learns until this number of labels is spent.
pub fn learn(scene: Scene, labels: usize, seed: u64) -> Model {
    Model::learn(scene, &labels_alone(labels, seed)).unwrap()
}

/// Does the same and returns a solver with the model.
pub fn learned(scene: Scene, labels: usize, seed: u64) -> Solver {
    Solver::of_model(learn(scene, labels, seed))
}

/// Returns options of a run that only a number of labels ends.
pub fn labels_alone(labels: usize, seed: u64) -> LearnOptions {
    let mut options = LearnOptions::default().labels(labels).seed(seed);
    options.seconds = None;
    options
}

/// Joint type, origin, axis, lower and upper limit, collision XML of the link.
pub type Joint<'a> = (&'a str, [f64; 3], [f64; 3], f64, f64, &'a str);

/// Writes a robot whose links form a chain from `base`, with one joint each.
pub fn chain(joints: &[Joint]) -> String {
    let mut urdf = String::from("<robot name=\"r\"><link name=\"base\"/>");
    let mut parent = "base".to_string();
    for (i, (kind, xyz, axis, lower, upper, collision)) in joints.iter().enumerate() {
        let child = format!("link{}", i + 1);
        let triple = |v: &[f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        urdf += &format!(
            "<link name=\"{child}\">{collision}</link><joint name=\"joint{}\" type=\"{kind}\"><parent link=\"{parent}\"/>\
             <child link=\"{child}\"/><origin xyz=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"1\" velocity=\"1\"/></joint>",
            i + 1,
            triple(xyz),
            triple(axis)
        );
        parent = child;
    }
    urdf + "</robot>"
}

/// Writes a `<collision>` element of a URDF.
pub fn collision(xyz: [f64; 3], rpy: [f64; 3], shape: &str) -> String {
    format!(
        "<collision><origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/><geometry>{shape}</geometry></collision>",
        xyz[0], xyz[1], xyz[2], rpy[0], rpy[1], rpy[2]
    )
}

//! What the fuzz targets do with an input, where their first inputs come from, and how inputs are
//! changed. Nothing here needs libFuzzer: `fuzz/` runs it on these functions, the tests replay
//! them, and the program of this package changes inputs at random.
//!
//! A target returns for every input that is answered rightly or refused with an error, and panics
//! for all else. Reading order: `container`, `spoil`, `scenes`, `model`, `roadmap`, `mutate`; then
//! `seeds`, `texts`, `meshes`.

pub mod container;
pub mod meshes;
pub mod model;
pub mod mutate;
pub mod roadmap;
pub mod scenes;
pub mod seeds;
pub mod spoil;
pub mod texts;

use rand_chacha::ChaCha8Rng;

/// Something that reads bytes of others.
pub struct Target {
    /// As the command line and `fuzz/fuzz_targets/` name it.
    pub name: &'static str,
    /// Reads an input and uses what was read; panics where the library does not keep its word.
    pub run: fn(&[u8]),
    /// The first inputs, made by the repository itself; each has a name.
    pub corpus: fn() -> Vec<(String, Vec<u8>)>,
    /// An input that differs from the first one, perhaps by what the second one has.
    pub mutate: fn(&mut ChaCha8Rng, &[u8], &[u8]) -> Vec<u8>,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target { name: "model", run: model::run, corpus: model::corpus, mutate: mutate::sealed },
    Target { name: "roadmap", run: roadmap::run, corpus: roadmap::corpus, mutate: mutate::sealed },
    plain("urdf", texts::urdf, seeds::urdf),
    plain("srdf", texts::srdf, seeds::srdf),
    plain("scene", texts::scene, seeds::scene),
    plain("world", texts::world, seeds::world),
    plain("moveit", texts::moveit, seeds::moveit),
    plain("queries", texts::queries, seeds::queries),
    plain("stl", meshes::stl, seeds::stl),
    plain("obj", meshes::obj, seeds::obj),
    plain("dae", meshes::dae, seeds::dae),
    plain("ply", meshes::ply, seeds::ply),
    plain("glb", meshes::glb, seeds::glb),
    plain("cloud", meshes::cloud, seeds::cloud),
];

/// A target whose inputs are changed as text and as bytes.
const fn plain(name: &'static str, run: fn(&[u8]), corpus: fn() -> Vec<(String, Vec<u8>)>) -> Target {
    Target { name, run, corpus, mutate: mutate::plain }
}

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

//! The fuzz targets, their first inputs, and ways to change inputs. Nothing here needs libFuzzer:
//! `fuzz/` runs it on these functions, the tests replay them, and the program of this package
//! changes inputs at random.
//!
//! A target returns if the input is answered rightly or refused with an error, and panics
//! otherwise. Reading order: `container`, `spoil`, `scenes`, `model`, `roadmap`, `mutate`; then
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

/// Reader of foreign bytes, with the inputs to try on it.
pub struct Target {
    /// Name on the command line and in `fuzz/fuzz_targets/`.
    pub name: &'static str,
    /// Reads an input and uses what was read; panics if the library breaks a promise.
    pub run: fn(&[u8]),
    /// Makes the first inputs, each with a name.
    pub corpus: fn() -> Vec<(String, Vec<u8>)>,
    /// Makes an input that differs from the first one, perhaps by a piece of the second one.
    pub mutate: fn(&mut ChaCha8Rng, &[u8], &[u8]) -> Vec<u8>,
}

/// All targets of the fuzzer.
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

/// Makes a target whose inputs are changed as text and as bytes.
const fn plain(name: &'static str, run: fn(&[u8]), corpus: fn() -> Vec<(String, Vec<u8>)>) -> Target {
    Target { name, run, corpus, mutate: mutate::plain }
}

/// Returns the target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

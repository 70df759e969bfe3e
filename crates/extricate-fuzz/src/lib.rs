//! What the fuzz targets do with an input, where their first inputs come from, and how inputs are
//! changed. Nothing here needs libFuzzer: `fuzz/` runs it on these functions, the tests replay
//! them, and the program of this package changes inputs at random.
//!
//! A target returns for every input that is answered rightly or refused with an error, and panics
//! for all else. Reading order: `container`, `spoil`, `scenes`, `model`, `checkpoint`, `mutate`.

pub mod checkpoint;
pub mod container;
pub mod model;
pub mod mutate;
pub mod scenes;
pub mod spoil;

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
    Target { name: "checkpoint", run: checkpoint::run, corpus: checkpoint::corpus, mutate: mutate::sealed },
];

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

//! The parts of a live page: the library as WebAssembly, and the scene or model that it opens.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use extricate::Solver;
use serde::Serialize;

/// The library as WebAssembly, gzipped; empty if this crate was built without it.
const BUILT_IN: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/extricate.wasm.gz"));

/// The library, and the scene or model that it opens, for the page.
#[derive(Debug, Serialize)]
pub struct Live {
    /// WebAssembly, gzipped or not, in base64.
    program: String,
    /// Bytes of a model file, or of a scene, in base64.
    scene: String,
    /// Bytes of the scene in which a model is queried, if it is not the one that was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    world: Option<String>,
}

impl Live {
    /// Returns the library as WebAssembly, if this crate was built with it.
    pub fn built_in() -> Option<&'static [u8]> {
        (!BUILT_IN.is_empty()).then_some(BUILT_IN)
    }

    /// Prepares a page that answers as `solver` does: from its scene, its model if it has one, or
    /// the model in the scene. `program` is the library as WebAssembly.
    pub fn new(program: &[u8], solver: &Solver) -> Self {
        let scene = || BASE64_STANDARD.encode(solver.scene().to_bytes());
        let (opened, world) = match solver.model() {
            None => (scene(), None),
            Some(model) => (BASE64_STANDARD.encode(model.to_bytes()), (!solver.is_learned()).then(scene)),
        };
        Self { program: BASE64_STANDARD.encode(program), scene: opened, world }
    }
}

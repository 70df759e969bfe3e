//! What makes a page live: the library as WebAssembly, and the scene or model that it opens.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use extricate::internals::io::model_file;
use extricate::{Model, Scene};
use serde::Serialize;

/// The library as WebAssembly, gzipped; empty where this was built without it.
const BUILT_IN: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/extricate.wasm.gz"));

/// The library, and what it opens, for the page.
#[derive(Debug, Serialize)]
pub struct Live {
    /// WebAssembly, gzipped or not, in base64.
    program: String,
    /// Bytes of a model file, or of a scene, in base64.
    scene: String,
    /// Bytes of the scene that a model is asked in, where it is not the one that was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    world: Option<String>,
}

impl Live {
    /// The library that was built in, if one was.
    pub fn built_in() -> Option<&'static [u8]> {
        (!BUILT_IN.is_empty()).then_some(BUILT_IN)
    }

    /// A page that asks without a model.
    ///
    /// # Errors
    /// Where the scene cannot be written as bytes, which none that was loaded causes.
    pub fn of_scene(program: &[u8], scene: &Scene) -> postcard::Result<Self> {
        Ok(Self::new(program, &postcard::to_stdvec(scene)?))
    }

    /// A page that asks a model.
    pub fn of_model(program: &[u8], model: &Model) -> Self {
        Self::new(program, &model_file::encode(model))
    }

    /// A page that asks a model in another scene than the one that was learned.
    ///
    /// # Errors
    /// As [`Live::of_scene`].
    pub fn of_model_in(program: &[u8], model: &Model, scene: &Scene) -> postcard::Result<Self> {
        let world = BASE64_STANDARD.encode(postcard::to_stdvec(scene)?);
        Ok(Self { world: Some(world), ..Self::of_model(program, model) })
    }

    fn new(program: &[u8], scene: &[u8]) -> Self {
        Self { program: BASE64_STANDARD.encode(program), scene: BASE64_STANDARD.encode(scene), world: None }
    }
}

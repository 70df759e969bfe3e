//! URDF to [`Robot`](super::Robot).

use std::sync::Arc;

use super::{Robot, TriangleMesh};
use crate::error::Result;

/// Loads an unscaled mesh by the `filename` attribute of a `<mesh>` element.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str) -> Result<Arc<TriangleMesh>>;

/// Parses URDF `text`; `file` is its name in messages. Warnings are appended to `warnings`.
pub fn parse(file: &str, text: &str, load_mesh: LoadMesh, warnings: &mut Vec<String>) -> Result<Robot> {
    let _ = (file, text, load_mesh, warnings);
    todo!()
}

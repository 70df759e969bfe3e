//! The one place that touches files: scenes in, models in and out.

use std::path::Path;

use crate::error::Result;
use crate::model::Model;
use crate::scene::Scene;

/// Loads a scene file and everything that it names.
pub fn load_scene(path: &Path) -> Result<Scene> {
    todo!("{}", path.display())
}

/// Loads a model file.
///
/// # Errors
/// [`crate::Error::Model`] where the file is truncated, altered, foreign or of another version.
pub fn load_model(path: &Path) -> Result<Model> {
    todo!("{}", path.display())
}

/// Writes a model file atomically: a reader sees the old file or the whole new one.
pub fn save_model(model: &Model, path: &Path) -> Result<()> {
    let _ = model;
    todo!("{}", path.display())
}

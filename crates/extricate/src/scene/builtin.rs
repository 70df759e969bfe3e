//! Built-in scenes: robots and obstacles that this code generates, as files in memory.

use super::Scene;
use crate::error::Result;

/// Names that [`scene`] knows.
pub const NAMES: &[&str] = &["shelf-arm"];

/// The files of a built-in scene: path relative to the scene file (first entry: the scene file itself) and contents.
pub fn files(name: &str) -> Option<Vec<(String, Vec<u8>)>> {
    todo!("{name}")
}

/// A built-in scene, assembled.
pub fn scene(name: &str) -> Result<Scene> {
    todo!("{name}")
}

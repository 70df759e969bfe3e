//! What reading a world gives.

use crate::scene::file::SceneFile;

/// A world that was read.
#[derive(Debug, Clone, Default)]
pub struct Imported {
    /// Its obstacles, attached objects, disabled pairs and padding.
    pub entries: SceneFile,
    /// What was taken for something else, or not taken, and why.
    pub notes: Vec<String>,
}

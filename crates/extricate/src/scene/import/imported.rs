//! The result of importing a world.

use crate::scene::file::SceneFile;

/// A world of another program, as entries of a scene file.
#[derive(Debug, Clone, Default)]
pub struct Imported {
    /// Obstacles, attached objects, disabled pairs and padding of the world.
    pub entries: SceneFile,
    /// Messages about what was approximated or left out, and why.
    pub notes: Vec<String>,
}

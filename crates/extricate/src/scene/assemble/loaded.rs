//! A robot that was read, with its entry, and the callback that reads files.

use std::path::Path;

use crate::error::Result;
use crate::robot::Robot;
use crate::robot::srdf::Srdf;
use crate::scene::file::RobotEntry;

/// Reads the bytes of a file; parsing has no other access to files. For a missing file it returns
/// [`crate::Error::Read`] with [`std::io::ErrorKind::NotFound`].
pub type ReadFile<'a> = &'a mut dyn FnMut(&Path) -> Result<Vec<u8>>;

/// A robot with its entry in the scene file.
#[derive(Debug, Clone)]
pub struct LoadedRobot<'a> {
    /// Name, unique in the scene.
    pub name: String,
    /// Name of the URDF file in messages.
    pub urdf: String,
    /// Links, joints and geometry, with meshes replaced as the entry requests.
    pub robot: Robot,
    /// Pairs of links in the SRDF; empty if there is none.
    pub srdf: Srdf,
    /// Indices of the joints of the chosen group; `None` if no group was chosen.
    pub group: Option<Vec<usize>>,
    /// Entry in the scene file.
    pub entry: &'a RobotEntry,
}

impl LoadedRobot<'_> {
    /// Returns the element for a message about `part` of the robot's entry.
    pub fn element(&self, part: &str) -> String {
        format!("robot \"{}\": {part}", self.name)
    }
}

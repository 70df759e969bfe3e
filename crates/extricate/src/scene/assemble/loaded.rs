//! A robot as it was read, with its entry; how files are read.

use std::path::Path;

use crate::error::Result;
use crate::robot::Robot;
use crate::robot::srdf::Srdf;
use crate::scene::file::RobotEntry;

/// Reads the bytes of a file; the only access that parsing has to the outside. A file that is not
/// there gives [`crate::Error::Read`] with [`std::io::ErrorKind::NotFound`].
pub type ReadFile<'a> = &'a mut dyn FnMut(&Path) -> Result<Vec<u8>>;

/// A robot with its entry in the scene file.
#[derive(Debug, Clone)]
pub struct LoadedRobot<'a> {
    /// Unique in the scene.
    pub name: String,
    /// The URDF file's name in messages.
    pub urdf: String,
    /// Its links, joints and geometry, hulled where the entry asks for it.
    pub robot: Robot,
    /// What the SRDF says of pairs of links; nothing where there is none.
    pub srdf: Srdf,
    /// Joints that may move; `None` where no group was chosen.
    pub group: Option<Vec<usize>>,
    /// What the scene file says of it.
    pub entry: &'a RobotEntry,
}

impl LoadedRobot<'_> {
    /// The element of a message about `part` of the robot's entry.
    pub fn element(&self, part: &str) -> String {
        format!("robot \"{}\": {part}", self.name)
    }
}

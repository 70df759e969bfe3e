//! From a scene file and the robots it names to a resolved [`Scene`](super::Scene).

use std::path::Path;

use super::Scene;
use crate::error::Result;

/// Reads the bytes of a file; the only access that parsing has to the outside.
pub type ReadFile<'a> = &'a mut dyn FnMut(&Path) -> Result<Vec<u8>>;

/// Parses the TOML `text` of the scene file at `path` and every file that it names.
pub fn assemble(path: &Path, text: &str, read: ReadFile) -> Result<Scene> {
    let _ = (path, text, read);
    todo!()
}

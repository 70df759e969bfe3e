//! The one place that touches files: scenes in, models in and out.

use std::path::Path;

use crate::error::{Error, Result};
use crate::model::Model;
use crate::scene::Scene;
use crate::scene::assemble::assemble;

/// Loads a scene file and everything that it names.
///
/// # Errors
/// [`crate::Error::Read`] for files that cannot be read, [`crate::Error::Input`] for those that cannot be used.
pub fn load_scene(path: &Path) -> Result<Scene> {
    let text = String::from_utf8(read(path)?).map_err(|error| {
        let at = format!("byte {}", error.utf8_error().valid_up_to());
        Error::input(path.display().to_string(), at, "not UTF-8, expected TOML")
    })?;
    assemble(path, &text, &mut read)
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn scenes_load_from_files_as_from_memory() {
        let folder = tempfile::tempdir().unwrap();
        let files = builtin::files("shelf-arm").unwrap();
        for (name, contents) in &files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, contents).unwrap();
        }
        let loaded = load_scene(&folder.path().join(&files[0].0)).unwrap();
        let built = builtin::scene("shelf-arm").unwrap();
        assert_eq!(loaded.pairs, built.pairs);
        assert_eq!(serde_json::to_string(&loaded).unwrap(), serde_json::to_string(&built).unwrap());

        std::fs::remove_file(folder.path().join("robot/meshes/link_3.stl")).unwrap();
        let missing = load_scene(&folder.path().join(&files[0].0)).unwrap_err().to_string();
        assert!(missing.contains("package://robot/meshes/link_3.stl") && missing.contains("tried"), "{missing}");
        assert!(matches!(load_scene(&folder.path().join("none.toml")), Err(Error::Read { .. })));
    }
}

//! The one place that touches files: scenes in, models in and out.

use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::model::Model;
use crate::model_file;
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
    model_file::decode(path, &read(path)?)
}

/// Writes a model file atomically: a reader sees the old file or the whole new one.
///
/// # Errors
/// [`crate::Error::Write`]; the old file, if any, is then untouched.
pub fn save_model(model: &Model, path: &Path) -> Result<()> {
    let fault = |source| Error::Write { path: path.into(), source };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".extricate-").tempfile_in(folder).map_err(fault)?;
    file.write_all(&model_file::encode(model)).map_err(fault)?;
    file.as_file().sync_all().map_err(fault)?;
    allow_others_to_read(file.as_file()).map_err(fault)?;
    file.persist(path).map_err(|e| fault(e.error))?;
    Ok(())
}

/// Temporary files are private to their owner; a model is as public as any file that the user writes.
#[cfg(unix)]
fn allow_others_to_read(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn allow_others_to_read(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
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

//! Decides whether a file is a scene or a model.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::Context;
use extricate::files::check_regular;
use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FileKind {
    /// A TOML file or a URDF.
    Scene,
    /// A model that `learn` wrote.
    Model,
}

/// Returns the kind of a file. Text without NUL is a scene, because a model file begins with the
/// length of its header as a binary number. The name decides for `.toml`, and for a file that is
/// too short.
pub fn kind_of(path: &Path) -> anyhow::Result<FileKind> {
    let extension = path.extension().and_then(|e| e.to_str());
    if extension == Some("toml") {
        return Ok(FileKind::Scene);
    }
    let mut head = Vec::new();
    check_regular(path)
        .and_then(|_| File::open(path))
        .and_then(|file| file.take(512).read_to_end(&mut head))
        .with_context(|| format!("cannot read {}", path.display()))?;
    let binary = head.contains(&0) || (head.len() < 8 && extension == Some("model"));
    Ok(if binary { FileKind::Model } else { FileKind::Scene })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_told_from_models() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            kind_of(&path).unwrap()
        };
        assert_eq!(kind("a.toml", b"\0"), FileKind::Scene);
        assert_eq!(kind("a", b"clearance = 1e-4\n"), FileKind::Scene);
        assert_eq!(kind("b", b"\x40\x02\0\0\0\0\0\0{\"x\":1}"), FileKind::Model);
        assert_eq!(kind("short.model", b"\x40"), FileKind::Model);
        assert_eq!(kind("empty.model", b""), FileKind::Model);
        assert!(kind_of(&folder.path().join("missing")).unwrap_err().to_string().contains("missing"));
    }
}

//! Built-in scenes: robots and obstacles that this code generates as files in memory.
//!
//! The files have the formats of users (TOML, URDF, binary STL) and are read by the same code as
//! files on disk. All lengths are in metres, all angles in radians.

mod dual_arm;
mod file;
mod four_legs;
mod free_box;
mod hand;
mod planar_arm;
mod seven_joint_arm;
mod shelf_arm;
mod swept_meshes;
mod urdf_text;

use std::io::ErrorKind;
use std::path::Path;

use super::assemble::assemble;
use super::{Scene, names};
use crate::error::{Error, Result};

/// Names of all built-in scenes.
pub const NAMES: &[&str] = &["shelf-arm", "planar-arm", "free-box", "dual-arm", "hand", "four-legs"];

/// Returns path and contents of each file of a built-in scene, the scene file first. Paths are
/// relative to the scene file.
///
/// ```
/// let files = extricate::builtin::files("planar-arm").unwrap();
/// assert_eq!(files[0].0, "planar-arm.toml");
/// ```
pub fn files(name: &str) -> Option<Vec<(String, Vec<u8>)>> {
    let (text, mut rest) = match name {
        "shelf-arm" => shelf_arm::files(),
        "planar-arm" => planar_arm::files(),
        "free-box" => free_box::files(),
        "dual-arm" => dual_arm::files(),
        "hand" => hand::files(),
        "four-legs" => four_legs::files(),
        _ => return None,
    };
    rest.insert(0, (format!("{name}.toml"), text.into_bytes()));
    Some(rest)
}

/// Assembles a built-in scene.
///
/// # Errors
/// [`Error::Input`] with the known names if there is no such scene.
pub fn scene(name: &str) -> Result<Scene> {
    let files = files(name).ok_or_else(|| Error::input(name, "built-in scene", names::unknown(name, NAMES)))?;
    let text = String::from_utf8_lossy(&files[0].1);
    assemble(Path::new(&files[0].0), &text, &mut |path| {
        let wanted: std::path::PathBuf = path.components().filter(|part| part.as_os_str() != ".").collect();
        match files.iter().find(|(name, _)| Path::new(name) == wanted) {
            Some((_, contents)) => Ok(contents.clone()),
            None => Err(Error::Read { path: path.into(), source: ErrorKind::NotFound.into() }),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Geometry;

    #[test]
    fn all_assemble_without_warnings() {
        let expected = [
            ("shelf-arm", 7, 8),
            ("planar-arm", 3, 6),
            ("free-box", 7, 2),
            ("dual-arm", 14, 2),
            ("hand", 5, 0),
            ("four-legs", 12, 8),
        ];
        assert_eq!(expected.map(|(name, ..)| name), NAMES);
        for (name, nq, obstacles) in expected {
            let scene = scene(name).unwrap();
            assert_eq!(scene.warnings, [""; 0], "{name}");
            assert_eq!(scene.space.nq(), nq, "{name}");
            assert_eq!(scene.bodies.iter().filter(|body| body.robot.is_none()).count(), obstacles, "{name}");
            assert!(!scene.pairs.is_empty(), "{name}");
        }
    }

    #[test]
    fn meshes_are_closed_and_of_a_few_hundred_triangles() {
        for name in NAMES {
            for body in scene(name).unwrap().bodies {
                for part in &body.parts {
                    if let Geometry::Mesh(mesh) = &part.geometry {
                        assert!(mesh.components.iter().all(|component| component.closed), "{name} {}", body.name);
                        assert!((100..2000).contains(&mesh.triangles.len()), "{name} {}", body.name);
                    }
                }
            }
        }
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        assert!(files("shelf").is_none());
        assert!(scene("shelf").unwrap_err().to_string().contains("`shelf-arm`, `planar-arm`"));
    }
}

//! Imports worlds that other programs wrote as entries of a scene file: MoveIt's `.scene` text, and
//! PlanningScene messages as YAML or JSON.
//!
//! Notes report what a scene file cannot hold, so that nothing is dropped silently.

mod imported;
mod joint_state;
mod matrix;
mod message;
mod message_objects;
mod message_pose;
mod objects;
mod scene_text;
mod toml_text;
mod value;

use std::path::Path;

pub use toml_text::{ShapeFile, to_toml};

use super::Scene;
use super::file::{SceneFile, most_values};
use crate::error::{Error, Result};
use crate::robot::{LoadLimit, LoadLimits};

pub use imported::Imported;
pub use joint_state::joint_positions;

/// Returns whether a file has the extension `.scene`, `.yaml`, `.yml` or `.json`.
pub fn is_foreign(path: &Path) -> bool {
    kind(path).is_some()
}

enum Kind {
    SceneText,
    Yaml,
    Json,
}

fn kind(path: &Path) -> Option<Kind> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "scene" => Some(Kind::SceneText),
        "yaml" | "yml" => Some(Kind::Yaml),
        "json" => Some(Kind::Json),
        _ => None,
    }
}

/// Reads the `text` of the file at `path`, whose extension selects the format.
///
/// If `robots` is given, poses may be given in frames of its links, and unknown names are left out
/// of the disabled pairs.
///
/// # Errors
/// [`Error::Input`] that names the file, the line or element, the value and what was expected.
///
/// # Source
/// Text: the format that MoveIt's `PlanningScene::loadGeometryFromStream` reads. Messages:
/// `moveit_msgs/PlanningScene` and the messages in it.
pub fn import(path: &Path, text: &str, robots: Option<&Scene>, limits: &LoadLimits) -> Result<Imported> {
    let file = path.display().to_string();
    limits.check(LoadLimit::TextBytes, text.len(), &file, "file")?;
    limits.check(LoadLimit::Values, most_values(text), &file, "world")?;
    let imported = match kind(path) {
        Some(Kind::SceneText) => scene_text::read(&file, text, limits),
        Some(Kind::Yaml) => message::read(&file, &value::of_yaml(&file, text, limits)?, robots, limits),
        Some(Kind::Json) => message::read(&file, &value::of_json(&file, text)?, robots, limits),
        None => {
            let problem = "got a name that tells no format, expected one that ends in .scene, .yaml, .yml or .json";
            Err(Error::input(file, "name", problem))
        }
    };
    imported
        .map(|Imported { entries, notes }| Imported { entries: SceneFile { limits: limits.clone(), ..entries }, notes })
}

#[cfg(test)]
mod tests;

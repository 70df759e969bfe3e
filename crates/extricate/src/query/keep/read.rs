//! Reading of what a query keeps from JSON, which all shells use.

use serde::Deserialize;

use super::{KeptLink, POSITION_M, ROTATION_RAD};
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::scene::file::PoseEntry;

/// One kept link, with names in place of indices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    link: String,
    #[serde(default)]
    relative_to: Option<String>,
    #[serde(default)]
    pose: Option<PoseEntry>,
    #[serde(default = "position")]
    position: Option<f64>,
    #[serde(default = "rotation")]
    rotation: Option<f64>,
    #[serde(default)]
    axis: Option<[f64; 3]>,
}

fn position() -> Option<f64> {
    Some(POSITION_M)
}

fn rotation() -> Option<f64> {
    Some(ROTATION_RAD)
}

impl KeptLink {
    /// Reads the links that a query keeps: the name of a link, or a JSON object or array of
    /// objects. An object has the key `link`.
    ///
    /// `position` \[m\] and `rotation` \[rad\] are its tolerances, 1e-4 and 1e-3 if not given. Null
    /// leaves the link free. `axis` and `relative_to` (the name of a link) are as in [`KeptLink`].
    /// `pose` is written as in scene files.
    ///
    /// ```
    /// use extricate::{KeptLink, builtin};
    /// let scene = builtin::scene("planar-arm")?;
    /// let held = KeptLink::from_text(&scene, "{\"link\": \"link_3\", \"rotation\": null}")?;
    /// assert_eq!(held[0].rotation, None);
    /// # extricate::Result::Ok(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Input`] for a link that the scene does not have, or a pose that makes no sense;
    /// [`Error::Option`] for a text that is neither, or other values that make no sense.
    pub fn from_text(scene: &Scene, text: &str) -> Result<Vec<Self>> {
        let is_json = text.trim_start().starts_with(['{', '[']);
        let entries = if is_json { parse(text)? } else { parse(&serde_json::json!({ "link": text }).to_string())? };
        entries.into_iter().map(|entry| entry.keep(scene)).collect()
    }
}

/// Reads an object, or an array of objects.
fn parse(text: &str) -> Result<Vec<Entry>> {
    let read = match text.trim_start().starts_with('[') {
        true => serde_json::from_str(text),
        false => serde_json::from_str(text).map(|entry| vec![entry]),
    };
    read.map_err(|error| {
        let expected = format!("the name of a link, or objects like {{\"link\": \"tool0\"}}: {error}");
        Error::Option { name: "keep", value: text.into(), expected }
    })
}

impl Entry {
    fn keep(self, scene: &Scene) -> Result<KeptLink> {
        let link = |name: &str| scene.link_named("keep", name);
        let keep = KeptLink {
            link: link(&self.link)?,
            relative_to: self.relative_to.as_deref().map(link).transpose()?,
            pose: self.pose.map(|pose| pose.pose("keep", &self.link)).transpose()?,
            position: self.position,
            rotation: self.rotation,
            axis: self.axis,
        };
        keep.check()?;
        Ok(keep)
    }
}

//! The scene of a model as bytes, of this version and of those before.

use serde::{Deserialize, Serialize};

use super::FORMAT;
use crate::cspace::ConfigSpace;
use crate::scene::clearances::Clearances;
use crate::scene::{Body, BodyPair, Frame, MetricSpec, Scene, SceneJoint};

/// A scene as versions 5 to 7 wrote it: of links they kept those with geometry alone, and every
/// pair kept the same clearance.
#[derive(Serialize, Deserialize)]
struct OldScene {
    clearance: f64,
    metric: MetricSpec,
    joints: Vec<SceneJoint>,
    space: ConfigSpace,
    frames: Vec<Frame>,
    bodies: Vec<Body>,
    pairs: Vec<BodyPair>,
    warnings: Vec<String>,
}

/// Reads the scene of a file of the version `format`.
pub fn decode(format: u64, bytes: &[u8]) -> postcard::Result<Scene> {
    if format == u64::from(FORMAT) {
        return postcard::from_bytes(bytes);
    }
    let OldScene { clearance, metric, joints, space, frames, bodies, pairs, warnings } = postcard::from_bytes(bytes)?;
    let (links, clearances) = (Vec::new(), Clearances::default());
    Ok(Scene { clearance, metric, joints, space, frames, bodies, pairs, warnings, links, clearances })
}

/// The bytes that versions 5 to 7 wrote.
#[cfg(test)]
pub fn encode_old(scene: Scene) -> Vec<u8> {
    let Scene { clearance, metric, joints, space, frames, bodies, pairs, warnings, .. } = scene;
    postcard::to_stdvec(&OldScene { clearance, metric, joints, space, frames, bodies, pairs, warnings }).unwrap()
}

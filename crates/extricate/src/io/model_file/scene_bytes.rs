//! The scene of a model as bytes, of this version and of earlier ones.

use crate::scene::clearances::Clearances;
use crate::scene::{LinkAttachment, RigidJoint, Scene};

/// First version that stores which joints are rigid.
const FIRST_WITH_RIGID: u64 = 9;

/// Reads the scene of a file of the version `format`.
///
/// Later versions append fields, which are empty for earlier ones: 5 to 7 stored no links and one
/// clearance for all pairs, 8 no rigid joints.
pub fn decode(format: u64, bytes: &[u8]) -> postcard::Result<Scene> {
    let missing = match format {
        FIRST_WITH_RIGID.. => return postcard::from_bytes(bytes),
        8 => postcard::to_stdvec(&Vec::<RigidJoint>::new())?,
        _ => postcard::to_stdvec(&(Vec::<LinkAttachment>::new(), Clearances::default(), Vec::<RigidJoint>::new()))?,
    };
    postcard::from_bytes(&[bytes, &missing].concat())
}

/// Returns the bytes that version `format`, before 9, wrote.
#[cfg(test)]
pub fn encode_old(format: u64, scene: Scene) -> Vec<u8> {
    let Scene { clearance, metric, joints, space, frames, bodies, pairs, warnings, links, clearances, .. } = scene;
    let old = (clearance, metric, joints, space, frames, bodies, pairs, warnings);
    if format < 8 {
        postcard::to_stdvec(&old).unwrap()
    } else {
        postcard::to_stdvec(&(old, links, clearances)).unwrap()
    }
}

//! Single values of a scene: indices, lengths, poses. Each fault says which value it is, what was
//! found, and what was expected.

use crate::math::{FARTHEST, Mat3, Pose};

/// How far from orthonormal a rotation may be: twice what one that a caller gives may be, since
/// poses are composed.
const ROTATION: f64 = 2e-9;
/// Farthest place of a pose \[m\]: chains of fixed joints add up.
const FARTHEST_POSE: f64 = 1e3 * FARTHEST;

/// An index below `count`.
pub fn index(what: &str, found: usize, count: usize) -> Result<(), String> {
    if found < count { Ok(()) } else { Err(format!("{what}: got {found}, expected an index below {count}")) }
}

/// A length that a clearance may have \[m\].
pub fn length(what: &str, found: f64) -> Result<(), String> {
    within(what, found, 0.0)
}

/// A number from `least` to 1e9.
pub fn within(what: &str, found: f64, least: f64) -> Result<(), String> {
    if (least..=FARTHEST).contains(&found) {
        Ok(())
    } else {
        Err(format!("{what}: got {found:?}, expected {least} to 1e9"))
    }
}

/// A rotation and a place within reach.
pub fn pose(what: &str, found: &Pose) -> Result<(), String> {
    let Pose { rotation, translation } = found;
    let off = (rotation * rotation.transpose() - Mat3::identity()).norm();
    // Not the other way round, so that what is no number is refused.
    if !(off < ROTATION && rotation.determinant() > 0.0) {
        return Err(format!("{what}: got the columns {:?}, expected a rotation", rotation.as_slice()));
    }
    match translation.iter().find(|x| !(-FARTHEST_POSE..=FARTHEST_POSE).contains(*x)) {
        Some(bad) => Err(format!("{what}: got {bad:?}, expected a place within 1e12 [m]")),
        None => Ok(()),
    }
}

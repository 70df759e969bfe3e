//! Checks single values of a scene: indices, lengths, poses. Errors name the value, what was found
//! and what was expected.

use crate::math::{FARTHEST, Mat3, Pose};

/// Largest norm of `R R^T - I` of a rotation: twice that of poses from callers, as poses are
/// composed.
const ROTATION_TOLERANCE: f64 = 2e-9;
/// Largest coordinate of a pose \[m\]; it exceeds [`FARTHEST`], as chains of fixed joints add up.
const MAX_POSITION_M: f64 = 1e3 * FARTHEST;

/// Checks that an index is below `count`.
pub fn index(what: &str, found: usize, count: usize) -> Result<(), String> {
    if found < count { Ok(()) } else { Err(format!("{what}: got {found}, expected an index below {count}")) }
}

/// Checks that a length is one that a clearance may have \[m\].
pub fn length(what: &str, found: f64) -> Result<(), String> {
    within(what, found, 0.0)
}

/// Checks that a number is from `least` to 1e9.
pub fn within(what: &str, found: f64, least: f64) -> Result<(), String> {
    if (least..=FARTHEST).contains(&found) {
        Ok(())
    } else {
        Err(format!("{what}: got {found:?}, expected {least} to 1e9"))
    }
}

/// Checks that a pose has a rotation matrix and lies within 1e12 m.
pub fn pose(what: &str, found: &Pose) -> Result<(), String> {
    let Pose { rotation, translation } = found;
    let off = (rotation * rotation.transpose() - Mat3::identity()).norm();
    // The comparison is false for NaN, so that NaN is refused.
    if !(off < ROTATION_TOLERANCE && rotation.determinant() > 0.0) {
        return Err(format!("{what}: got the columns {:?}, expected a rotation", rotation.as_slice()));
    }
    match translation.iter().find(|x| !(-MAX_POSITION_M..=MAX_POSITION_M).contains(*x)) {
        Some(bad) => Err(format!("{what}: got {bad:?}, expected a place within 1e12 [m]")),
        None => Ok(()),
    }
}

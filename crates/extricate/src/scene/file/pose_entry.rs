//! `pose = { .. }`: a position and an orientation as users write them.

use serde::Deserialize;

use super::arrays::{exactly, exactly_if_any};
use crate::error::{Error, Result};
use crate::math::{FARTHEST, Pose, Vec3, quaternion_matrix};

/// Largest deviation of a quaternion's length from 1; files round components to a few digits.
pub const QUATERNION_TOLERANCE: f64 = 1e-3;

/// `pose = { xyz = .., rpy = .. }`, or with a quaternion; its key names the order of components.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table `{ xyz = [..], rpy = [..] }`, or with quat_xyzw or quat_wxyz in place of rpy"
)]
pub struct PoseEntry {
    /// Position x, y, z \[m\].
    #[serde(default, deserialize_with = "exactly")]
    pub xyz: [f64; 3],
    /// Roll, pitch and yaw about the fixed axes x, y, z \[rad\].
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub rpy: Option<[f64; 3]>,
    /// Unit quaternion x, y, z, w.
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub quat_xyzw: Option<[f64; 4]>,
    /// Unit quaternion w, x, y, z.
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub quat_wxyz: Option<[f64; 4]>,
}

impl PoseEntry {
    /// Returns the pose, without rotation if no orientation is given.
    ///
    /// # Errors
    /// [`Error::Input`] if a number is not finite or beyond 1e9, if several orientations are given,
    /// and if the length of a quaternion differs from 1 by more than 1e-3.
    pub fn pose(&self, file: &str, element: &str) -> Result<Pose> {
        let fault = |problem: String| Err(Error::input(file, element, format!("pose: {problem}")));
        let numbers = self.xyz.iter().chain(self.rpy.iter().flatten());
        let mut numbers = numbers.chain(self.quat_xyzw.iter().flatten()).chain(self.quat_wxyz.iter().flatten());
        if let Some(bad) = numbers.find(|x| !(-FARTHEST..=FARTHEST).contains(*x)) {
            return fault(format!("got {bad:?}, expected finite numbers within 1e9"));
        }
        let given = [("rpy", self.rpy.is_some()), ("quat_xyzw", self.quat_xyzw.is_some())];
        let given = given.into_iter().chain([("quat_wxyz", self.quat_wxyz.is_some())]);
        let given: Vec<&str> = given.filter_map(|(name, given)| given.then_some(name)).collect();
        if given.len() > 1 {
            return fault(format!("got {}, expected one of them", given.join(" and ")));
        }
        let (name, [x, y, z, w]) = match (self.quat_xyzw, self.quat_wxyz) {
            (Some(quaternion), _) => ("quat_xyzw", quaternion),
            (None, Some([w, x, y, z])) => ("quat_wxyz", [x, y, z, w]),
            (None, None) => return Ok(Pose::from_xyz_rpy(self.xyz, self.rpy.unwrap_or_default())),
        };
        let length = [x, y, z, w].iter().map(|c| c * c).sum::<f64>().sqrt();
        if (length - 1.0).abs() > QUATERNION_TOLERANCE {
            return fault(format!("{name}: got a quaternion of length {length}, expected length 1"));
        }
        let rotation = quaternion_matrix(&[x, y, z, w].map(|c| c / length));
        Ok(Pose { rotation, translation: Vec3::from(self.xyz) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;

    fn pose(text: &str) -> Result<Pose> {
        let text = format!("[[obstacle]]\nname = 'a'\nshape = {{ sphere = 1 }}\npose = {text}");
        file::parse("s.toml", &text)?.obstacle[0].pose.pose("s.toml", "obstacle \"a\"")
    }

    #[test]
    fn orientations_of_every_spelling_agree() {
        let (half, expected) = (0.6_f64, pose("{ xyz = [1, 2, 3], rpy = [0, 0, 1.2] }").unwrap());
        let (sine, cosine) = half.sin_cos();
        for text in [
            format!("{{ xyz = [1, 2, 3], quat_xyzw = [0, 0, {sine}, {cosine}] }}"),
            format!("{{ xyz = [1, 2, 3], quat_wxyz = [{cosine}, 0, 0, {sine}] }}"),
            format!("{{ xyz = [1, 2, 3], quat_wxyz = [{:.4}, 0, 0, {:.4}] }}", -cosine, -sine),
        ] {
            let pose = pose(&text).unwrap();
            assert_eq!(pose.translation, expected.translation);
            assert!((pose.rotation - expected.rotation).norm() < 3e-4, "{text}");
            assert!((pose.rotation * pose.rotation.transpose() - crate::math::Mat3::identity()).norm() < 1e-12);
        }
        assert_eq!(pose("{ xyz = [0, 0, 1] }").unwrap(), Pose::translation(Vec3::z()));
    }

    #[test]
    fn the_order_is_never_guessed_and_the_length_is_checked() {
        let message = |text: &str| pose(text).unwrap_err().to_string();
        let unnamed = message("{ quat = [0, 0, 0, 1] }");
        assert!(unnamed.contains("`quat`") && unnamed.contains("`quat_xyzw`"), "{unnamed}");
        for (text, expected) in [
            ("{ quat_xyzw = [0, 0, 0, 2] }", "pose: quat_xyzw: got a quaternion of length 2, expected length 1"),
            ("{ quat_wxyz = [0, 0, 0, 0] }", "quat_wxyz: got a quaternion of length 0"),
            ("{ quat_wxyz = [nan, 0, 0, 0] }", "pose: got NaN, expected finite"),
            ("{ quat_xyzw = [0, 0, 1] }", "got an array of 3, expected one of 4"),
            ("{ quat_xyzw = [0, 0, 0, 1], rpy = [0, 0, 0] }", "got rpy and quat_xyzw, expected one of them"),
            ("{ quat_xyzw = [0, 0, 0, 1], quat_wxyz = [1, 0, 0, 0] }", "got quat_xyzw and quat_wxyz"),
            ("3", "expected a table `{ xyz = [..], rpy = [..] }`, or with quat_xyzw or quat_wxyz"),
        ] {
            assert!(message(text).contains(expected), "{text}: {}", message(text));
        }
    }
}

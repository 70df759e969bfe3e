//! Poses in the form of messages.

use crate::math::{Mat3, Vec3, quaternion_matrix, quaternion_product};
use crate::scene::file::PoseEntry;

/// A position \[m\] and a unit quaternion x, y, z, w.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MessagePose {
    pub xyz: [f64; 3],
    pub quaternion: [f64; 4],
}

impl MessagePose {
    pub const IDENTITY: Self = Self { xyz: [0.0; 3], quaternion: [0.0, 0.0, 0.0, 1.0] };

    /// Composes poses: returns `pose_a_c` from `pose_a_b` (self) and `pose_b_c`.
    pub fn then(&self, other: &Self) -> Self {
        let rotation: Mat3 = quaternion_matrix(&self.quaternion);
        let xyz = Vec3::from(self.xyz) + rotation * Vec3::from(other.xyz);
        Self { xyz: xyz.into(), quaternion: quaternion_product(&self.quaternion, &other.quaternion) }
    }

    /// Converts it to an entry of a scene file.
    pub fn entry(&self) -> PoseEntry {
        let turned = self.quaternion != Self::IDENTITY.quaternion;
        PoseEntry { xyz: self.xyz, quat_xyzw: turned.then_some(self.quaternion), ..PoseEntry::default() }
    }
}

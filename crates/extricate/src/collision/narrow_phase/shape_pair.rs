//! Two shapes without a scene: the exact test of one pair alone, for benchmarks and for callers
//! that have two meshes and no robot.

use super::memory::{Buffers, SeparatingWitness};
use super::pair;
use crate::collision::prepared::{Placed, PreparedShape};
use crate::math::Pose;

/// Memory that checks of one pair of shapes reuse.
///
/// It remembers the features that were near last, to try them first. No answer depends on it.
#[derive(Default)]
pub struct PairScratch {
    hint: SeparatingWitness,
    buffers: Buffers,
}

impl PreparedShape {
    /// Whether the signed distance to `other` is below `limit` \[m\]. `pose_self_other` places
    /// `other` in the frame of this shape.
    ///
    /// # Guarantee
    /// Same as [`crate::Checker::label`] with `limit` as clearance: exact to rounding, and a shape
    /// inside a closed component is near.
    pub fn is_nearer(&self, other: &Self, pose_self_other: &Pose, limit: f64, scratch: &mut PairScratch) -> bool {
        let here = Pose::identity();
        let (a, b) = (Placed { prepared: self, pose: &here }, Placed { prepared: other, pose: pose_self_other });
        pair::nearer(a, b, limit, &mut scratch.hint, &mut scratch.buffers)
    }

    /// Signed distance \[m\] to `other`, placed as in [`PreparedShape::is_nearer`], if below
    /// `cutoff`. Overlapping meshes are measured as in [`crate::Checker::clearance`].
    pub fn signed_distance(
        &self,
        other: &Self,
        pose_self_other: &Pose,
        cutoff: f64,
        scratch: &mut PairScratch,
    ) -> Option<f64> {
        let here = Pose::identity();
        let (a, b) = (Placed { prepared: self, pose: &here }, Placed { prepared: other, pose: pose_self_other });
        pair::signed_distance(a, b, cutoff, &mut scratch.buffers)
    }
}

impl PairScratch {
    /// Forgets the features that were near last.
    pub fn forget(&mut self) {
        self.hint = SeparatingWitness::default();
    }
}

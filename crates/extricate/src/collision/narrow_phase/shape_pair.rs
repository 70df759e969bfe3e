//! Two shapes that no scene holds: the test that checks of scenes end in, by itself. For
//! benchmarks, and for those who have two meshes and no robot.

use super::memory::{Buffers, SeparatingWitness};
use super::pair;
use crate::collision::prepared::{Placed, PreparedShape};
use crate::math::Pose;

/// Memory that checks of one pair of shapes reuse.
///
/// It remembers where the pair was near last, to look there first; no answer depends on it.
#[derive(Default)]
pub struct PairScratch {
    hint: SeparatingWitness,
    buffers: Buffers,
}

impl PreparedShape {
    /// Whether the signed distance to `other`, which `pose_self_other` places in the frame of this
    /// shape, is below `limit` \[m\].
    ///
    /// # Guarantee
    /// That of [`crate::Checker::label`] with `limit` as clearance: exact to rounding; what is
    /// inside a closed component is near.
    pub fn is_nearer(&self, other: &Self, pose_self_other: &Pose, limit: f64, scratch: &mut PairScratch) -> bool {
        let here = Pose::identity();
        let (a, b) = (Placed { prepared: self, pose: &here }, Placed { prepared: other, pose: pose_self_other });
        pair::nearer(a, b, limit, &mut scratch.hint, &mut scratch.buffers)
    }

    /// Signed distance \[m\] to `other`, placed as above, where it is below `cutoff`; of meshes
    /// that overlap, what [`crate::Checker::clearance`] says of them.
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
    /// Forgets where the pair was near last.
    pub fn forget(&mut self) {
        self.hint = SeparatingWitness::default();
    }
}

//! Two shapes that no scene holds: the test that checks of scenes end in, by itself. For benchmarks, and for those who have
//! two meshes and no robot.

use super::part_pair::{self, Buffers, Hint, Placed};
use super::shape::Shape;
use crate::math::Pose;
use crate::robot::Geometry;

/// A shape prepared for checks against others: a tree of triangles, or a convex solid. Immutable, shared between threads.
///
/// ```
/// use extricate::collision::{PairScratch, PreparedShape};
/// use extricate::math::{Pose, Vec3};
/// use extricate::robot::Geometry;
/// let ball = PreparedShape::new(&Geometry::Sphere { radius: 1.0 }).unwrap();
/// let apart = Pose::translation(Vec3::new(2.5, 0.0, 0.0));
/// assert!(!ball.is_nearer(&ball, &apart, 0.4, &mut PairScratch::default()));
/// assert!(ball.is_nearer(&ball, &apart, 0.6, &mut PairScratch::default()));
/// ```
pub struct PreparedShape(Shape);

/// Memory that checks of one pair of shapes reuse.
///
/// It remembers where the pair was near last, to look there first; no answer depends on it.
#[derive(Default)]
pub struct PairScratch {
    hint: Hint,
    buffers: Buffers,
}

impl PreparedShape {
    /// Prepares `geometry`; `None` for a mesh without triangles.
    ///
    /// # Cost
    /// For a mesh that of sorting its triangles a few times over.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        Shape::new(geometry).map(Self)
    }

    /// Whether the signed distance to `other`, which `pose_self_other` places in the frame of this shape, is below
    /// `limit` \[m\].
    ///
    /// # Guarantee
    /// That of [`crate::Checker::label`] with `limit` as clearance: exact to rounding; what is inside a closed component
    /// is near.
    pub fn is_nearer(&self, other: &Self, pose_self_other: &Pose, limit: f64, scratch: &mut PairScratch) -> bool {
        let here = Pose::identity();
        let (a, b) = (self.placed(&here), other.placed(pose_self_other));
        part_pair::nearer(a, b, limit, &mut scratch.hint, &mut scratch.buffers)
    }

    /// Signed distance \[m\] to `other`, placed as above, where it is below `cutoff`; of meshes that overlap, what
    /// [`crate::Checker::clearance`] says of them.
    pub fn signed_distance(
        &self,
        other: &Self,
        pose_self_other: &Pose,
        cutoff: f64,
        scratch: &mut PairScratch,
    ) -> Option<f64> {
        let here = Pose::identity();
        let (a, b) = (self.placed(&here), other.placed(pose_self_other));
        part_pair::signed_distance(a, b, cutoff, &mut scratch.buffers)
    }

    fn placed<'a>(&'a self, pose: &'a Pose) -> Placed<'a> {
        Placed { shape: &self.0, pose }
    }
}

impl PairScratch {
    /// Forgets where the pair was near last.
    pub fn forget(&mut self) {
        self.hint = Hint::default();
    }
}

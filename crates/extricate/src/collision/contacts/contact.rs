//! A contact of two bodies, and how exact contacts are requested. No search.

use serde::Serialize;

use crate::kinematics::{Twists, Wrench};
use crate::math::Vec3;
use crate::scene::{PairId, Scene};

/// Two points at which the bodies of a checked pair are near each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Contact {
    /// Index into [`Scene::pairs`].
    pub pair: PairId,
    /// Signed distance \[m\], negative if the two overlap. From
    /// [`crate::collision::Checker::contacts`] it comes without what the pair keeps beyond the
    /// clearance of the scene.
    pub distance: f64,
    /// Nearest (or deepest) point on the first body, world coordinates \[m\].
    #[doc(hidden)]
    pub point_first: Vec3,
    /// Nearest (or deepest) point on the second body, world coordinates \[m\].
    #[doc(hidden)]
    pub point_second: Vec3,
    /// Unit normal from the second body toward the first, world coordinates: moving the first body
    /// along it by `t` changes `distance` by `t`.
    #[doc(hidden)]
    pub normal: Vec3,
}

impl Contact {
    /// Returns the nearest (or deepest) points \[m\] of the first and of the second body, in the
    /// world.
    pub fn points(&self) -> [[f64; 3]; 2] {
        [self.point_first, self.point_second].map(Into::into)
    }

    /// Returns the unit normal from the second body toward the first, in the world: moving the
    /// first along it by `t` changes `distance` by `t`.
    pub fn normal(&self) -> [f64; 3] {
        self.normal.into()
    }

    /// Adds the gradient of the distance over the tangent coordinates to `gradient` (length `nv`)
    /// \[m per rad or m\]. It is of first order: the two points stay fixed to their bodies.
    /// `twists` are those of the configuration.
    #[doc(hidden)]
    pub fn add_gradient(&self, scene: &Scene, twists: &Twists, gradient: &mut [f64]) {
        let pair = &scene.pairs[self.pair.index()];
        let (mut first, mut second) = (scene.bodies[pair.first].frame, scene.bodies[pair.second].frame);
        let of_first = Wrench::at(&self.point_first, self.normal);
        let of_second = Wrench::at(&self.point_second, -self.normal);
        // Joints that carry both bodies do not part them. Frames have higher indices than the
        // frames that carry them.
        while first != second {
            let (frame, wrench) = if first > second { (&mut first, &of_first) } else { (&mut second, &of_second) };
            twists.of(*frame).iter().for_each(|twist| gradient[twist.v] += twist.power(wrench));
            *frame = scene.frames[*frame].parent;
        }
    }
}

/// Describes which contacts are requested, and how exact.
#[derive(Debug, Clone, Copy)]
pub struct ContactQuery {
    /// Contacts are requested of pairs nearer than this \[m\].
    pub margin: f64,
    /// How exact the contacts have to be.
    pub search: ContactSearch,
}

/// How exact contacts have to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSearch {
    /// Exact enough to propose a step. Contacts of convex shapes that are far apart may be those of
    /// the last search, moved along. Depths may be up to twice too large. Distances of more than
    /// twice the clearance may be up to a third too small (far ones of meshes by more). Meshes are
    /// replaced by convex pieces around them, which stand out by a few thousandths of their size.
    /// Deep overlaps are then seen whole, and a configuration is free if no contact is below the
    /// clearance.
    Proposal,
    /// Exact within rounding, but meshes are replaced by convex pieces as in a proposal.
    Pieces,
    /// The nearest contact, and the depth of convex shapes, within rounding.
    Exact,
}

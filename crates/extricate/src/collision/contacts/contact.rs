//! A contact of two bodies, and how exactly contacts are asked for. No search.

use serde::Serialize;

use crate::kinematics::{Twists, Wrench};
use crate::math::Vec3;
use crate::scene::{PairId, Scene};

/// Two places of a checked pair that are near each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Contact {
    /// Index into [`Scene::pairs`].
    pub pair: PairId,
    /// Signed distance \[m\]; negative where the two overlap. As
    /// [`crate::collision::Checker::contacts`] gives it, less what the pair keeps beyond the
    /// clearance of the scene.
    pub distance: f64,
    /// Nearest (or deepest) point on the first body, world coordinates \[m\].
    #[doc(hidden)]
    pub point_first: Vec3,
    /// The same on the second body.
    #[doc(hidden)]
    pub point_second: Vec3,
    /// Unit, world coordinates, from the second body toward the first: moving the first body along
    /// it by `t` changes `distance` by `t`.
    #[doc(hidden)]
    pub normal: Vec3,
}

impl Contact {
    /// The nearest (or deepest) points \[m\] of the first and of the second body, in the world.
    pub fn points(&self) -> [[f64; 3]; 2] {
        [self.point_first, self.point_second].map(Into::into)
    }

    /// The unit normal from the second body toward the first, in the world: moving the first along
    /// it by `t` changes `distance` by `t`.
    pub fn normal(&self) -> [f64; 3] {
        self.normal.into()
    }

    /// Adds the gradient of the distance over the tangent coordinates to `gradient` (length `nv`)
    /// \[m per rad or m\], to first order: the two points stay fixed to their bodies. `twists` are
    /// those of the configuration.
    #[doc(hidden)]
    pub fn add_gradient(&self, scene: &Scene, twists: &Twists, gradient: &mut [f64]) {
        let pair = &scene.pairs[self.pair.index()];
        let (mut first, mut second) = (scene.bodies[pair.first].frame, scene.bodies[pair.second].frame);
        let of_first = Wrench::at(&self.point_first, self.normal);
        let of_second = Wrench::at(&self.point_second, -self.normal);
        // What carries both bodies parts nothing; frames come after those that carry them.
        while first != second {
            let (frame, wrench) = if first > second { (&mut first, &of_first) } else { (&mut second, &of_second) };
            twists.of(*frame).iter().for_each(|twist| gradient[twist.v] += twist.power(wrench));
            *frame = scene.frames[*frame].parent;
        }
    }
}

/// Which contacts are wanted.
#[derive(Debug, Clone, Copy)]
pub struct ContactQuery {
    /// Of pairs nearer than this \[m\].
    pub margin: f64,
    /// How exact they have to be.
    pub search: ContactSearch,
}

/// How exact contacts have to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSearch {
    /// Enough to propose a step. Far contacts of convex shapes may be those of the search before,
    /// moved along; depths may be up to twice too large, and distances of more than twice the
    /// clearance up to a third too small (of meshes, far ones by more). Meshes are taken for convex
    /// pieces around them, which stand out by a few thousandths of their size: deep overlaps are
    /// seen whole, and where no contact is below the clearance the configuration is free.
    Proposal,
    /// The nearest contact, and the depth of convex shapes, within rounding.
    Exact,
}

//! Two convex sets of a checked pair, and their reach along a direction.

use crate::collision::shapes::convex::ConvexShape;
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Two convex shapes of a checked pair, each at its pose.
pub struct ConvexPair<'a> {
    pair: PairId,
    /// Least distance of the cores of a free pair: its clearance and the radii around them \[m\].
    keeps: f64,
    /// Identifier of the two sets, if they are the same at every configuration.
    parts: Option<[usize; 2]>,
    first: (&'a ConvexShape, &'a Pose),
    second: (&'a ConvexShape, &'a Pose),
}

impl<'a> ConvexPair<'a> {
    pub(crate) fn new(
        (pair, clearance): (PairId, f64),
        first: (&'a ConvexShape, &'a Pose),
        second: (&'a ConvexShape, &'a Pose),
    ) -> Self {
        Self { pair, keeps: clearance + first.0.radius + second.0.radius, parts: None, first, second }
    }

    /// Sets the identifier of two sets that are the same at every configuration.
    pub(crate) fn of_parts(self, parts: [usize; 2]) -> Self {
        Self { parts: Some(parts), ..self }
    }

    /// Index into [`crate::scene::Scene::pairs`].
    pub fn pair(&self) -> PairId {
        self.pair
    }

    /// Identifier of the two sets, if they are the same at every configuration.
    pub fn parts(&self) -> Option<[usize; 2]> {
        self.parts
    }

    /// Least distance \[m\] of the two cores if the pair is free: its clearance and the radii
    /// around the cores.
    pub fn keeps(&self) -> f64 {
        self.keeps
    }

    /// Support points of the two cores in the world: of the first against `direction`, of the
    /// second along it.
    pub fn supports(&self, direction: &Vec3) -> [Vec3; 2] {
        let farthest = |(shape, pose): (&ConvexShape, &Pose), along: Vec3| {
            pose.point(&shape.core.support(&pose.inverse_vector(&along)))
        };
        [farthest(self.first, -direction), farthest(self.second, *direction)]
    }
}

//! Two convex sets of a checked pair, and how far they reach along a direction.

use crate::collision::shapes::convex::ConvexShape;
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Two convex shapes of a checked pair, in place.
pub struct ConvexPair<'a> {
    pair: PairId,
    /// What its cores keep: its clearance and the radii around them \[m\].
    keeps: f64,
    /// Its parts, where it stands for them alone at every configuration.
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

    /// The same of two sets that `parts` tell from others at every configuration.
    pub(crate) fn of_parts(self, parts: [usize; 2]) -> Self {
        Self { parts: Some(parts), ..self }
    }

    /// Index into [`crate::scene::Scene::pairs`].
    pub fn pair(&self) -> PairId {
        self.pair
    }

    /// Tells it from others, where it is the same two sets at every configuration.
    pub fn parts(&self) -> Option<[usize; 2]> {
        self.parts
    }

    /// How far the cores of a free pair are apart at least: its clearance and the radii around them
    /// \[m\].
    pub fn keeps(&self) -> f64 {
        self.keeps
    }

    /// The points (world) of the first core that reaches farthest against `direction` and of the
    /// second that reaches farthest along it.
    pub fn supports(&self, direction: &Vec3) -> [Vec3; 2] {
        let farthest = |(shape, pose): (&ConvexShape, &Pose), along: Vec3| {
            pose.point(&shape.core.support(&pose.inverse_vector(&along)))
        };
        [farthest(self.first, -direction), farthest(self.second, *direction)]
    }
}

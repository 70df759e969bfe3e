//! A search for the separation of two shapes that starts where the last one for the same pair
//! ended.

use super::gjk::{EarlyEnd, Simplex, descend_from};
use super::minkowski::{Difference, Vertex};
use super::separation::{Separation, Slack, separation_of};
use crate::collision::shapes::convex::ConvexShape;
use crate::math::{Pose, Vec3};

/// Points that span the nearest features of two shapes, each in the frame of its shape.
///
/// Between two steps of a descent the nearest features seldom change; one support point then proves
/// that they are the same. Overlapping shapes start anew.
///
/// # Source
/// S. Cameron, "Enhancing GJK: computing minimum and penetration distances between convex
/// polyhedra", ICRA 1997, doi:10.1109/ROBOT.1997.606761 (start from the last simplex). Deviation:
/// support points are not tracked along edges, because looking one up takes nearly constant time
/// anyway.
#[derive(Debug, Clone, Copy, Default)]
pub struct LastFeatures {
    points: [[Vec3; 2]; 3],
    count: usize,
}

impl LastFeatures {
    /// Makes features of one pair of points.
    #[cfg(test)]
    pub fn of_point() -> Self {
        Self { count: 1, ..Self::default() }
    }

    /// Returns the number of pairs of points; 0 if nothing is known.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.count
    }

    fn simplex(&self, difference: &Difference) -> Option<Simplex> {
        let vertex =
            |[first, second]: &[Vec3; 2]| Vertex { point: first - difference.second_in_first(second), first: *first };
        let mut simplex = Simplex::new(vertex(self.points[..self.count].first()?));
        self.points[1..self.count].iter().for_each(|points| simplex.push(vertex(points)));
        Some(simplex)
    }

    fn keep(&mut self, difference: &Difference, simplex: &Simplex) {
        self.count = if simplex.count < 4 { simplex.count } else { 0 };
        for (points, vertex) in self.points.iter_mut().zip(&simplex.vertices[..self.count]) {
            *points = [vertex.first, difference.first_in_second(&(vertex.first - vertex.point))];
        }
    }
}

/// Computes [`super::separation()`] as exactly as `slack` requires. It starts from the features of
/// the last call for the same two shapes, and replaces them.
pub fn separation_near(
    last: &mut LastFeatures,
    first: &ConvexShape,
    pose_first: &Pose,
    second: &ConvexShape,
    pose_second: &Pose,
    cutoff: f64,
    slack: Slack,
) -> Option<Separation> {
    let difference = Difference::new(first, pose_first, second, pose_second);
    let mut simplex = last.simplex(&difference).unwrap_or_else(|| {
        let center = difference.center();
        let direction = if center == Vec3::zeros() { Vec3::x() } else { center };
        Simplex::new(difference.support(&-direction))
    });
    let radii = first.radius + second.radius;
    let apart_above = cutoff + radii + difference.rounding;
    let early = EarlyEnd { share: slack.gap, from: radii, above: slack.beyond + radii };
    let outcome = descend_from(&difference, &mut simplex, &mut Vec3::zeros(), apart_above, f64::NEG_INFINITY, early);
    last.keep(&difference, &simplex);
    separation_of(outcome, &difference, &mut Vec3::zeros(), [first.radius, second.radius], pose_first, cutoff, slack)
}

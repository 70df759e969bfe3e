//! The contact of two convex shapes, and the memory that saves work in the next search for the same
//! pair.

use super::contact::{ContactQuery, ContactSearch};
use crate::collision::convex_distance::{self, LastFeatures, Separation, Slack};
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::Relative;
use crate::math::{Mat3, Pose, Vec3};

/// Result of the last search for a contact of two convex shapes.
#[derive(Debug, Clone, Copy)]
pub struct ContactMemory {
    /// Features from which the next search starts.
    pub last: LastFeatures,
    pose_a_b: Pose,
    /// Proved lower bound on the signed distance at `pose_a_b` \[m\].
    lower: f64,
    /// The contact in the frame of the first shape, if the last search found one.
    contact: Option<Separation>,
}

impl Default for ContactMemory {
    fn default() -> Self {
        let (last, pose_a_b) = (LastFeatures::default(), Pose::identity());
        Self { last, pose_a_b, lower: f64::NEG_INFINITY, contact: None }
    }
}

/// A coarse search moves the last contact along while at least this share of its distance is proved
/// to remain. Its plane then still has the shapes on its two sides, and the step that it constrains
/// is evaluated anew at its end.
const MIN_REMAINING_SHARE: f64 = 0.5;

/// Slack of a coarse search, whose steps are evaluated anew at their end. A depth may be too large
/// by the share `depth` of itself: with 0.05, queries take a fifth more instructions and find the
/// same. A distance of more than twice the clearance may be too small by the share `gap`. Lab L044.
pub const COARSE_SLACK: Slack = Slack { depth: 0.5, gap: 0.3, beyond: f64::INFINITY };

impl ContactMemory {
    /// Returns the contact of two convex shapes in the frame of the first, if nearer than the
    /// margin.
    ///
    /// It is exact within rounding, except in a coarse search. That moves the last contact along
    /// (see [`MIN_REMAINING_SHARE`]) while a distance of more than twice `clearance` is proved, and
    /// else searches with [`COARSE_SLACK`].
    ///
    /// `ball_second` holds the second shape, in its own frame. `least` returns a lower bound on the
    /// signed distance \[m\]; it is called only if needed.
    pub fn contact(
        &mut self,
        [x, y]: [&ConvexSolid; 2],
        ball_second: (Vec3, f64),
        relative: &Relative,
        query: ContactQuery,
        clearance: f64,
        least: impl FnOnce() -> f64,
    ) -> Option<Separation> {
        let bound = self.lower - displacement(&self.pose_a_b, &relative.pose_a_b, ball_second);
        if bound >= query.margin {
            return None;
        }
        if let Some(contact) = self.contact
            && query.search == ContactSearch::Proposal
            && bound > (MIN_REMAINING_SHARE * self.lower).max(2.0 * clearance)
        {
            let point_second = relative.pose_a_b.point(&self.pose_a_b.inverse_point(&contact.point_second));
            let distance = contact.normal.dot(&(contact.point_first - point_second)).max(bound);
            return Some(Separation { distance, point_second, ..contact }).filter(|c| c.distance < query.margin);
        }
        self.pose_a_b = relative.pose_a_b;
        self.lower = least();
        self.contact = None;
        if self.lower >= query.margin {
            return None;
        }
        let slack = match query.search {
            ContactSearch::Exact | ContactSearch::Pieces => Slack::NONE,
            ContactSearch::Proposal => Slack { beyond: 2.0 * clearance, ..COARSE_SLACK },
        };
        let (first, pose_first, pose_second) = (&x.shape, &Pose::identity(), &relative.pose_a_b);
        let found = convex_distance::separation_near(
            &mut self.last,
            first,
            pose_first,
            &y.shape,
            pose_second,
            query.margin,
            slack,
        );
        self.lower = found.map_or(query.margin, |found| found.distance);
        self.contact = found.filter(|found| found.distance < query.margin);
        self.contact
    }
}

/// Returns an upper bound \[m\] on how far a point of a ball, fixed to the second frame, moves in
/// the first between two poses.
fn displacement(from: &Pose, to: &Pose, (center, radius): (Vec3, f64)) -> f64 {
    let turned: Mat3 = to.rotation - from.rotation;
    // The difference of two rotations stretches every vector across its axis by its Frobenius norm
    // over the root of 2.
    let stretch = turned.norm() * std::f64::consts::FRAC_1_SQRT_2;
    (turned * center + (to.translation - from.translation)).norm() + radius * stretch * (1.0 + 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::convex_distance::separation;
    use crate::collision::shapes::test_mesh::bumpy;
    use crate::collision::shapes::{Shape, ShapeKind};
    use crate::robot::Geometry;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    fn shapes() -> Vec<Shape> {
        let hull = |seed| Geometry::ConvexHull(Arc::new(bumpy(seed, 2, 0.3)));
        let all = [
            hull(1),
            hull(2),
            Geometry::Box { half_extents: [0.2, 0.3, 0.4] },
            Geometry::Cylinder { radius: 0.3, half_length: 0.2 },
            Geometry::Capsule { radius: 0.2, half_length: 0.3 },
            Geometry::Sphere { radius: 0.3 },
        ];
        all.iter().map(|geometry| Shape::new(geometry).unwrap()).collect()
    }

    fn solid(shape: &Shape) -> &ConvexSolid {
        let ShapeKind::Convex(solid) = &shape.kind else { panic!("convex") };
        solid
    }

    /// Moves two shapes in small steps nearer, into and past each other, and compares with searches
    /// that start anew.
    #[test]
    fn memory_changes_no_exact_contact_and_carries_only_far_ones() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        let shapes = shapes();
        let (mut overlapping, mut carried) = (0, 0);
        for run in 0..72 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let (a, b) = (&shapes[run % 6], &shapes[run / 6 % 6]);
            let (mut x, mut r) = (vector(6.0), vector(3.0));
            let steps: [Vec3; 2] = [-x / 60.0 + vector(0.02), vector(0.05)];
            let (mut exact, mut coarse) = (ContactMemory::default(), ContactMemory::default());
            let clearance = 1e-4;
            for _ in 0..120 {
                (x, r) = (x + steps[0], r + steps[1]);
                let relative = Relative::new(Pose::from_xyz_rpy(x.into(), r.into()));
                let pose = &relative.pose_a_b;
                let (p, q) = (solid(a), solid(b));
                let cold = separation(&p.shape, &Pose::identity(), &q.shape, pose, 0.3).filter(|c| c.distance < 0.3);
                let query = |search| ContactQuery { margin: 0.3, search };
                let least = || relative.lower_bound(&a.bounds, &b.bounds);
                let warm = exact.contact([p, q], b.ball, &relative, query(ContactSearch::Exact), clearance, least);
                let near = coarse.contact([p, q], b.ball, &relative, query(ContactSearch::Proposal), clearance, least);
                assert_eq!(cold.is_some(), warm.is_some(), "{cold:?} {warm:?}");
                let Some((cold, warm)) = cold.zip(warm) else { continue };
                assert!((cold.distance - warm.distance).abs() < 1e-7, "{cold:?} {warm:?}");
                overlapping += usize::from(cold.distance < 0.0);
                let Some(near) = near else {
                    // The moved points may be beyond the margin before the shapes are.
                    assert!(cold.distance > 0.1, "{cold:?}");
                    continue;
                };
                if cold.distance < 0.0 {
                    assert!(near.distance < cold.distance + 1e-7, "{cold:?} {near:?}");
                    assert!(near.distance * (1.0 - COARSE_SLACK.depth) > cold.distance - 1e-7, "{cold:?} {near:?}");
                } else if (near.distance - cold.distance).abs() > 1e-7 {
                    carried += 1;
                    assert!(cold.distance > 2.0 * clearance && near.distance > 2.0 * clearance, "{cold:?} {near:?}");
                }
            }
        }
        assert!(overlapping > 200 && carried > 200, "{overlapping} {carried}");
    }

    #[test]
    fn displacement_bounds_every_point_of_the_ball() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        for _ in 0..500 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let from = Pose::from_xyz_rpy(vector(2.0).into(), vector(6.0).into());
            let to = Pose::from_xyz_rpy(vector(2.0).into(), vector(6.0).into());
            let center = vector(1.0);
            let bound = displacement(&from, &to, (center, 0.3));
            for _ in 0..20 {
                let p = center + vector(1.0).normalize() * 0.3;
                assert!((from.point(&p) - to.point(&p)).norm() <= bound + 1e-12);
            }
        }
    }
}

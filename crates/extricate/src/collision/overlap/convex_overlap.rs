//! Overlapping convex shapes with proved penetration depths.

use crate::collision::narrow_phase;
use crate::collision::prepared::Placed;
use crate::collision::scenery::{Stands, stand_ins};
use crate::collision::shapes::ShapeKind;
use crate::collision::{CheckScratch, Checker};
use crate::math::Vec3;
use crate::scene::PairId;

/// Two overlapping convex shapes of a checked pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexOverlap {
    /// Index into [`crate::scene::Scene::pairs`].
    pub pair: PairId,
    /// Proved depth \[m\]: no shorter translation separates them.
    pub depth: f64,
    /// Corners of boxes around the shapes of the first and the second body, in world coordinates
    /// \[m\].
    pub corners: [[Vec3; 8]; 2],
}

/// See [`Checker::convex_overlaps`].
pub fn convex_overlaps(
    checker: &Checker,
    q: &[f64],
    pairs: &[PairId],
    scratch: &mut CheckScratch,
    overlaps: &mut Vec<ConvexOverlap>,
) {
    checker.place(q, scratch);
    for &pair in pairs {
        for (first, second, _) in checker.part_pairs(pair.index()) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            add_overlaps(pair, [a, b], &mut scratch.buffers.places, overlaps);
        }
    }
}

fn add_overlaps(pair: PairId, [a, b]: [Placed; 2], stack: &mut Vec<(f64, u32)>, overlaps: &mut Vec<ConvexOverlap>) {
    use ShapeKind::{Convex, Scenery};
    let corners = |placed: Placed| placed.shape().bounds.corners().map(|p| placed.pose.point(&p));
    match (&a.shape().kind, &b.shape().kind) {
        (Convex(x), Convex(y)) => {
            let Some(depth) = narrow_phase::convex_depth((x, a.pose), (y, b.pose)) else { return };
            overlaps.push(ConvexOverlap { pair, depth, corners: [corners(a), corners(b)] });
        }
        (Scenery(_), Convex(_)) | (Convex(_), Scenery(_)) => {
            let is_first = matches!(a.shape().kind, Scenery(_));
            let (all, one) = if is_first { (a, b) } else { (b, a) };
            let (Scenery(scenery), Convex(solid)) = (&all.shape().kind, &one.shape().kind) else { return };
            stand_ins(scenery, all.pose, one, Stands::Inside, stack, &mut |part, bounds, pose| {
                let Some(depth) = narrow_phase::convex_depth((part, pose), (solid, one.pose)) else { return };
                let both = [bounds.corners().map(|p| pose.point(&p)), corners(one)];
                let corners = if is_first { both } else { [both[1], both[0]] };
                overlaps.push(ConvexOverlap { pair, depth, corners });
            });
        }
        _ => {}
    }
}

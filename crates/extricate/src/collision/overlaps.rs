//! Overlaps of convex shapes with proved depths: what lower bounds on the way out stand on.

use super::part_pair::{self, Placed};
use super::scenery::{Stands, stand_ins};
use super::shape::ShapeKind;
use super::{CheckScratch, Checker};
use crate::math::Vec3;

/// Two overlapping convex shapes of a checked pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexOverlap {
    /// Index into [`crate::scene::Scene::pairs`].
    pub pair: usize,
    /// Proved: no translation shorter than this parts them \[m\].
    pub depth: f64,
    /// World coordinates of the corners of a box around the shape of the first and of the second
    /// body \[m\].
    pub corners: [[Vec3; 8]; 2],
}

impl Checker {
    /// Appends the overlapping convex shapes among the checked pairs `pairs` at `q`. Convex shapes
    /// inside scenery stand for it: what parts the scenery from another shape parts them from it
    /// too.
    pub fn convex_overlaps(
        &self,
        q: &[f64],
        pairs: &[usize],
        scratch: &mut CheckScratch,
        overlaps: &mut Vec<ConvexOverlap>,
    ) {
        self.place(q, scratch);
        for &pair in pairs {
            for (first, second, _) in self.part_pairs(pair) {
                let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
                add_overlaps(pair, [a, b], &mut scratch.buffers.places, overlaps);
            }
        }
    }
}

fn add_overlaps(pair: usize, [a, b]: [Placed; 2], stack: &mut Vec<(f64, u32)>, overlaps: &mut Vec<ConvexOverlap>) {
    use ShapeKind::{Convex, Scenery};
    let corners = |placed: Placed| placed.shape.bounds.corners().map(|p| placed.pose.point(&p));
    match (&a.shape.kind, &b.shape.kind) {
        (Convex(x), Convex(y)) => {
            let Some(depth) = part_pair::convex_depth((x, a.pose), (y, b.pose)) else { return };
            overlaps.push(ConvexOverlap { pair, depth, corners: [corners(a), corners(b)] });
        }
        (Scenery(_), Convex(_)) | (Convex(_), Scenery(_)) => {
            let is_first = matches!(a.shape.kind, Scenery(_));
            let (all, one) = if is_first { (a, b) } else { (b, a) };
            let (Scenery(scenery), Convex(solid)) = (&all.shape.kind, &one.shape.kind) else { return };
            stand_ins(scenery, all.pose, one, Stands::Inside, stack, &mut |part, bounds, pose| {
                let Some(depth) = part_pair::convex_depth((part, pose), (solid, one.pose)) else { return };
                let both = [bounds.corners().map(|p| pose.point(&p)), corners(one)];
                let corners = if is_first { both } else { [both[1], both[0]] };
                overlaps.push(ConvexOverlap { pair, depth, corners });
            });
        }
        _ => {}
    }
}

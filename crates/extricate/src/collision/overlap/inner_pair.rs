//! Convex sets inside the bodies of a pair. Proofs that the bodies overlap are based on them.

use super::convex_pair::ConvexPair;
use super::inner_pieces::InnerPiece;
use crate::collision::prepared::Placed;
use crate::collision::scenery::{Stands, stand_ins};
use crate::collision::shapes::ShapeKind;
use crate::collision::shapes::convex::ConvexShape;
use crate::collision::{CheckScratch, Checker};
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Pairs of pieces that are used for each pair of parts: those that overlap most.
const MAX_PIECE_PAIRS: usize = 4;
/// Pieces of a part that are used at most; a part and a piece make one number in this base.
const MAX_PIECES: usize = 64;

/// See [`Checker::inner_pairs`].
pub fn inner_pairs(
    checker: &Checker,
    q: &[f64],
    pairs: &[PairId],
    scratch: &mut CheckScratch,
    each: &mut dyn FnMut(&ConvexPair),
) {
    checker.place(q, scratch);
    for &pair in pairs {
        let of = (pair, checker.clearance_of(pair.index()));
        for (first, second, _) in checker.part_pairs(pair.index()) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            of_parts(of, [first, second], [a, b], &mut scratch.buffers.places, each);
        }
    }
}

fn of_parts(
    of: (PairId, f64),
    parts: [usize; 2],
    [a, b]: [Placed; 2],
    stack: &mut Vec<(f64, u32)>,
    each: &mut dyn FnMut(&ConvexPair),
) {
    use ShapeKind::{Convex, Mesh, Scenery};
    let (is_mesh, is_scenery) =
        ([a, b].map(|p| matches!(p.shape().kind, Mesh(_))), |p: Placed| matches!(p.shape().kind, Scenery(_)));
    if let (Convex(x), Convex(y)) = (&a.shape().kind, &b.shape().kind) {
        let parts = parts.map(|part| part * MAX_PIECES);
        each(&ConvexPair::new(of, (&x.shape, a.pose), (&y.shape, b.pose)).of_parts(parts));
    } else if is_scenery(a) || is_scenery(b) {
        let (all, one) = if is_scenery(a) { (a, b) } else { (b, a) };
        let (Scenery(scenery), Convex(solid)) = (&all.shape().kind, &one.shape().kind) else { return };
        stand_ins(scenery, all.pose, one, Stands::Inside, stack, &mut |part, _, pose| {
            let (of_all, of_one) = ((&part.shape, pose), (&solid.shape, one.pose));
            let (first, second) = if is_scenery(a) { (of_all, of_one) } else { (of_one, of_all) };
            each(&ConvexPair::new(of, first, second));
        });
    } else if is_mesh[0] || is_mesh[1] {
        for [i, j] in deepest(a, b).into_iter().flatten() {
            let parts = [parts[0] * MAX_PIECES + i, parts[1] * MAX_PIECES + j];
            each(&ConvexPair::new(of, (set(a, i), a.pose), (set(b, j), b.pose)).of_parts(parts));
        }
    }
}

/// Convex part, or one piece of a mesh.
fn set(of: Placed<'_>, number: usize) -> &ConvexShape {
    match &of.shape().kind {
        ShapeKind::Convex(solid) => &solid.shape,
        _ => &of.prepared.inner_pieces()[number].shape,
    }
}

/// Returns the numbers of the pairs of sets that overlap most.
fn deepest(a: Placed, b: Placed) -> [Option<[usize; 2]>; MAX_PIECE_PAIRS] {
    let (mut found, mut depths) = ([None; MAX_PIECE_PAIRS], [f64::NEG_INFINITY; MAX_PIECE_PAIRS]);
    let pose_b_a = b.pose.inverse().then(a.pose);
    for i in 0..count(a) {
        for j in 0..count(b) {
            let Some(mut depth) = depth((a, i), (b, j), &pose_b_a) else { continue };
            let mut new = Some([i, j]);
            for (slot, known) in found.iter_mut().zip(&mut depths) {
                if depth > *known {
                    std::mem::swap(known, &mut depth);
                    std::mem::swap(slot, &mut new);
                }
            }
        }
    }
    found
}

fn count(of: Placed) -> usize {
    if matches!(of.shape().kind, ShapeKind::Convex(_)) { 1 } else { of.prepared.inner_pieces().len().min(MAX_PIECES) }
}

/// Estimate of how deep two sets overlap \[m\]; `None` if they are proved apart.
fn depth((a, i): (Placed, usize), (b, j): (Placed, usize), pose_b_a: &Pose) -> Option<f64> {
    let apart = |x: &Vec3, y: &Vec3, reach: f64| (x - y).norm() > reach;
    match (&a.shape().kind, &b.shape().kind) {
        (ShapeKind::Convex(solid), _) => {
            let InnerPiece { ball: (center, radius), reach, .. } = b.prepared.inner_pieces().get(j)?;
            let center = pose_b_a.inverse_point(center);
            let is_apart = apart(&center, &a.shape().ball.0, reach + a.shape().ball.1);
            (!is_apart).then(|| solid.depth(&center) + *radius)
        }
        (_, ShapeKind::Convex(solid)) => {
            let InnerPiece { ball: (center, radius), reach, .. } = a.prepared.inner_pieces().get(i)?;
            let center = pose_b_a.point(center);
            let is_apart = apart(&center, &b.shape().ball.0, reach + b.shape().ball.1);
            (!is_apart).then(|| solid.depth(&center) + *radius)
        }
        _ => {
            let (x, y) = (a.prepared.inner_pieces().get(i)?, b.prepared.inner_pieces().get(j)?);
            let gap = (pose_b_a.point(&x.ball.0) - y.ball.0).norm();
            (gap <= x.reach + y.reach).then_some(x.ball.1 + y.ball.1 - gap)
        }
    }
}

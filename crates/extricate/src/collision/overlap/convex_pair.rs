//! Two convex shapes of a checked pair, and how far they overlap along a direction.

use crate::collision::prepared::Placed;
use crate::collision::scenery::{Stands, stand_ins};
use crate::collision::shapes::convex::ConvexShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::collision::{CheckScratch, Checker, Contact};
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Two convex shapes of a checked pair, in place.
pub struct ConvexPair<'a> {
    pair: PairId,
    /// What the pair keeps beyond the clearance of the scene \[m\].
    excess: f64,
    /// What its cores keep: its clearance and the radii around them \[m\].
    keeps: f64,
    /// Its parts, where it stands for them alone at every configuration.
    parts: Option<[usize; 2]>,
    first: (&'a ConvexShape, &'a Pose),
    second: (&'a ConvexShape, &'a Pose),
}

/// Convex pieces of two bodies that are looked at, those whose enclosing balls overlap most.
const MOST_PIECES: usize = 4;

impl<'a> ConvexPair<'a> {
    pub(crate) fn new(
        (pair, clearance, excess): (PairId, f64, f64),
        first: (&'a ConvexShape, &'a Pose),
        second: (&'a ConvexShape, &'a Pose),
    ) -> Self {
        Self { pair, excess, keeps: clearance + first.0.radius + second.0.radius, parts: None, first, second }
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

    /// The axes of either shape's frame, both ways (unit, world): what the faces of boxes and the
    /// ends of cylinders look along.
    pub fn axes(&self) -> impl Iterator<Item = Vec3> {
        let rotations = [self.first.1.rotation, self.second.1.rotation];
        let signed = (0..12).map(|k| (k / 6, k % 3, if k % 6 < 3 { 1.0 } else { -1.0 }));
        signed.map(move |(shape, axis, sign)| rotations[shape].column(axis) * sign)
    }

    /// The place where the first shape reaches farthest against `direction` (unit, world) and the
    /// second farthest along it: by the negative of its distance they overlap along the direction.
    /// The distance is less what the pair keeps beyond the clearance of the scene.
    pub fn across(&self, direction: &Vec3) -> Contact {
        let farthest = |(shape, pose): (&ConvexShape, &Pose), along: Vec3| {
            pose.point(&shape.core.support(&pose.inverse_vector(&along))) + along * shape.radius
        };
        let (point_first, point_second) = (farthest(self.first, -direction), farthest(self.second, *direction));
        let distance = direction.dot(&(point_first - point_second)) - self.excess;
        Contact { pair: self.pair, distance, point_first, point_second, normal: *direction }
    }
}

/// See [`Checker::convex_pairs`].
pub fn convex_pairs(
    checker: &Checker,
    q: &[f64],
    pairs: &[PairId],
    scratch: &mut CheckScratch,
    each: &mut dyn FnMut(&ConvexPair),
) {
    checker.place(q, scratch);
    for &pair in pairs {
        let (clearance, excess) = (checker.clearance_of(pair.index()), checker.excess(pair.index()));
        for (first, second, _) in checker.part_pairs(pair.index()) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            if let (ShapeKind::Scenery(_), _) | (_, ShapeKind::Scenery(_)) = (&a.shape().kind, &b.shape().kind) {
                with_scenery((pair, clearance, excess), [a, b], &mut scratch.buffers.places, each);
                continue;
            }
            for (x, y) in deepest_pieces(a, b, clearance).into_iter().flatten() {
                each(&ConvexPair::new((pair, clearance, excess), (convex(x), a.pose), (convex(y), b.pose)));
            }
        }
    }
}

/// As [`Checker::convex_pairs`], of scenery and another shape, of which the piece whose ball
/// overlaps that of the stand-in most is taken.
fn with_scenery(
    of: (PairId, f64, f64),
    [a, b]: [Placed; 2],
    stack: &mut Vec<(f64, u32)>,
    each: &mut dyn FnMut(&ConvexPair),
) {
    let is_first = matches!(a.shape().kind, ShapeKind::Scenery(_));
    let (all, one) = if is_first { (a, b) } else { (b, a) };
    let ShapeKind::Scenery(scenery) = &all.shape().kind else { return };
    stand_ins(scenery, all.pose, one, Stands::Near, stack, &mut |part, _, pose| {
        let gap = |piece: &&Shape| (one.pose.point(&piece.ball.0) - pose.translation).norm() - piece.ball.1;
        let pieces = one.prepared.pieces().shapes.iter();
        let Some(nearest) = pieces.min_by(|x, y| gap(x).total_cmp(&gap(y))) else { return };
        let (of_all, of_one) = ((&part.shape, pose), (convex(nearest), one.pose));
        let (first, second) = if is_first { (of_all, of_one) } else { (of_one, of_all) };
        each(&ConvexPair::new(of, first, second));
    });
}

/// The pieces of two shapes whose enclosing balls overlap most, or are nearer than `within` \[m\].
fn deepest_pieces<'a>(a: Placed<'a>, b: Placed<'a>, within: f64) -> [Option<(&'a Shape, &'a Shape)>; MOST_PIECES] {
    let (mut found, mut gaps) = ([None; MOST_PIECES], [within; MOST_PIECES]);
    let pose_b_a = b.pose.inverse().then(a.pose);
    for x in a.prepared.pieces().shapes {
        let center = pose_b_a.point(&x.ball.0);
        for y in b.prepared.pieces().shapes {
            let (mut gap, mut new) = ((center - y.ball.0).norm() - x.ball.1 - y.ball.1, Some((x, y)));
            for (slot, known) in found.iter_mut().zip(&mut gaps) {
                if gap < *known {
                    std::mem::swap(known, &mut gap);
                    std::mem::swap(slot, &mut new);
                }
            }
        }
    }
    found
}

fn convex(shape: &Shape) -> &ConvexShape {
    match &shape.kind {
        ShapeKind::Convex(solid) => &solid.shape,
        ShapeKind::Mesh(_) | ShapeKind::Scenery(_) => unreachable!("pieces are convex"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::math::sphere;
    use crate::scene::builtin;
    use std::sync::Arc;

    /// Along every direction two overlapping shapes overlap at least as far as the shortest
    /// translation that parts them, and along some direction hardly farther.
    #[test]
    fn overlaps_along_directions_are_as_deep_as_the_depth() {
        let scene = Arc::new(builtin::scene("planar-arm").unwrap());
        let checker = Checker::new(scene.clone());
        let (mut scratch, mut q, mut seen) = (CheckScratch::default(), vec![0.0; scene.space.nq()], 0);
        for k in 0..200 {
            Halton::new(scene.space.nv(), 3).config(&scene.space, k, &mut q);
            let mut pairs = Vec::new();
            checker.colliding_pairs(&q, &mut scratch, &mut pairs);
            for pair in pairs {
                let (mut overlaps, mut found) = (Vec::new(), Vec::new());
                checker.convex_overlaps(&q, &[pair], &mut scratch, &mut overlaps);
                checker.convex_pairs(&q, &[pair], &mut scratch, &mut |shapes| {
                    let along = sphere(2000).map(|n| -shapes.across(&n).distance);
                    found.push(along.fold(f64::INFINITY, f64::min));
                });
                let deepest = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::NEG_INFINITY, f64::max);
                let depth = deepest(&mut overlaps.iter().map(|overlap| overlap.depth));
                let least = deepest(&mut found.into_iter());
                assert!(least >= depth - 1e-12 && least < 1.3 * depth + 0.02, "{least} {depth}");
                seen += 1;
            }
        }
        assert!(seen > 50, "{seen}");
    }
}

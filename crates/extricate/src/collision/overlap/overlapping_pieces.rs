//! Overlapping convex pieces of two bodies, and how far all of them overlap along a direction.

use crate::collision::contacts::{ContactBuffers, find_candidates, solid};
use crate::collision::convex_decomposition::PiecesRef;
use crate::collision::convex_distance::nearer_than;
use crate::collision::prepared::Placed;
use crate::collision::scenery::{Many, Scenery, Stands, stand_ins};
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::convex::ConvexShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::collision::{CheckScratch, Checker, Contact};
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// The pieces of two shapes of a checked pair that overlap a piece of the other. A translation that
/// separates all of them mostly separates the shapes; one that separates a single pair mostly
/// leaves others.
pub struct OverlappingPieces<'a> {
    pair: PairId,
    /// Distance \[m\] that the pair keeps beyond the clearance of the scene.
    excess: f64,
    first: Side<'a>,
    second: Side<'a>,
}

/// Some of the pieces of a shape, at its pose.
#[derive(Clone, Copy)]
struct Side<'a> {
    pieces: Pieces<'a>,
    pose: &'a Pose,
}

#[derive(Clone, Copy)]
enum Pieces<'a> {
    Alone(&'a ConvexShape),
    Of(&'a [Shape], &'a [u32]),
    /// Shapes of scenery with their places in these boxes.
    Places(&'a Many, &'a [Aabb]),
}

impl OverlappingPieces<'_> {
    /// Axes of both frames, in both directions (unit, world). Faces of boxes and ends of cylinders
    /// have these normals.
    pub fn axes(&self) -> impl Iterator<Item = Vec3> {
        let rotations = [self.first.pose.rotation, self.second.pose.rotation];
        let signed = (0..12).map(|k| (k / 6, k % 3, if k % 6 < 3 { 1.0 } else { -1.0 }));
        signed.map(move |(shape, axis, sign)| rotations[shape].column(axis) * sign)
    }

    /// Contact along `direction` (unit, world): the first pieces' farthest point against it and the
    /// second's along it. Its negative distance is the overlap, including what the pair keeps
    /// beyond the clearance of the scene.
    pub fn across(&self, direction: &Vec3) -> Contact {
        let (point_first, point_second) = (self.first.farthest(-direction), self.second.farthest(*direction));
        let distance = direction.dot(&(point_first - point_second)) - self.excess;
        Contact { pair: self.pair, distance, point_first, point_second, normal: *direction }
    }
}

impl Side<'_> {
    /// Support point in the world along a direction (unit, world).
    fn farthest(&self, along: Vec3) -> Vec3 {
        let local = self.pose.inverse_vector(&along);
        let reaching = |shape: &ConvexShape| shape.core.support(&local) + local * shape.radius;
        let farthest = match self.pieces {
            Pieces::Alone(shape) => reaching(shape),
            Pieces::Of(all, some) => {
                let points = some.iter().map(|k| reaching(&solid(&all[*k as usize]).shape));
                let farther = |a: Vec3, b: Vec3| if b.dot(&local) > a.dot(&local) { b } else { a };
                points.reduce(farther).unwrap_or_default()
            }
            Pieces::Places(many, boxes) => many.support(boxes, &local),
        };
        self.pose.point(&farthest)
    }
}

/// See [`Checker::overlapping_pieces`].
pub fn overlapping_pieces(
    checker: &Checker,
    q: &[f64],
    pairs: &[PairId],
    scratch: &mut CheckScratch,
    each: &mut dyn FnMut(&OverlappingPieces),
) {
    checker.place(q, scratch);
    let CheckScratch { placement, buffers, contact_buffers, .. } = scratch;
    for &pair in pairs {
        let (clearance, excess) = (checker.clearance_of(pair.index()), checker.excess(pair.index()));
        for (first, second, _) in checker.part_pairs(pair.index()) {
            let (a, b) = checker.bodies.placed(placement, first, second);
            let (is_first, is_second) = (is_scenery(a), is_scenery(b));
            if !is_first && !is_second {
                let [xs, ys] = &mut buffers.pieces;
                if find_overlapping([a, b], clearance, contact_buffers, [&mut *xs, &mut *ys]) {
                    let (of_a, of_b) = (a.prepared.pieces_beside(b.prepared), b.prepared.pieces_beside(a.prepared));
                    for xs in parted_at_once(xs, of_a.first_apart) {
                        for ys in parted_at_once(ys, of_b.first_apart) {
                            let (first, second) = (Side::of(of_a, a, xs), Side::of(of_b, b, ys));
                            each(&OverlappingPieces { pair, excess, first, second });
                        }
                    }
                }
                continue;
            }
            let (all, one) = if is_first { (a, b) } else { (b, a) };
            let ShapeKind::Scenery(scenery) = &all.shape().kind else { continue };
            let [found, _] = &mut buffers.pieces;
            let mut offer = |of_all: Side, found: &[u32]| {
                let of_one = Side::of(one.prepared.cover(), one, found);
                let (first, second) = if is_first { (of_all, of_one) } else { (of_one, of_all) };
                if !found.is_empty() {
                    each(&OverlappingPieces { pair, excess, first, second });
                }
            };
            if let Scenery::Many(many) = scenery {
                find_places((many, all.pose), one, clearance, &mut buffers.boxes, found);
                offer(Side { pieces: Pieces::Places(many, &buffers.boxes), pose: all.pose }, found);
                continue;
            }
            stand_ins(scenery, all.pose, one, Stands::Near, &mut buffers.places, &mut |part, _, pose| {
                find_near((&part.shape, pose), one, clearance, found);
                offer(Side { pieces: Pieces::Alone(&part.shape), pose }, found);
            });
        }
    }
}

impl<'a> Side<'a> {
    fn of(all: PiecesRef<'a>, shape: Placed<'a>, some: &'a [u32]) -> Self {
        Self { pieces: Pieces::Of(all.shapes, some), pose: shape.pose }
    }
}

/// Groups `some` pieces: a direction has to separate all before `first_apart` at once, and each
/// other one by itself.
fn parted_at_once(some: &mut [u32], first_apart: usize) -> impl Iterator<Item = &[u32]> {
    some.sort_unstable();
    let (together, apart) = some.split_at(some.partition_point(|piece| (*piece as usize) < first_apart));
    Some(together).filter(|all| !all.is_empty()).into_iter().chain(apart.chunks(1))
}

fn is_scenery(shape: Placed) -> bool {
    matches!(shape.shape().kind, ShapeKind::Scenery(_))
}

/// Finds the pieces of either shape that are nearer than `within` \[m\] to a piece of the other.
/// Returns whether there are any. If both shapes have a single piece, these are returned unchecked.
fn find_overlapping(
    [a, b]: [Placed; 2],
    within: f64,
    contact_buffers: &mut ContactBuffers,
    [xs, ys]: [&mut Vec<u32>; 2],
) -> bool {
    xs.clear();
    ys.clear();
    let (of_a, of_b) = (a.prepared.pieces_beside(b.prepared), b.prepared.pieces_beside(a.prepared));
    if [of_a, of_b].iter().all(|pieces| pieces.shapes.len() == 1) {
        xs.push(0);
        ys.push(0);
        return true;
    }
    let relative = Relative::between(a.pose, b.pose);
    find_candidates([a.prepared, b.prepared], [of_a, of_b], &relative, within, contact_buffers);
    for &(_, i, j) in &contact_buffers.candidates {
        let (x, y) = (&solid(&of_a.shapes[i]).shape, &solid(&of_b.shapes[j]).shape);
        let is_known = [xs.contains(&(i as u32)), ys.contains(&(j as u32))];
        if is_known != [true; 2] && nearer_than(x, &Pose::identity(), y, &relative.pose_a_b, within) {
            xs.extend((!is_known[0]).then_some(i as u32));
            ys.extend((!is_known[1]).then_some(j as u32));
        }
    }
    !xs.is_empty()
}

/// Finds the places of scenery and the pieces of `one` that are nearer than `within` \[m\] to one
/// of the other.
fn find_places((many, pose): (&Many, &Pose), one: Placed, within: f64, places: &mut Vec<Aabb>, pieces: &mut Vec<u32>) {
    places.clear();
    pieces.clear();
    let relative = Relative::between(pose, one.pose);
    for (k, piece) in (0_u32..).zip(one.prepared.cover().shapes) {
        let known = places.len();
        many.places_near((piece, &solid(piece).shape), &relative, within, places);
        pieces.extend((places.len() > known).then_some(k));
    }
}

/// Finds the pieces of `one` that are nearer than `within` \[m\] to a shape. If there is none,
/// returns the piece with its ball nearest to the origin of the shape.
fn find_near((part, pose): (&ConvexShape, &Pose), one: Placed, within: f64, found: &mut Vec<u32>) {
    let (pieces, pose_part_one) = (one.prepared.cover().shapes, pose.inverse().then(one.pose));
    let is_near = |piece: &Shape| nearer_than(part, &Pose::identity(), &solid(piece).shape, &pose_part_one, within);
    found.clear();
    found.extend((0_u32..).zip(pieces).filter(|(_, piece)| is_near(piece)).map(|(k, _)| k));
    if found.is_empty() {
        let gap = |piece: &Shape| pose_part_one.point(&piece.ball.0).norm() - piece.ball.1;
        let nearest = (0_u32..).zip(pieces).min_by(|x, y| gap(x.1).total_cmp(&gap(y.1)));
        found.extend(nearest.map(|(k, _)| k));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::prepared::PreparedShape;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined, placed};
    use crate::cspace::sampling::Halton;
    use crate::math::sphere;
    use crate::robot::Geometry;
    use crate::scene::builtin;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    /// Along every direction, two shapes overlap at least by their penetration depth, and along
    /// some direction hardly more.
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
                checker.overlapping_pieces(&q, &[pair], &mut scratch, &mut |shapes| {
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

    /// For a bracket and a bumpy body, compares the overlapping pieces with a scan of all pairs. A
    /// translation by their overlap along a direction separates every pair of them.
    #[test]
    fn a_translation_along_a_direction_parts_all_pieces_that_overlap() {
        let bracket = [
            cuboid(Vec3::zeros(), Vec3::new(0.2, 0.05, 0.05)),
            cuboid(Vec3::new(0.15, 0.0, 0.2), Vec3::new(0.05, 0.05, 0.15)),
        ];
        let meshes = [joined(&bracket), placed(bumpy(3, 2, 0.3), 0.15, Vec3::zeros())];
        let [first, second] = meshes.map(|mesh| PreparedShape::new(&Geometry::Mesh(Arc::new(mesh))).unwrap());
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (mut xs, mut ys, mut several) = (Vec::new(), Vec::new(), 0);
        let mut buffers = ContactBuffers::default();
        for _ in 0..600 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let pose = Pose::from_xyz_rpy(vector(0.7).into(), vector(6.0).into());
            let at = Pose::identity();
            let (a, b) = (Placed { prepared: &first, pose: &at }, Placed { prepared: &second, pose: &pose });
            let overlap = find_overlapping([a, b], 0.0, &mut buffers, [&mut xs, &mut ys]);
            let nearer = |x: &Shape, moved: &Pose, y: &Shape, than: f64| {
                nearer_than(&solid(x).shape, moved, &solid(y).shape, &pose, than)
            };
            let (of_a, of_b) = (first.pieces_beside(&second), second.pieces_beside(&first));
            let (all, every) = (of_a.shapes, of_b.shapes);
            let of_first = |x: &Shape| every.iter().any(|y| nearer(x, &at, y, 0.0));
            let of_second = |y: &Shape| all.iter().any(|x| nearer(x, &at, y, 0.0));
            let expected: Vec<u32> = (0..).zip(all).filter(|(_, x)| of_first(x)).map(|(k, _)| k).collect();
            xs.sort_unstable();
            assert_eq!((&xs, overlap), (&expected, !expected.is_empty()));
            ys.sort_unstable();
            assert_eq!(ys, (0..).zip(every).filter(|(_, y)| of_second(y)).map(|(k, _)| k).collect::<Vec<u32>>());
            several += usize::from(xs.len() > 1);
            if !overlap {
                continue;
            }
            let (pair, excess, first, second) = (PairId::new(0), 0.0, Side::of(of_a, a, &xs), Side::of(of_b, b, &ys));
            for n in sphere(20) {
                let distance = OverlappingPieces { pair, excess, first, second }.across(&n).distance;
                let moved = Pose::translation(n * (1e-9 - distance));
                let are_near = |k: &u32| ys.iter().any(|l| nearer(&all[*k as usize], &moved, &every[*l as usize], 0.0));
                assert!(!xs.iter().any(are_near), "{n:?} {distance}");
            }
        }
        assert!(several > 30, "{several}");
    }
}

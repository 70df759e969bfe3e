//! Contacts of the convex pieces around two shapes, at least one of which is a mesh.

use pulp::{Arch, Simd, WithSimd};

use super::buffers::{Candidate, ContactBuffers, PairPlace};
use super::contact::{ContactQuery, ContactSearch};
use super::sink::{Near, Sink};
use crate::collision::convex_decomposition::PiecesRef;
use crate::collision::prepared::PreparedShape;
use crate::collision::shapes::bounds::Relative;
use crate::collision::shapes::bvh::{Boxes, Cuboid, View, below, lanes_of, rounded_up};
use crate::collision::shapes::{ConvexSolid, Shape, ShapeKind};
use crate::math::{LANES, Pose, Vec3};

/// Pairs of pieces that are looked at though they are neither the nearest nor within the clearance:
/// more of them change descents little.
const MOST_FAR: usize = 4;
/// Two pieces that a plane parts by more than this share of the margin are far: the plane is their
/// contact, and how far they are is not searched for.
pub(crate) const FAR: f64 = 0.4;

/// Pairs of pieces that overlap and are looked at: where links fold into each other hundreds do,
/// most because others do. With fewer, descents that run into bodies take more looks; with more,
/// the same ones.
const MOST_OVERLAPS: usize = 4;
/// Of so many pairs of pieces, the nearest of those not looked at yet are brought into order.
const SORTED_AT_ONCE: usize = 32;

/// Offers `sink` the contact of every two pieces nearer than the margin, nearest first; of pieces
/// that overlap those whose boxes do most.
pub fn by_pieces(
    [a, b]: [&PreparedShape; 2],
    relative: &Relative,
    query: ContactQuery,
    place: PairPlace,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    let (of_a, of_b) = (a.pieces_beside(b), b.pieces_beside(a));
    find_candidates([a, b], [of_a, of_b], relative, query.margin, buffers);
    let ContactBuffers { found, memory, candidates, .. } = buffers;
    found.clear();
    let far = (FAR * query.margin).max(2.0 * place.clearance);
    let (mut looked_at, mut overlaps, mut nearest) = (0, 0, query.margin);
    for at in 0..candidates.len() {
        sort_by_blocks(candidates, at);
        let (bound, i, j) = candidates[at];
        let limit = if looked_at < MOST_FAR { query.margin } else { nearest.max(place.clearance) };
        if bound >= limit {
            break;
        }
        let (x, y) = (&of_a.shapes[i], &of_b.shapes[j]);
        let plane = plane_between(x, y, &relative.pose_a_b);
        let bound = bound.max(plane.distance);
        if bound >= limit {
            continue;
        }
        looked_at += 1;
        let contact = if plane.distance > far {
            Some(plane)
        } else {
            let memory = memory.of_pieces(place.parts, pair_count([of_a, of_b]), i * of_b.shapes.len() + j);
            let solids = [solid(x), solid(y)];
            memory.contact(solids, y.ball, relative, query, place.clearance, || bound).map(Near::from)
        };
        nearest = contact.map_or(nearest, |contact| nearest.min(contact.distance));
        found.extend(contact);
        overlaps += usize::from(contact.is_some_and(|contact| contact.distance < 0.0));
        if overlaps == MOST_OVERLAPS {
            break;
        }
    }
    found.sort_unstable_by(|x, y| x.distance.total_cmp(&y.distance));
    for near in found.iter() {
        if !sink.offer(near) {
            break;
        }
    }
}

/// Brings the nearest of those from `at` on into order, a few at a time where `at` is the first of
/// a block: of thousands, the first few are looked at.
fn sort_by_blocks(candidates: &mut [Candidate], at: usize) {
    if !at.is_multiple_of(SORTED_AT_ONCE) {
        return;
    }
    let by_bound = |x: &Candidate, y: &Candidate| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2)));
    let rest = &mut candidates[at..];
    if rest.len() > 2 * SORTED_AT_ONCE {
        rest.select_nth_unstable_by(SORTED_AT_ONCE, by_bound);
        rest[..SORTED_AT_ONCE].sort_unstable_by(by_bound);
    } else {
        rest.sort_unstable_by(by_bound);
    }
}

/// Whether the pieces around two shapes prove, if they are known and hold all of them, that the
/// shapes are no nearer than the margin.
pub fn are_parted(
    [a, b]: [&PreparedShape; 2],
    relative: &Relative,
    margin: f64,
    place: PairPlace,
    buffers: &mut ContactBuffers,
) -> bool {
    let (Some(of_a), Some(of_b)) = (a.known_cover(), b.known_cover()) else { return false };
    // Where proposals have finer ones, they remember other pairs of pieces.
    if [(a, b), (b, a)].iter().any(|(one, other)| one.is_finer_beside(other)) {
        return false;
    }
    find_candidates([a, b], [of_a, of_b], relative, margin, buffers);
    let ContactBuffers { memory, candidates, .. } = buffers;
    let query = ContactQuery { margin, search: ContactSearch::Proposal };
    candidates.iter().all(|&(bound, i, j)| {
        let (x, y) = (&of_a.shapes[i], &of_b.shapes[j]);
        let bound = bound.max(plane_between(x, y, &relative.pose_a_b).distance);
        let memory = memory.of_pieces(place.parts, pair_count([of_a, of_b]), i * of_b.shapes.len() + j);
        bound >= margin
            || memory.contact([solid(x), solid(y)], y.ball, relative, query, place.clearance, || bound).is_none()
    })
}

fn pair_count([of_a, of_b]: [PiecesRef; 2]) -> usize {
    of_a.shapes.len() * of_b.shapes.len()
}

/// Fills `candidates` with the pairs of pieces that may be nearer than `margin` \[m\], as boxes and
/// balls tell.
pub fn find_candidates(
    [a, b]: [&PreparedShape; 2],
    [of_a, of_b]: [PiecesRef; 2],
    relative: &Relative,
    margin: f64,
    buffers: &mut ContactBuffers,
) {
    let ContactBuffers { candidates, near_pieces, .. } = buffers;
    candidates.clear();
    // Eight at a time of the one that has more of them.
    let swapped = of_a.boxes.len() > of_b.boxes.len();
    let ((one, each), (other, all)) = if swapped { ((b, of_b), (a, of_a)) } else { ((a, of_a), (b, of_b)) };
    let (pose_a_b, pose_b_a) = (relative.pose_a_b, relative.pose_a_b.inverse());
    let (pose_one_other, pose_other_one) = if swapped { (pose_b_a, pose_a_b) } else { (pose_a_b, pose_b_a) };
    let (around_one, around_other) = (Cuboid::around(&one.shape.bounds), Cuboid::around(&other.shape.bounds));
    near_pieces.clear();
    if each.shapes.len() == 1 {
        near_pieces.push(0);
    } else {
        let view = View::new(&pose_one_other, &around_one, &around_other);
        let near = |_, k| near_pieces.push(k);
        Arch::new().dispatch(NearBoxes { boxes: each.boxes, view: &view, seen: around_other, margin, near });
    }
    let view = View::new(&pose_other_one, &around_other, &around_one);
    for &k in near_pieces.iter() {
        let shape = &each.shapes[k];
        let near = |bound: f32, l: usize| {
            let (i, j) = if swapped { (l, k) } else { (k, l) };
            let (center_y, radius_y) = of_b.shapes[j].ball;
            let beyond = beyond_box(&of_a.shapes[i], &relative.pose_a_b.point(&center_y));
            let bound = f64::from(bound).max(beyond.norm() - radius_y);
            candidates.extend((bound < margin).then_some((bound, i, j)));
        };
        Arch::new().dispatch(NearBoxes {
            boxes: all.boxes,
            view: &view,
            seen: Cuboid::around(&shape.bounds),
            margin,
            near,
        });
    }
}

/// Calls `near` with those boxes that may be nearer than the margin to the one seen, and lower
/// bounds \[m\] on how far they are.
struct NearBoxes<'a, F> {
    boxes: &'a [Boxes],
    view: &'a View,
    seen: Cuboid,
    margin: f64,
    near: F,
}

impl<F: FnMut(f32, usize)> WithSimd for NearBoxes<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (seen, margin) = (self.view.see(&self.seen, 0.0), rounded_up(self.margin));
        for (at, boxes) in self.boxes.iter().enumerate() {
            let bounds = boxes.lower_bounds(simd, self.view, &seen);
            for lane in lanes_of(below(&bounds, margin)) {
                (self.near)(bounds[lane], at * LANES + lane);
            }
        }
    }
}

/// Two pieces across the direction from the box around the first to the centre of the ball around
/// the second: how far planes across it part them \[m\] (nearly their distance where that is more
/// than a fraction of their size; negative where none does), and the points that those touch.
fn plane_between(x: &Shape, y: &Shape, pose_x_y: &Pose) -> Near {
    let center_y = pose_x_y.point(&y.ball.0);
    let beyond = beyond_box(x, &center_y);
    let along = if beyond == Vec3::zeros() { center_y - x.bounds.center } else { beyond };
    let along = along.try_normalize(0.0).unwrap_or_else(Vec3::x);
    let (first, second) = (&solid(x).shape, &solid(y).shape);
    let point_first = first.core.support(&along) + along * first.radius;
    let lowest = second.core.support(&pose_x_y.inverse_vector(&-along));
    let point_second = pose_x_y.point(&lowest) - along * second.radius;
    let distance = (point_second - point_first).dot(&along);
    Near { distance, point_first, point_second, normal: -along }
}

/// From the nearest point of the box around a shape to a point in its frame.
fn beyond_box(x: &Shape, point: &Vec3) -> Vec3 {
    let offset = point - x.bounds.center;
    offset - offset.zip_map(&x.bounds.half, |o, half| o.clamp(-half, half))
}

/// What a piece is.
pub fn solid(piece: &Shape) -> &ConvexSolid {
    match &piece.kind {
        ShapeKind::Convex(solid) => solid,
        ShapeKind::Mesh(_) | ShapeKind::Scenery(_) => unreachable!("pieces are convex"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Contact;
    use crate::collision::contacts::convex_convex::COARSE;
    use crate::collision::contacts::gather;
    use crate::collision::narrow_phase::{self, Buffers, SeparatingWitness};
    use crate::collision::prepared::Placed;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined, placed};
    use crate::robot::Geometry;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    #[test]
    fn candidates_come_in_order_block_by_block() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        for count in [0, 1, 31, 32, 33, 64, 65, 500] {
            // Some bounds are equal.
            let mut some: Vec<Candidate> =
                (0..count).map(|i| (f64::from(rng.random_range(0..100_u32)), i % 7, i)).collect();
            let mut all = some.clone();
            all.sort_unstable_by(|x, y| x.partial_cmp(y).unwrap());
            for (at, expected) in all.iter().enumerate() {
                sort_by_blocks(&mut some, at);
                assert_eq!(some[at], *expected, "{at} of {count}");
            }
        }
    }

    /// A bracket, a lumpy body and two convex shapes, at random poses around contact, against exact
    /// distances.
    #[test]
    fn pieces_are_never_farther_than_the_shapes_and_hardly_nearer() {
        let mesh = |mesh| Geometry::Mesh(Arc::new(mesh));
        let bracket = [
            cuboid(Vec3::zeros(), Vec3::new(0.2, 0.05, 0.05)),
            cuboid(Vec3::new(0.15, 0.0, 0.2), Vec3::new(0.05, 0.05, 0.15)),
        ];
        let shapes = [
            mesh(joined(&bracket)),
            mesh(placed(bumpy(3, 2, 0.3), 0.15, Vec3::zeros())),
            Geometry::Box { half_extents: [0.3, 0.2, 0.02] },
            Geometry::Capsule { radius: 0.05, half_length: 0.1 },
        ]
        .map(|geometry| PreparedShape::new(&geometry).unwrap());
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (mut buffers, mut memory, mut contacts) =
            (Buffers::default(), ContactBuffers::default(), Vec::<Contact>::new());
        let (margin, mut apart, mut overlapping, mut off) = (0.05, 0, 0, Vec::new());
        for round in 0..3000 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let pose = Pose::from_xyz_rpy(vector(0.7).into(), vector(6.0).into());
            let (a, b) = (&shapes[round % 2], &shapes[round / 2 % 4]);
            let (first, second) =
                (Placed { prepared: a, pose: &Pose::identity() }, Placed { prepared: b, pose: &pose });
            let mut nearest = |clearance: f64| {
                let place = PairPlace { pair: crate::scene::PairId::new(0), parts: round % 8, start: 0, clearance };
                memory.forget();
                contacts.clear();
                let query = ContactQuery { margin, search: ContactSearch::Proposal };
                gather([first, second], query, place, &mut SeparatingWitness::default(), &mut memory, &mut contacts);
                contacts.iter().map(|contact| contact.distance).fold(margin, f64::min)
            };
            // Below twice the clearance, distances of pieces are exact; above it a share may be
            // missing, and far ones are only known to be far.
            let (found, slack) = (nearest(margin), nearest(1e-3));
            let least = ((1.0 - COARSE.gap) * found).min(FAR * margin);
            assert!(slack <= found + 1e-7 && slack >= least - 1e-7 || found < 0.0);
            let exact = narrow_phase::signed_distance(first, second, margin, &mut buffers).unwrap_or(margin);
            assert!(found <= exact.max(0.0) + 1e-7, "{round}: {found} {exact}");
            if exact > 0.0 && exact < margin {
                apart += 1;
                off.push(exact - found);
            }
            overlapping += usize::from(exact < 0.0);
        }
        off.sort_by(f64::total_cmp);
        let worst = off[off.len() - 1];
        assert!(apart > 100 && overlapping > 100, "{apart} {overlapping}");
        assert!(off[off.len() / 2] < 1e-4 && worst < 1e-2, "median {} worst {worst}", off[off.len() / 2]);
    }
}

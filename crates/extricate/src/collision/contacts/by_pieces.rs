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

/// Pairs of pieces after which only those within the clearance or nearer than the nearest contact
/// are evaluated. More change descents little. Lab L078.
const UNRESTRICTED_PAIRS: usize = 4;
/// If a plane parts two pieces by more than this share of the margin, the plane is their contact
/// and their distance is not searched for. Lab L061.
pub(crate) const FAR_SHARE: f64 = 0.4;

/// Overlapping pairs of pieces after which a search ends. Where links fold into each other hundreds
/// overlap, most because others do. With fewer, descents that run into bodies take more
/// evaluations; with more, as many. Lab L078.
const MAX_OVERLAPS: usize = 4;
/// Candidates that are sorted at a time: of thousands, only the first few are evaluated.
const SORT_BLOCK_PAIRS: usize = 32;

/// Offers `sink` contacts of pieces nearer than the margin, nearest first. Of overlapping pieces,
/// it offers those whose boxes overlap most.
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
    let far = (FAR_SHARE * query.margin).max(2.0 * place.clearance);
    let (mut evaluated, mut overlaps, mut nearest) = (0, 0, query.margin);
    for at in 0..candidates.len() {
        sort_by_blocks(candidates, at);
        let (bound, i, j) = candidates[at];
        let limit = if evaluated < UNRESTRICTED_PAIRS { query.margin } else { nearest.max(place.clearance) };
        if bound >= limit {
            break;
        }
        let (x, y) = (&of_a.shapes[i], &of_b.shapes[j]);
        let plane = plane_between(x, y, &relative.pose_a_b);
        let bound = bound.max(plane.distance);
        if bound >= limit {
            continue;
        }
        evaluated += 1;
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
        if overlaps == MAX_OVERLAPS {
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

/// Sorts the nearest candidates from `at` on if a block begins there.
fn sort_by_blocks(candidates: &mut [Candidate], at: usize) {
    if !at.is_multiple_of(SORT_BLOCK_PAIRS) {
        return;
    }
    let by_bound = |x: &Candidate, y: &Candidate| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2)));
    let rest = &mut candidates[at..];
    if rest.len() > 2 * SORT_BLOCK_PAIRS {
        rest.select_nth_unstable_by(SORT_BLOCK_PAIRS, by_bound);
        rest[..SORT_BLOCK_PAIRS].sort_unstable_by(by_bound);
    } else {
        rest.sort_unstable_by(by_bound);
    }
}

/// Returns whether known pieces that hold two shapes prove that the shapes are no nearer than the
/// margin.
pub fn are_parted(
    [a, b]: [&PreparedShape; 2],
    relative: &Relative,
    margin: f64,
    place: PairPlace,
    buffers: &mut ContactBuffers,
) -> bool {
    let (Some(of_a), Some(of_b)) = (a.known_cover(), b.known_cover()) else { return false };
    // If proposals use finer pieces, the memory is about those, not about the ones compared here.
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

/// Fills `candidates` with the pairs of pieces that may be nearer than `margin` \[m\] by their
/// boxes and balls.
pub fn find_candidates(
    [a, b]: [&PreparedShape; 2],
    [of_a, of_b]: [PiecesRef; 2],
    relative: &Relative,
    margin: f64,
    buffers: &mut ContactBuffers,
) {
    let ContactBuffers { candidates, near_pieces, .. } = buffers;
    candidates.clear();
    // The shape with more boxes is tested eight pieces at a time.
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

/// Calls `near` with the boxes that may be nearer than the margin to the one seen, each with a
/// lower bound \[m\] on its distance.
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

/// Returns by how much \[m\] two parallel planes part two pieces, and the points that they touch.
/// They lie across the direction from the box around the first piece to the centre of the ball
/// around the second. The result is nearly the distance if that is more than a fraction of the
/// pieces' size, and negative if the planes part nothing.
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

/// Returns the vector from the nearest point of the box around a shape to a point in its frame.
fn beyond_box(x: &Shape, point: &Vec3) -> Vec3 {
    let offset = point - x.bounds.center;
    offset - offset.zip_map(&x.bounds.half, |o, half| o.clamp(-half, half))
}

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
    use crate::collision::contacts::convex_convex::COARSE_SLACK;
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

    /// Compares a bracket, a lumpy body and two convex shapes with exact distances, at random poses
    /// around contact.
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
            let least = ((1.0 - COARSE_SLACK.gap) * found).min(FAR_SHARE * margin);
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

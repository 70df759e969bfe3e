//! Contacts of the convex pieces around two shapes, at least one of which is a mesh.

use super::{ContactBuffers, Near, PairPlace, Sink};
use crate::collision::bounds::Relative;
use crate::collision::shape::{ConvexSolid, Shape, ShapeKind};
use crate::collision::{ContactQuery, ContactSearch};
use crate::math::{Pose, Vec3};

/// Pairs of pieces that are looked at though they are neither the nearest nor within the clearance: more of them change descents little.
const MOST_FAR: usize = 4;

/// Offers `sink` the contact of every two pieces nearer than the margin, nearest first.
pub fn by_pieces(
    [a, b]: [&Shape; 2],
    relative: &Relative,
    query: ContactQuery,
    place: PairPlace,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    let (of_a, of_b) = (a.pieces(), b.pieces());
    find_candidates([a, b], [of_a, of_b], relative, query.margin, buffers);
    let ContactBuffers { found, memory, candidates, .. } = buffers;
    candidates.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    found.clear();
    let mut nearest = query.margin;
    for (looked_at, &(bound, i, j)) in candidates.iter().enumerate() {
        if looked_at >= MOST_FAR && bound >= nearest.max(place.clearance) {
            break;
        }
        let (x, y) = (&of_a[i], &of_b[j]);
        let memory = memory.of_pieces(place.parts, of_a.len() * of_b.len(), i * of_b.len() + j);
        let contact = memory.contact([solid(x), solid(y)], y.ball, relative, query, place.clearance, || bound);
        nearest = contact.map_or(nearest, |contact| nearest.min(contact.distance));
        found.extend(contact.map(Near::from));
    }
    found.sort_unstable_by(|x, y| x.distance.total_cmp(&y.distance));
    for near in found.iter() {
        if !sink.offer(near) {
            break;
        }
    }
}

/// Whether the pieces around two shapes prove, where they are known, that the shapes are no nearer than the margin.
pub fn are_parted(
    [a, b]: [&Shape; 2],
    relative: &Relative,
    margin: f64,
    place: PairPlace,
    buffers: &mut ContactBuffers,
) -> bool {
    let (Some(of_a), Some(of_b)) = (a.known_pieces(), b.known_pieces()) else { return false };
    find_candidates([a, b], [of_a, of_b], relative, margin, buffers);
    let ContactBuffers { memory, candidates, .. } = buffers;
    let query = ContactQuery { margin, search: ContactSearch::Coarse };
    candidates.iter().all(|&(bound, i, j)| {
        let (x, y) = (&of_a[i], &of_b[j]);
        let memory = memory.of_pieces(place.parts, of_a.len() * of_b.len(), i * of_b.len() + j);
        memory.contact([solid(x), solid(y)], y.ball, relative, query, place.clearance, || bound).is_none()
    })
}

/// Fills `candidates` with the pairs of pieces that may be nearer than `margin` \[m\], as boxes, balls and one direction tell.
fn find_candidates(
    [a, b]: [&Shape; 2],
    [of_a, of_b]: [&[Shape]; 2],
    relative: &Relative,
    margin: f64,
    buffers: &mut ContactBuffers,
) {
    let ContactBuffers { near_pieces, candidates, .. } = buffers;
    let pose = &relative.pose_a_b;
    let beyond = |x: &Shape, y: &Shape, center_y: &Vec3| {
        let reach = x.ball.1 + y.ball.1 + margin;
        (x.ball.0 - center_y).norm_squared() >= reach * reach
    };
    near_pieces.clear();
    let centers = of_b.iter().map(|y| pose.point(&y.ball.0)).enumerate();
    near_pieces.extend(centers.filter(|(j, center)| !beyond(a, &of_b[*j], center)));
    candidates.clear();
    for (i, x) in of_a.iter().enumerate() {
        if of_a.len() > 1 && relative.lower_bound(&x.bounds, &b.bounds) >= margin {
            continue;
        }
        for (j, center) in near_pieces.iter().filter(|(j, center)| !beyond(x, &of_b[*j], center)) {
            let y = &of_b[*j];
            let reach = y.ball.1 + margin;
            if beyond_box(x, center).norm_squared() >= reach * reach {
                continue;
            }
            let bound = relative.lower_bound(&x.bounds, &y.bounds);
            if bound < margin {
                let bound = bound.max(gap_toward(x, y, pose, center));
                candidates.extend((bound < margin).then_some((bound, i, *j)));
            }
        }
    }
}

/// The gap \[m\] between two pieces along the direction from the box around the first to the centre of the ball around the second, `center_y` in the
/// frame of the first: nearly their distance where that is more than a fraction of their size.
fn gap_toward(x: &Shape, y: &Shape, pose_x_y: &Pose, center_y: &Vec3) -> f64 {
    let beyond = beyond_box(x, center_y);
    let along = if beyond == Vec3::zeros() { center_y - x.bounds.center } else { beyond };
    let Some(along) = along.try_normalize(0.0) else { return f64::NEG_INFINITY };
    let (first, second) = (&solid(x).shape, &solid(y).shape);
    let highest = first.core.support(&along).dot(&along) + first.radius;
    let lowest = pose_x_y.point(&second.core.support(&pose_x_y.inverse_vector(&-along))).dot(&along) - second.radius;
    lowest - highest
}

/// From the nearest point of the box around a shape to a point in its frame.
fn beyond_box(x: &Shape, point: &Vec3) -> Vec3 {
    let offset = point - x.bounds.center;
    offset - offset.zip_map(&x.bounds.half, |o, half| o.clamp(-half, half))
}

fn solid(piece: &Shape) -> &ConvexSolid {
    match &piece.kind {
        ShapeKind::Convex(solid) => solid,
        ShapeKind::Mesh(_) => unreachable!("pieces are convex"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::gather;
    use super::*;
    use crate::collision::Contact;
    use crate::collision::convex_contact::COARSE;
    use crate::collision::part_pair::{self, Buffers, Hint, Placed};
    use crate::collision::test_mesh::{bumpy, cuboid, joined, placed};
    use crate::robot::Geometry;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    /// A bracket, a lumpy body and two convex shapes, at random poses around contact, against exact distances.
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
            Geometry::Box { half_extents: Vec3::new(0.3, 0.2, 0.02) },
            Geometry::Capsule { radius: 0.05, half_length: 0.1 },
        ]
        .map(|geometry| Shape::new(&geometry).unwrap());
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (mut buffers, mut memory, mut contacts) =
            (Buffers::default(), ContactBuffers::default(), Vec::<Contact>::new());
        let (margin, mut apart, mut overlapping, mut off) = (0.05, 0, 0, Vec::new());
        for round in 0..3000 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let pose = Pose::from_xyz_rpy(vector(0.7).into(), vector(6.0).into());
            let (a, b) = (&shapes[round % 2], &shapes[round / 2 % 4]);
            let (first, second) = (Placed { shape: a, pose: &Pose::identity() }, Placed { shape: b, pose: &pose });
            let mut nearest = |clearance: f64| {
                let place = PairPlace { pair: 0, parts: round % 8, start: 0, clearance };
                memory.forget();
                contacts.clear();
                let query = ContactQuery { margin, search: ContactSearch::Coarse };
                gather([first, second], query, place, &mut Hint::default(), &mut memory, &mut contacts);
                contacts.iter().map(|contact| contact.distance).fold(margin, f64::min)
            };
            // Below twice the clearance, distances of pieces are exact; above it a share may be missing.
            let (found, slack) = (nearest(margin), nearest(1e-3));
            assert!(slack <= found + 1e-7 && slack >= (1.0 - COARSE.gap) * found.min(margin) - 1e-7 || found < 0.0);
            let exact = part_pair::signed_distance(first, second, margin, &mut buffers).unwrap_or(margin);
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

//! Compares triangulations with areas and crossing numbers, which need no triangles.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::math::Pose;
use crate::robot::mesh::polygon::*;

/// Whether a point lies within an odd number of rings: crossings of a ray toward +x.
fn within(rings: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> bool {
    let sides = rings.iter().flat_map(|ring| (0..ring.len()).map(move |k| (ring[k], ring[(k + 1) % ring.len()])));
    sides.filter(|([a, b], [c, d])| (*b > y) != (*d > y) && x < a + (y - b) * (c - a) / (d - b)).count() % 2 == 1
}

fn twice_area(ring: &[[f64; 2]]) -> f64 {
    (0..ring.len()).map(|k| (ring[k], ring[(k + 1) % ring.len()])).map(|([a, b], [c, d])| a * d - b * c).sum()
}

/// Triangulates rings placed in space, and checks their triangles in the plane they came from.
fn check(rings: &[Vec<[f64; 2]>], pose: &Pose, rng: &mut ChaCha8Rng) {
    let flat: Vec<[f64; 2]> = rings.concat();
    let vertices: Vec<Vec3> = flat.iter().map(|[x, y]| pose.point(&Vec3::new(*x, *y, 0.0))).collect();
    let mut start = 0;
    let indices: Vec<Vec<u32>> = rings
        .iter()
        .map(|ring| {
            start += ring.len();
            (start as u32 - ring.len() as u32..start as u32).collect()
        })
        .collect();
    let indices: Vec<&[u32]> = indices.iter().map(Vec::as_slice).collect();
    let mut triangles = Vec::new();
    triangulate(&vertices, &indices, &mut triangles).unwrap();
    let corners = |t: &[u32; 3]| t.map(|k| flat[k as usize]).to_vec();
    let holes: f64 = rings[1..].iter().map(|hole| twice_area(hole).abs()).sum();
    let expected = twice_area(&rings[0]) - twice_area(&rings[0]).signum() * holes;
    let sum: f64 = triangles.iter().map(|t| twice_area(&corners(t))).sum();
    assert!((sum - expected).abs() < 1e-9 * expected.abs(), "{sum} {expected} {rings:?}");
    for _ in 0..60 {
        let [a, b] = [0; 2].map(|_| flat[rng.random_range(0..flat.len())]);
        let s: f64 = rng.random();
        let mut point = [a[0] + (b[0] - a[0]) * s, a[1] + (b[1] - a[1]) * s];
        point.iter_mut().for_each(|x| *x += 0.2 * (rng.random::<f64>() - 0.5));
        let covers = triangles.iter().filter(|t| within(&[corners(t)], point)).count();
        assert_eq!(covers, usize::from(within(rings, point)), "{point:?} {rings:?}");
    }
    // Every side of a ring is one of a triangle, and inner sides meet each other.
    let mut sides: HashMap<[u32; 2], usize> = HashMap::new();
    let same = |k: u32| flat.iter().position(|corner| *corner == flat[k as usize]).unwrap() as u32;
    let mut add = |a: u32, b: u32| {
        let (a, b) = (same(a), same(b));
        *sides.entry([a.min(b), a.max(b)]).or_default() += 1;
    };
    triangles.iter().for_each(|t| (0..3).for_each(|k| add(t[k], t[(k + 1) % 3])));
    indices.iter().for_each(|ring| (0..ring.len()).for_each(|k| add(ring[k], ring[(k + 1) % ring.len()])));
    assert!(sides.values().all(|count| count % 2 == 0), "{rings:?}: {sides:?}");
}

fn somewhere(rng: &mut ChaCha8Rng) -> Pose {
    let mut vector = |scale: f64| [0; 3].map(|_| scale * (rng.random::<f64>() - 0.5));
    Pose::from_xyz_rpy(vector(3.0), vector(6.0))
}

/// A ring around `center`, at a random distance in every direction.
fn star(rng: &mut ChaCha8Rng, center: [f64; 2], [least, most]: [f64; 2], corners: usize) -> Vec<[f64; 2]> {
    let corner = |k: usize, rng: &mut ChaCha8Rng| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / corners as f64).sin_cos();
        let r = least + (most - least) * rng.random::<f64>();
        [center[0] + r * cos, center[1] + r * sin]
    };
    (0..corners).map(|k| corner(k, rng)).collect()
}

#[test]
fn random_concave_faces_are_filled_once_and_nothing_else_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    for round in 0..300 {
        let corners = rng.random_range(4..40);
        let mut rings = vec![star(&mut rng, [0.0; 2], [0.2, 1.0], corners)];
        if round % 3 == 1 {
            let turn = round % rings[0].len();
            rings[0].rotate_left(turn);
            rings[0].reverse();
        }
        let pose = if round % 2 == 0 { Pose::identity() } else { somewhere(&mut rng) };
        check(&rings, &pose, &mut rng);
    }
}

#[test]
fn random_holes_stay_open() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    for round in 0..200 {
        let mut rings = vec![star(&mut rng, [0.0; 2], [1.0, 1.6], 24)];
        for at in [[-0.4, -0.4], [0.4, -0.3], [0.0, 0.45]].iter().take(1 + round % 3) {
            let corners = rng.random_range(3..9);
            rings.push(star(&mut rng, *at, [0.05, 0.28], corners));
            if rng.random() {
                rings.last_mut().unwrap().reverse();
            }
        }
        let pose = if round % 2 == 0 { Pose::identity() } else { somewhere(&mut rng) };
        check(&rings, &pose, &mut rng);
    }
}

/// Staircases and combs on a grid have many corners on one line, and sides that end on others.
#[test]
fn corners_on_a_line_stay_corners() {
    let mut rng = ChaCha8Rng::seed_from_u64(43);
    for round in 0..200 {
        let teeth = rng.random_range(1..6);
        let mut ring = vec![[0.0, 0.0]];
        (1..=2 * teeth).for_each(|x| ring.push([f64::from(x), 0.0]));
        for tooth in (0..teeth).rev() {
            let (x, top) = (f64::from(2 * tooth), f64::from(rng.random_range(2..5)));
            ring.extend([[x + 2.0, 1.0], [x + 2.0, top], [x + 1.0, top], [x + 1.0, 1.0]]);
        }
        ring.dedup();
        ring.push([0.0, 1.0]);
        let turn = round % ring.len();
        ring.rotate_left(turn);
        if round % 2 == 0 {
            ring.reverse();
        }
        let pose = Pose::from_xyz_rpy([0.0; 3], [0.0, 0.0, [0.0, 0.3][round % 2]]);
        check(&[ring], &pose, &mut rng);
    }
    // A convex ring keeps them too.
    check(
        &[vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0], [0.0, 1.0]]],
        &Pose::identity(),
        &mut rng,
    );
}

#[test]
fn a_hole_may_be_reached_by_a_slit() {
    let ring = [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]];
    check(&[ring.to_vec()], &somewhere(&mut ChaCha8Rng::seed_from_u64(5)), &mut ChaCha8Rng::seed_from_u64(44));
}

#[test]
fn faces_that_cross_themselves_are_refused_and_keep_their_sides() {
    let at = |points: &[[f64; 2]]| -> Vec<Vec3> { points.iter().map(|[x, y]| Vec3::new(*x, 7.0, *y)).collect() };
    let refused = |points: &[[f64; 2]], rings: &[&[u32]], left: usize| {
        let mut triangles = Vec::new();
        assert_eq!(triangulate(&at(points), rings, &mut triangles), Err(Untriangulable), "{points:?}");
        assert_eq!(triangles.len(), left);
    };
    let square = [[0., 0.], [4., 0.], [4., 4.], [0., 4.]];
    refused(&square, &[&[0, 2, 1, 3]], 2);
    refused(&[[0., 0.], [4., 0.], [4., 4.], [0., 4.], [5., 1.], [5., 2.], [6., 1.]], &[&[0, 1, 2, 3], &[4, 5, 6]], 3);
    refused(&[[0., 0.], [4., 0.], [4., 4.], [0., 4.], [3., 1.], [5., 2.], [3., 3.]], &[&[0, 1, 2, 3], &[4, 5, 6]], 3);
    // A pentagram turns left everywhere, but goes around twice.
    let star: Vec<[f64; 2]> =
        (0..5).map(|k| (2.0 * std::f64::consts::TAU * f64::from(k) / 5.0).sin_cos().into()).collect();
    refused(&star, &[&[0, 1, 2, 3, 4]], 3);
    // This ring goes around the same square twice.
    refused(&square, &[&[0, 1, 2, 3, 0, 1, 2, 3]], 6);
}

#[test]
fn points_and_lines_are_nothing() {
    let vertices = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let mut triangles = Vec::new();
    for rings in [&[][..], &[&[0u32][..]], &[&[0, 1][..]], &[&[0, 1][..], &[0, 1, 2]]] {
        triangulate(&vertices, rings, &mut triangles).unwrap();
    }
    assert!(triangles.is_empty());
    triangulate(&vertices, &[&[0, 1, 2], &[0]], &mut triangles).unwrap();
    assert_eq!(triangles, [[0, 1, 2]]);
}

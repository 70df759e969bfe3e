//! Pieces hold their meshes, and follow them.

use crate::collision::convex_decomposition::cells::{corners, *};
use crate::collision::convex_decomposition::*;
use crate::collision::convex_distance;
use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined, opened, placed};
use crate::math::Pose;
use rand::{RngExt, SeedableRng};

fn divided(mesh: &TriangleMesh) -> (MeshShape, Vec<Shape>, f64) {
    divided_into(mesh, MAX_CELLS)
}

fn divided_into(mesh: &TriangleMesh, most: usize) -> (MeshShape, Vec<Shape>, f64) {
    let shape = MeshShape::new(mesh);
    let bounds = Aabb::around(shape.vertices.iter());
    let (all, radius) = (mesh_triangles(mesh), bounds.half.norm());
    let pieces = cells(&shape, all, radius, TOLERANCE_SHARE * radius, most, false)
        .iter()
        .map(|cell| solid(&cell.hull.vertices))
        .collect();
    (shape, pieces, bounds.half.norm())
}

fn mesh_triangles(mesh: &TriangleMesh) -> Vec<[Vec3; 3]> {
    corners(mesh).collect()
}

fn solid_of(piece: &Shape) -> &ConvexSolid {
    let ShapeKind::Convex(solid) = &piece.kind else { panic!("convex") };
    solid
}

fn distance(piece: &Shape, point: &Vec3) -> f64 {
    let ball = ConvexShape { core: ConvexCore::Point, radius: 0.0 };
    let identity = Pose::identity();
    let found = convex_distance::separation(
        &ball,
        &Pose::translation(*point),
        &solid_of(piece).shape,
        &identity,
        f64::INFINITY,
    );
    found.map_or(f64::INFINITY, |found| found.distance)
}

/// A ring of twelve boxes, like a torus.
fn ring() -> TriangleMesh {
    let parts: Vec<TriangleMesh> = (0..12)
        .map(|k| {
            let turn = std::f64::consts::TAU * f64::from(k) / 12.0;
            cuboid(Vec3::new(turn.cos(), turn.sin(), 0.0) * 0.5, Vec3::new(0.14, 0.14, 0.1))
        })
        .collect();
    joined(&parts)
}

#[test]
fn pieces_hold_the_mesh() {
    let bracket =
        [cuboid(Vec3::zeros(), Vec3::new(1.0, 0.2, 0.2)), cuboid(Vec3::new(0.8, 0.0, 1.0), Vec3::new(0.2, 0.2, 0.9))];
    let meshes = [joined(&bracket), bumpy(3, 2, 0.4), opened(placed(bumpy(5, 2, 0.2), 0.15, Vec3::x()), 30), ring()];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    for mesh in meshes {
        let (shape, pieces, radius) = divided(&mesh);
        let (mut on_surface, mut inside) = (0, 0);
        for round in 0..600 {
            let point = if round % 2 == 0 {
                let [a, b, c] = mesh.corners(rng.random_range(0..mesh.triangles.len()));
                let (s, t): (f64, f64) = (rng.random(), rng.random());
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                on_surface += 1;
                a + (b - a) * s + (c - a) * t
            } else {
                let [a, b] = [0; 2].map(|_| mesh.vertices[rng.random_range(0..mesh.vertices.len())]);
                let point = a + (b - a) * rng.random::<f64>();
                if !shape.holds(&point, &mut Vec::new()) {
                    continue;
                }
                inside += 1;
                point
            };
            let nearest = pieces.iter().map(|piece| distance(piece, &point)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9 * radius, "{nearest} from {} pieces", pieces.len());
        }
        assert!(on_surface == 300 && (inside > 10 || !mesh.is_closed()), "{inside}");
    }
}

#[test]
fn a_narrow_hole_through_a_wide_plate_stays_open() {
    let (mut v, mut t) = (Vec::new(), Vec::new());
    for i in 0..4u32 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 4.0).sin_cos();
        for (r, z) in [(1.0607, -1.5), (7.0711, -1.5), (7.0711, 1.5), (1.0607, 1.5)] {
            v.push(Vec3::new(r * cos, r * sin, z));
        }
        for k in 0..4u32 {
            let at = |i: u32, k: u32| 4 * (i % 4) + k % 4;
            t.push([at(i, k), at(i + 1, k), at(i + 1, k + 1)]);
            t.push([at(i, k), at(i + 1, k + 1), at(i, k + 1)]);
        }
    }
    let mesh = TriangleMesh::new(v, t);
    let (shape, pieces, radius) = divided(&mesh);
    assert!(shape.closed == [true] && (4..=8).contains(&pieces.len()), "{} pieces", pieces.len());
    let middle = Vec3::new(0.05, 0.02, 0.1);
    let nearest = pieces.iter().map(|piece| distance(piece, &middle)).fold(f64::INFINITY, f64::min);
    assert!(
        (nearest + shape.depth_above(&middle, f64::NEG_INFINITY, &mut Vec::new()).unwrap()).abs() < 1e-6 * radius,
        "{nearest}"
    );
}

#[test]
fn pieces_follow_the_surface() {
    let bracket =
        [cuboid(Vec3::zeros(), Vec3::new(1.0, 0.2, 0.2)), cuboid(Vec3::new(0.8, 0.0, 1.0), Vec3::new(0.2, 0.2, 0.8))];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    for (mesh, most, beyond) in [(joined(&bracket), 3, 1e-9), (ring(), MAX_PARTS, 2.0 * TOLERANCE_SHARE)] {
        let (shape, pieces, radius) = divided_into(&mesh, MAX_PARTS);
        assert!((2..=most).contains(&pieces.len()), "{}", pieces.len());
        for piece in &pieces {
            let ConvexCore::Hull(hull) = &solid_of(piece).shape.core else { panic!("a hull") };
            for _ in 0..300 {
                let mut weights: Vec<f64> = hull.points().iter().map(|_| rng.random::<f64>().powi(4)).collect();
                let sum: f64 = weights.iter().sum();
                weights.iter_mut().for_each(|w| *w /= sum);
                let point: Vec3 = hull.points().iter().zip(&weights).map(|(p, w)| p * *w).sum();
                let depth = shape.depth_above(&point, f64::NEG_INFINITY, &mut Vec::new()).unwrap();
                assert!(depth >= -beyond * radius, "{depth} of {radius} in one of {} pieces", pieces.len());
            }
        }
    }
}

#[test]
fn the_same_mesh_gives_the_same_pieces_and_a_convex_one_gives_itself() {
    let points = |mesh: &TriangleMesh| -> Vec<Vec<Vec3>> {
        let hull = |piece: &Shape| match &solid_of(piece).shape.core {
            ConvexCore::Hull(hull) => hull.points().to_vec(),
            _ => panic!("a hull"),
        };
        divided(mesh).1.iter().map(hull).collect()
    };
    assert_eq!(points(&ring()), points(&ring()));
    assert_eq!(points(&cuboid(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0))).len(), 1);
}

#[test]
fn a_frame_of_bars_stays_open() {
    for (along, welded) in [(2.2, false), (2.2, true), (1.8, true)] {
        // Corners and faces in another order than `cuboid` has them.
        let bar = |x: f64, y: f64| {
            let half = if y == 0.0 { Vec3::new(0.2, along, 0.2) } else { Vec3::new(2.2, 0.2, 0.2) };
            let side = |k: u32, bit: u32, half: f64| if k >> bit & 1 == 1 { half } else { -half };
            let corner = |k| Vec3::new(x + side(k, 2, half.x), y + side(k, 1, half.y), side(k, 0, half.z));
            let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
            let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            TriangleMesh::new((0..8).map(corner).collect(), triangles)
        };
        let mut frame = joined(&[bar(-2.0, 0.0), bar(2.0, 0.0), bar(0.0, 2.0), bar(0.0, -2.0)]);
        if welded {
            frame = TriangleMesh::new(frame.vertices, frame.triangles);
        }
        let parts: Vec<Shape> = convex_parts(&frame).0.iter().map(|hull| solid(&hull.vertices)).collect();
        for (point, expected) in [([0.0; 3], 1.8), ([1.0, -1.5, 0.0], 0.3)] {
            let apart = parts.iter().map(|part| distance(part, &Vec3::from(point))).fold(f64::INFINITY, f64::min);
            assert!((apart - expected).abs() < 0.02, "{along}, {welded}: {apart} of {} parts", parts.len());
        }
    }
}

/// Returns the pieces of a mesh beside a body of `size` \[m\].
fn beside(mesh: &TriangleMesh, size: f64) -> Pieces {
    let shape = MeshShape::new(mesh);
    let bounds = Aabb::around(shape.vertices.iter());
    let (cells, is_coarse) = cell_pieces(&shape, &bounds);
    let index = size_index(bounds.half.norm(), size);
    if is_coarse[index] { fine_pieces(&shape, &bounds, index) } else { cells }
}

#[test]
fn sizes_are_halves_of_the_radius() {
    let index = |size: f64| size_index(1.0, size);
    let found = [f64::INFINITY, 1.0, 0.99, 0.5, 0.3, 1e-9].map(index);
    assert_eq!(found, [0, 0, 1, 1, 2, SIZES - 1]);
}

#[test]
fn many_small_solids_are_a_piece_each() {
    let cube = |k: usize| cuboid(Vec3::new(k as f64, (k * k % 7) as f64, (k % 3) as f64), Vec3::repeat(0.2));
    let cubes = joined(&(0..2 * MAX_CELLS).map(cube).collect::<Vec<_>>());
    let found = beside(&cubes, 0.3);
    assert_eq!(found.all().shapes.len(), 2 * MAX_CELLS);
    assert!(found.all().shapes.iter().all(|piece| (piece.bounds.half - Vec3::repeat(0.2)).norm() < 1e-12));
    // A body larger than every gap between the cubes gets fewer pieces.
    assert!(beside(&cubes, 40.0).all().shapes.len() <= MAX_CELLS);
}

/// A bin open at the top: one closed solid, with walls of 2 mm around a metre.
fn bin() -> TriangleMesh {
    let corners = |half: f64, low: f64| {
        (0..8).map(move |k: u32| {
            let at = |axis: u32| if k >> axis & 1 == 1 { half } else { -half };
            Vec3::new(at(0), at(1), if k >> 2 & 1 == 1 { 0.5 } else { low })
        })
    };
    let vertices = corners(0.5, -0.5).chain(corners(0.498, -0.498)).collect();
    let mut triangles = Vec::new();
    let mut face = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    // Floor and sides of the outside, then of the inside, which face the other way.
    let sides = [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.into_iter().for_each(&mut face);
    sides.into_iter().for_each(|[a, b, c, d]| face([d + 8, c + 8, b + 8, a + 8]));
    // The rim.
    [[4, 5], [5, 7], [7, 6], [6, 4]].into_iter().for_each(|[a, b]| face([a, b, b + 8, a + 8]));
    TriangleMesh::new(vertices, triangles)
}

/// A pipe of no thickness.
fn pipe(sides: u32) -> TriangleMesh {
    let point = |side: u32, z: f64| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(side) / f64::from(sides)).sin_cos();
        Vec3::new(0.5 * cosine, 0.5 * sine, z)
    };
    let vertices = (0..sides).flat_map(|side| [-0.5, 0.5].map(|z| point(side, z))).collect();
    let staves = (0..sides).flat_map(|side| {
        let (a, b) = (2 * side, 2 * ((side + 1) % sides));
        [[a, b, a + 1], [b, b + 1, a + 1]]
    });
    TriangleMesh::new(vertices, staves.collect())
}

/// A bowl of two round walls, open above.
fn bowl(sides: u32, rows: u32) -> TriangleMesh {
    let point = |radius: f64, row: u32, side: u32| {
        let (sine, cosine) = (std::f64::consts::FRAC_PI_2 * f64::from(row) / f64::from(rows)).sin_cos();
        let (y, x) = (std::f64::consts::TAU * f64::from(side) / f64::from(sides)).sin_cos();
        Vec3::new(radius * sine * x, radius * sine * y, -radius * cosine)
    };
    let wall = |radius: f64| (0..=rows).flat_map(move |row| (0..sides).map(move |side| point(radius, row, side)));
    let vertices = wall(0.31).chain(wall(0.3)).collect();
    let (inner, mut triangles) = ((rows + 1) * sides, Vec::new());
    for side in 0..sides {
        let next = (side + 1) % sides;
        let mut face = |[a, b, c, d]: [u32; 4]| {
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        };
        for row in 0..rows {
            let (low, high) = (row * sides, (row + 1) * sides);
            face([low + side, high + side, high + next, low + next]);
            face([inner + low + next, inner + high + next, inner + high + side, inner + low + side]);
        }
        let rim = rows * sides;
        face([rim + side, inner + rim + side, inner + rim + next, rim + next]);
    }
    TriangleMesh::new(vertices, triangles)
}

#[test]
fn hollows_stay_open_for_bodies_that_could_enter_them() {
    for (mesh, size, most) in [(bin(), 0.1, 8), (pipe(24), 0.1, 32), (bowl(32, 8), 0.05, 400)] {
        let found = beside(&mesh, size);
        let all = found.all();
        assert!(all.shapes.len() <= most, "{} pieces", all.shapes.len());
        let nearest =
            |place: &Vec3| all.shapes.iter().map(|piece| distance(piece, place)).fold(f64::INFINITY, f64::min);
        // The middle, and places near the walls.
        for place in [Vec3::new(0.0, 0.0, -0.1), Vec3::new(0.1, 0.0, -0.1), Vec3::new(-0.05, 0.1, -0.05)] {
            assert!(nearest(&place) > 0.1, "{} at {place:?}", nearest(&place));
        }
        for at in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(at);
            let middle = (a + b + c) / 3.0;
            assert!(nearest(&middle) < 1e-5, "{} from the surface at {middle:?}", nearest(&middle));
        }
        // Larger bodies cannot enter, so that cells suffice for them.
        let coarse = beside(&mesh, 1.0);
        assert!(coarse.all().shapes.len() <= MAX_CELLS && coarse.all().first_apart == coarse.all().shapes.len());
    }
}

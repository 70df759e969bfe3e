//! Tests nested balls, wound as files may have them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::robot::Geometry;
use crate::robot::mesh::TriangleMesh;
use crate::robot::mesh::cavities::*;

/// A closed ball: its centre, its radius, and whether it is wound outward.
#[derive(Clone, Copy)]
struct Ball(Vec3, f64, bool);

fn mesh(balls: &[Ball]) -> (TriangleMesh, TriangleMesh) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for Ball(center, radius, outward) in balls {
        let ball = Geometry::Sphere { radius: *radius }.tessellate(8);
        let first = vertices.len() as u32;
        vertices.extend(ball.vertices.iter().map(|v| v + center));
        triangles.extend(
            ball.triangles.iter().map(|t| t.map(|v| v + first)).map(
                |[a, b, c]| {
                    if *outward { [a, b, c] } else { [a, c, b] }
                },
            ),
        );
    }
    let file = TriangleMesh { vertices: vertices.clone(), triangles: triangles.clone(), components: vec![] };
    (file, TriangleMesh::new(vertices, triangles))
}

fn at_origin(radius: f64, outward: bool) -> Ball {
    Ball(Vec3::zeros(), radius, outward)
}

fn cavities(balls: &[Ball]) -> Vec<bool> {
    let mesh = mesh(balls).1;
    assert!(mesh.is_closed() && mesh.components.len() == balls.len());
    (0..balls.len()).map(|component| mesh.is_cavity(component)).collect()
}

#[test]
fn parts_that_face_against_what_they_are_in_are_cavities() {
    for outward in [true, false] {
        let shell = |radius, same: bool| at_origin(radius, same == outward);
        assert_eq!(cavities(&[shell(1.0, true), shell(0.5, false)]), [false, true]);
        assert_eq!(cavities(&[shell(0.5, false), shell(1.0, true)]), [false, true], "it is put behind its solid");
        assert_eq!(cavities(&[shell(1.0, true), shell(0.5, true)]), [false, false]);
        let three = [shell(1.0, true), shell(0.8, false), shell(0.6, true), shell(0.4, false), shell(0.2, true)];
        assert_eq!(cavities(&three), [false, true, false, true, false]);
        let two = [shell(2.0, true), Ball(Vec3::x(), 0.3, !outward), Ball(-Vec3::x(), 0.3, !outward)];
        assert_eq!(cavities(&two), [false, true, true]);
        assert_eq!(cavities(&[shell(1.0, true), Ball(Vec3::x() * 5.0, 0.5, !outward)]), [false, false], "beside it");
    }
}

#[test]
fn what_pokes_out_or_lies_in_two_solids_is_none() {
    let poking = [at_origin(1.0, true), Ball(Vec3::x() * 0.8, 0.5, false)];
    assert_eq!(cavities(&poking), [false, false]);
    let two = [Ball(Vec3::x() * 0.3, 1.0, true), Ball(Vec3::x() * -0.3, 1.1, true), at_origin(0.4, false)];
    assert_eq!(cavities(&two), [false; 3]);
}

#[test]
fn faces_that_contradict_each_other_are_those_of_a_solid() {
    let (file, _) = mesh(&[at_origin(1.0, true), at_origin(0.5, false)]);
    let mut triangles = file.triangles.clone();
    let last = triangles.len() - 1;
    triangles[last].swap(0, 1);
    let mixed = TriangleMesh::new(file.vertices.clone(), triangles);
    assert!((0..2).all(|component| !mixed.is_cavity(component)));
    // A file that shows both sides of the inner ball does not say which way that faces.
    let inner = file.triangles[file.triangles.len() / 2..].iter().map(|[a, b, c]| [*a, *c, *b]);
    let both = TriangleMesh::new(file.vertices.clone(), file.triangles.iter().copied().chain(inner).collect());
    assert!(both.is_closed() && (0..2).all(|component| !both.is_cavity(component)));
}

#[test]
fn moments_leave_cavities_out() {
    let ball = |balls: &[Ball]| Geometry::Mesh(std::sync::Arc::new(mesh(balls).1)).volume_moments().unwrap();
    let (hollow, full) = (ball(&[at_origin(1.0, true), at_origin(0.5, false)]), ball(&[at_origin(1.0, true)]));
    assert!((hollow.measure / full.measure - 0.875).abs() < 1e-9, "{hollow:?}");
    assert!(hollow.second_moment.trace() > full.second_moment.trace());
}

#[test]
fn mirrored_and_scaled_meshes_keep_their_cavities() {
    let hollow = mesh(&[at_origin(1.0, true), at_origin(0.5, false)]).1;
    for scale in [[1.0, 1.0, -1.0], [1e-3, 2e-3, 1e-3], [-1e-9, 1e-9, 1e-9]] {
        let scaled = hollow.scaled(scale);
        assert!(!scaled.is_cavity(0) && scaled.is_cavity(1), "{scale:?}");
    }
}

/// Winding numbers of the mesh have to be those of the file.
#[test]
fn random_nests_wind_as_their_files_do() {
    let mut rng = ChaCha8Rng::seed_from_u64(61);
    let (mut hollow, mut solid) = (0, 0);
    for _ in 0..120 {
        // Each ball lies within an earlier one, and apart from others in it. Some that lie in solid
        // face inward.
        let mut balls = vec![at_origin(1.0, true)];
        for _ in 0..rng.random_range(1..6) {
            let within = rng.random_range(0..balls.len());
            let Ball(center, radius, _) = balls[within];
            let way = Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5).normalize();
            let small = radius * (0.15 + 0.3 * rng.random::<f64>());
            let at = center + way * (0.9 * radius - small) * rng.random::<f64>() * 0.8;
            let around = |Ball(other, r, _): &&Ball| (other - at).norm() + small < 0.82 * r;
            let apart = |ball: &Ball| (ball.0 - at).norm() > ball.1 + small || around(&ball);
            if balls.iter().all(apart) {
                let count: i32 = balls.iter().filter(around).map(|ball| if ball.2 { 1 } else { -1 }).sum();
                balls.push(Ball(at, small, count != 1 || rng.random_range(0..3) == 0));
            }
        }
        let (file, made) = mesh(&balls);
        for _ in 0..40 {
            let Ball(center, radius, _) = balls[rng.random_range(0..balls.len())];
            let point = center + Vec3::from_fn(|_, _| 2.4 * radius * (rng.random::<f64>() - 0.5));
            let said = winding_number(&file.vertices, &file.triangles, &point);
            let found = winding_number(&made.vertices, &made.triangles, &point);
            assert!((found - said).abs() < 1e-9, "{said} {found}");
            hollow +=
                usize::from(found.round() == 0.0 && balls.iter().any(|ball| (point - ball.0).norm() < 0.9 * ball.1));
            solid += usize::from(found.round() > 0.0);
        }
    }
    assert!(hollow > 200 && solid > 1000, "{hollow} {solid}");
}

/// A hull with random windings does not say which way the ball in it faces.
#[test]
fn what_contradicts_itself_has_no_cavities() {
    for (every, expected) in [(usize::MAX, true), (3, false)] {
        let mut file = mesh(&[at_origin(1.0, true), at_origin(0.5, false)]).0;
        let hull = file.triangles.len() / 2;
        file.triangles[..hull].iter_mut().step_by(every).for_each(|triangle| triangle.swap(1, 2));
        if every == usize::MAX {
            file.triangles[0].swap(1, 2);
        }
        let found = TriangleMesh::new(file.vertices, file.triangles);
        assert_eq!((0..2).map(|part| found.is_cavity(part)).collect::<Vec<_>>(), [false, expected], "{every}");
    }
}

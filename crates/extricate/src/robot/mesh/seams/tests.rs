//! Tests solids as files in f32 have them: every triangle with corners of its own, each off by
//! units in the last place.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::robot::mesh::TriangleMesh;
use crate::robot::mesh::seams::*;
use crate::robot::{Geometry, formats};

/// Returns the corners of all triangles, each coordinate rounded to f32 and moved by up to `ulps`
/// units in the last place.
fn soup(mesh: &TriangleMesh, ulps: i32, rng: &mut ChaCha8Rng) -> Vec<Vec3> {
    let mut off = |x: f64| {
        let x = x as f32;
        let moved = f32::from_bits((x.to_bits() as i32 + rng.random_range(-ulps..=ulps)) as u32);
        f64::from(if x == 0.0 { x } else { moved })
    };
    (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).map(|corner| corner.map(&mut off)).collect()
}

fn from_soup(corners: Vec<Vec3>) -> (TriangleMesh, Option<Welding>) {
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let (mesh, mending) = TriangleMesh::mended(corners, triangles);
    (mesh, mending.welding)
}

fn volume(mesh: &TriangleMesh) -> f64 {
    volume_and_area(&mesh.vertices, &mesh.triangles).0
}

fn moved(mut mesh: TriangleMesh, by: Vec3) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v += by);
    mesh
}

#[test]
fn random_seams_are_closed_wherever_the_solid_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(51);
    let shapes = [
        Geometry::Box { half_extents: [0.3, 0.15, 0.07] },
        Geometry::Sphere { radius: 0.4 },
        Geometry::Capsule { radius: 0.03, half_length: 0.3 },
        Geometry::Cylinder { radius: 900.0, half_length: 20.0 },
    ];
    for round in 0..80 {
        let size = [1.0, 1.0, 1.0, 2000.0][round % 4];
        let far = [0.0, 0.5, 8.0][round % 3] * size;
        let by = Vec3::from_fn(|_, _| far * (rng.random::<f64>() - 0.5));
        let mesh = moved(shapes[round % 4].tessellate(20), by);
        let (found, welding) = from_soup(soup(&mesh, 1 + round as i32 / 40, &mut rng));
        assert!(found.is_closed() && found.components.len() == 1, "{round}: {} components", found.components.len());
        assert_eq!((found.vertices.len(), found.triangles.len()), (mesh.vertices.len(), mesh.triangles.len()));
        assert!((volume(&found) / volume(&mesh) - 1.0).abs() < 1e-4, "{round}");
        let welding = welding.unwrap();
        assert!(welding.corners > 0 && welding.closed == 1 && welding.farthest > 0.0, "{welding:?}");
        assert!(welding.farthest < 1e-6 * (size + by.norm()), "{welding:?}");
    }
}

#[test]
fn what_does_not_close_stays_as_it_was() {
    let mut rng = ChaCha8Rng::seed_from_u64(52);
    let ball = Geometry::Sphere { radius: 0.4 }.tessellate(16);
    for missing in [1, 2, 40] {
        let mut corners = soup(&ball, 1, &mut rng);
        corners.truncate(corners.len() - 3 * missing);
        let (found, welding) = from_soup(corners.clone());
        assert!(welding.is_none() && found.components.iter().all(|part| !part.closed));
        let stays = |corner: &Vec3| found.vertices.iter().any(|v| (v - corner).norm() < 1e-9);
        assert!(corners.iter().all(stays), "corners moved");
    }
    // This seam is wider than f32 explains.
    let mut lid = soup(&ball, 0, &mut rng);
    lid[..90].iter_mut().for_each(|corner| corner.x += 1e-5);
    assert!(from_soup(lid).1.is_none());
}

#[test]
fn a_solid_with_seams_closes_beside_what_is_open() {
    let mut rng = ChaCha8Rng::seed_from_u64(53);
    let block = Geometry::Box { half_extents: [0.25; 3] }.tessellate(4);
    let mut corners = soup(&block, 1, &mut rng);
    let solid = corners.len() / 3;
    // A sheet ends at a corner of the block.
    let tip = Vec3::repeat(0.25);
    corners.extend([tip, tip + Vec3::x(), tip + Vec3::y()]);
    let (found, welding) = from_soup(corners.clone());
    assert_eq!(welding.unwrap().closed, 1);
    let sizes: Vec<(usize, bool)> = found.components.iter().map(|part| (part.triangles.len(), part.closed)).collect();
    assert_eq!(sizes, [(solid, true), (1, false)]);
    assert!(corners[3 * solid..].iter().all(|corner| found.vertices.contains(corner)));
    // Two solids that touch are closed too.
    let other = moved(block.clone(), Vec3::repeat(0.5));
    let both = [soup(&block, 1, &mut rng), soup(&other, 1, &mut rng)].concat();
    let (found, _) = from_soup(both);
    assert!(found.is_closed() && (volume(&found) - 0.25).abs() < 1e-5);
}

#[test]
fn two_sides_of_a_sheet_enclose_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(54);
    let at = |x: u32, y: u32| Vec3::new(f64::from(x) * 0.13, f64::from(y) * 0.17, 0.4);
    let mut front = Vec::new();
    for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
        front.extend([at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x, y + 1)]);
    }
    let mut back = front.clone();
    back.reverse();
    back.iter_mut().for_each(|corner| corner.z += 1e-7 * rng.random::<f64>());
    let (found, welding) = from_soup([front, back].concat());
    assert!(welding.is_none() && found.components.iter().all(|part| !part.closed), "{welding:?}");
}

#[test]
fn what_was_welded_is_told() {
    let mut rng = ChaCha8Rng::seed_from_u64(55);
    let corners = soup(&Geometry::Box { half_extents: [0.1, 0.2, 0.3] }.tessellate(4), 1, &mut rng);
    let mut text = String::new();
    for (k, v) in corners.iter().enumerate() {
        text += &format!("v {} {} {}\n", v.x, v.y, v.z);
        if k % 3 == 2 {
            text += "f -3 -2 -1\n";
        }
    }
    let mut warnings = Vec::new();
    let mesh = formats::parse_and_warn("a.obj", text.as_bytes(), &mut warnings).unwrap();
    assert!(mesh.is_closed());
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("a.obj: ") && warnings[0].contains("1 of 1 components are closed"), "{warnings:?}");
}

/// The fin is open once its two sides are welded; the box does not depend on it.
#[test]
fn a_box_with_a_fin_is_closed() {
    let mut rng = ChaCha8Rng::seed_from_u64(56);
    let half = Vec3::new(0.3, 0.15, 0.07);
    let block = Geometry::Box { half_extents: half.into() }.tessellate(4);
    let [a, b] = [half, Vec3::new(half.x, half.y, -half.z)];
    let tip = Vec3::new(0.9, 0.7, 0.0);
    for sides in [1, 2] {
        let mut corners = soup(&block, 1, &mut rng);
        let solid = corners.len() / 3;
        corners.extend([a, b, tip]);
        if sides == 2 {
            corners.extend([b, a, tip]);
        }
        let (found, welding) = from_soup(corners);
        let sizes: Vec<(usize, bool)> =
            found.components.iter().map(|part| (part.triangles.len(), part.closed)).collect();
        assert_eq!(sizes, [(solid, true), (1, false)], "{sides}");
        assert_eq!(welding.unwrap().closed, 1);
        assert!((volume_and_area(&found.vertices, &found.triangles[..solid]).0 - 0.0252).abs() < 1e-6);
    }
}

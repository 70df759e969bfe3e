//! Trees and pyramids against scans of all elements.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::field::Field;
use super::{At, Element, Scenery};
use crate::collision::convex_distance::nearer_than;
use crate::collision::narrow_phase::triangle::{Triangle, closest_on_triangle};
use crate::collision::prepared::PreparedShape;
use crate::collision::shapes::ShapeKind;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::math::{Pose, Vec3};
use crate::robot::{Geometry, HeightField, PointCloud, Voxels};

fn vector(rng: &mut ChaCha8Rng, scale: f64) -> Vec3 {
    Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5))
}

fn scenery(geometry: Geometry) -> Scenery {
    Scenery::new(&geometry).unwrap().0
}

fn grid(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> Arc<HeightField> {
    let heights = (0..rows * columns).map(|_| 0.5 * rng.random::<f64>()).collect();
    Arc::new(HeightField::new("s", "f", 0.2, columns, heights).unwrap())
}

/// Finds all elements below nodes with bounds below the limit.
fn found(scenery: &Scenery, approach: &super::nodes::Approach, limit: f64) -> Vec<u32> {
    let (mut stack, mut all) = (vec![scenery.root().unwrap()], Vec::new());
    while let Some(at) = stack.pop() {
        match at.as_element() {
            Some(number) => all.push(number),
            None => scenery.open(at, approach, limit, |bound, child| {
                if bound < limit {
                    stack.push(child);
                }
            }),
        }
    }
    all.sort_unstable();
    all
}

#[test]
fn nothing_near_is_left_out_and_little_else_is_found() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for count in [1, 8, 9, 64, 65, 700] {
        let points: Vec<Vec3> = (0..count).map(|_| vector(&mut rng, 3.0)).collect();
        let cells = points.iter().map(|p| [0, 1, 2].map(|k| (p[k] / 0.1).floor() as i32)).collect();
        let all = [
            scenery(Geometry::Points(Arc::new(PointCloud::new("s", "p", 0.02, &arrays(&points)).unwrap()))),
            scenery(Geometry::Voxels(Arc::new(Voxels::new("s", "v", 0.1, cells).unwrap()))),
            scenery(Geometry::HeightField(grid(&mut rng, 2 + count % 20, 2 + count % 13))),
        ];
        for scenery in &all {
            let mut seen = 0;
            for _ in 0..60 {
                let pose = Pose::from_xyz_rpy(vector(&mut rng, 4.0).into(), vector(&mut rng, 6.0).into());
                let relative = Relative::new(pose);
                let bounds = Aabb { center: vector(&mut rng, 0.2), half: vector(&mut rng, 0.6).abs() };
                let approach = scenery.approach(&relative, &bounds);
                let limit = 0.3 * rng.random::<f64>();
                let near = found(scenery, &approach, limit);
                // Corners of the box of an element belong to it, except for balls.
                let gap = |element: Element| {
                    let place =
                        Relative::new(Pose { translation: pose.translation - element.place, rotation: pose.rotation });
                    place.lower_bound(element.bounds, &bounds)
                };
                let mut scanned = 0;
                for number in 0.. {
                    let Some(gap) = scenery.with_element(number, &approach, gap) else { break };
                    scanned += usize::from(gap < limit);
                    assert!(gap >= limit || near.binary_search(&number).is_ok(), "{number}: {gap} {limit}");
                }
                // A field bounds each cell by one box, which contains two triangles.
                assert!(near.len() <= 2 * scanned + 8 || scanned > 0 && near.len() < 6 * scanned, "{scanned}");
                seen += scanned;
            }
            assert!(count < 64 || seen > 5, "{count}: {seen}");
        }
    }
}

fn arrays(points: &[Vec3]) -> Vec<[f64; 3]> {
    points.iter().map(|point| (*point).into()).collect()
}

#[test]
fn depths_of_balls_and_cubes_are_those_of_the_deepest() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let points: Vec<Vec3> = (0..300).map(|_| vector(&mut rng, 1.0)).collect();
    let balls = scenery(Geometry::Points(Arc::new(PointCloud::new("s", "p", 0.05, &arrays(&points)).unwrap())));
    let mut stack = Vec::new();
    let mut inside = 0;
    for _ in 0..2_000 {
        let (p, least) = (vector(&mut rng, 1.5), 0.4 * (rng.random::<f64>() - 0.9));
        let expected = points.iter().map(|q| 0.05 - (p - q).norm()).fold(f64::NEG_INFINITY, f64::max);
        let found = balls.depth_above(&p, f64::NEG_INFINITY, &mut stack).unwrap();
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        assert_eq!(balls.depth_above(&p, least, &mut stack).is_some(), expected > least);
        inside += usize::from(expected > 0.0);
    }
    assert!(inside > 50, "{inside}");
}

/// A full block of cells is as deep as a box, to within one cell.
#[test]
fn cubes_side_by_side_are_deep_together() {
    let cells: Vec<[i32; 3]> = (0..9 * 9 * 9).map(|k| [k / 81, k / 9 % 9, k % 9]).collect();
    let block = scenery(Geometry::Voxels(Arc::new(Voxels::new("s", "v", 0.1, cells).unwrap())));
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut stack = Vec::new();
    for _ in 0..500 {
        let p = Vec3::repeat(0.45) + vector(&mut rng, 1.1);
        let box_depth = 0.45 - (p - Vec3::repeat(0.45)).abs().max();
        match block.depth_above(&p, 0.0, &mut stack) {
            Some(depth) => {
                assert!(depth <= box_depth + 1e-12 && depth > box_depth - 0.1 - 1e-12, "{depth} {box_depth}")
            }
            None => assert!(box_depth < 1e-12, "{box_depth}"),
        }
    }
}

#[test]
fn depths_in_the_ground_are_distances_from_its_surface() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let grid = grid(&mut rng, 8, 12);
    let field = Field::new(&grid).unwrap();
    let triangles: Vec<[Vec3; 3]> =
        (0..7 * 11).flat_map(|at| [false, true].map(|second| grid.triangle(at / 11, at % 11, second))).collect();
    let (mut stack, mut below, mut above) = (Vec::new(), 0, 0);
    for _ in 0..2_000 {
        let p = Vec3::new(0.7, 1.1, 0.2) + vector(&mut rng, 2.0).component_mul(&Vec3::new(1.0, 1.4, 0.8));
        let distance = |t: &[Vec3; 3]| (closest_on_triangle(&Triangle::new(*t), &p) - p).norm();
        let surface = triangles.iter().map(distance).fold(f64::INFINITY, f64::min);
        let depth = field.depth_above(&p, f64::NEG_INFINITY, &mut stack).unwrap();
        let aside = p.x.min(1.4 - p.x).min(p.y).min(2.2 - p.y);
        // Height of the triangle that a vertical line through the point meets.
        let height = triangles.iter().find_map(|[a, b, c]| {
            let (u, v) = (b - a, c - a);
            let (s, t) = {
                let determinant = u.x * v.y - u.y * v.x;
                let w = p - a;
                ((w.x * v.y - w.y * v.x) / determinant, (u.x * w.y - u.y * w.x) / determinant)
            };
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| a.z + u.z * s + v.z * t)
        });
        assert_eq!(height.is_some(), aside >= 0.0);
        if let (Some(height), Some(found)) = (height, field.surface(p.x, p.y)) {
            assert!((height - found).abs() < 1e-12);
        }
        match height {
            Some(height) if p.z < height => {
                assert!((depth - surface.min(aside)).abs() < 1e-12, "{depth} {surface} {aside}");
                below += 1;
            }
            Some(_) => {
                assert!((depth + surface).abs() < 1e-12, "{depth} {surface}");
                above += 1;
            }
            None => assert!(depth < 0.0 && depth >= -surface.max(-aside) - 1e-12, "{depth} {surface} {aside}"),
        }
        let least = rng.random::<f64>() - 0.7;
        assert_eq!(field.depth_above(&p, least, &mut stack), Some(depth).filter(|depth| *depth > least));
    }
    assert!(below > 200 && above > 200, "{below} {above}");
}

#[test]
fn heights_in_a_rectangle_are_those_of_its_cells() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let grid = grid(&mut rng, 9, 6);
    let field = Field::new(&grid).unwrap();
    let mut stack = Vec::new();
    for _ in 0..500 {
        let low = [3.0 * rng.random::<f64>() - 0.7, 2.0 * rng.random::<f64>() - 0.5];
        let high = low.map(|x| x + rng.random::<f64>());
        let mut expected: Option<(f64, f64)> = None;
        for (i, j) in (0..8).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let corner = |k: usize| 0.2 * k as f64;
            let touches = |k: usize, axis: usize| corner(k) <= high[axis] && low[axis] <= corner(k + 1);
            if touches(i, 0) && touches(j, 1) {
                for z in [false, true].into_iter().flat_map(|second| grid.triangle(i, j, second)).map(|p| p.z) {
                    let (least, greatest) = expected.unwrap_or((z, z));
                    expected = Some((least.min(z), greatest.max(z)));
                }
            }
        }
        assert_eq!(field.heights_in(low, high, &mut stack), expected);
    }
}

#[test]
fn nodes_and_elements_are_told_apart() {
    for number in [0, 1, (1 << 27) - 1] {
        assert_eq!(At::element(number).as_element(), Some(number as u32));
        let node = At::new(9, number);
        assert_eq!((node.as_element(), node.level(), node.number()), (None, 9, number));
    }
}

/// Boxes of places contain every near place, and reach hardly beyond them along any direction.
#[test]
fn boxes_of_places_hold_all_that_is_near() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut boxed = 0;
    for count in [1, 9, 300, 5000] {
        let points: Vec<Vec3> = (0..count).map(|_| vector(&mut rng, 1.0)).collect();
        let cells = points.iter().map(|p| [0, 1, 2].map(|k| (p[k] / 0.05).floor() as i32)).collect();
        let all = [
            scenery(Geometry::Points(Arc::new(PointCloud::new("s", "p", 0.02, &arrays(&points)).unwrap()))),
            scenery(Geometry::Voxels(Arc::new(Voxels::new("s", "v", 0.05, cells).unwrap()))),
        ];
        for scenery in &all {
            let Scenery::Many(many) = scenery else { panic!("equal shapes") };
            for _ in 0..20 {
                let half: [f64; 3] = (vector(&mut rng, 0.4).abs() + Vec3::repeat(0.02)).into();
                let other = PreparedShape::new(&Geometry::Box { half_extents: half }).unwrap();
                let ShapeKind::Convex(solid) = &other.shape.kind else { panic!("a box") };
                let pose = Pose::from_xyz_rpy(vector(&mut rng, 1.2).into(), vector(&mut rng, 6.0).into());
                let limit = 0.05 * rng.random::<f64>();
                let mut boxes = Vec::new();
                many.places_near((&other.shape, &solid.shape), &Relative::new(pose), limit, &mut boxes);
                let near = |place: &Vec3, limit: f64| {
                    let element = many.element(0).unwrap();
                    nearer_than(&element.solid.shape, &Pose::translation(*place), &solid.shape, &pose, limit)
                };
                let places: Vec<Vec3> = (0..).map_while(|number| many.element(number)).map(|e| e.place).collect();
                let within = |limit: f64| places.iter().filter(move |place| near(place, limit)).collect::<Vec<_>>();
                let holds = |all: &Aabb, p: &Vec3| ((p - all.center).abs() - all.half).max() <= 1e-6;
                assert!(within(limit).iter().all(|place| boxes.iter().any(|all| holds(all, place))));
                boxed += boxes.iter().filter(|all| all.half != Vec3::zeros()).count();
                // A near box contains a place within its diagonal.
                let diagonal = other.shape.ball.1;
                let wider = within(limit + diagonal);
                for along in (0..10).map(|_| vector(&mut rng, 1.0).normalize()).filter(|_| !boxes.is_empty()) {
                    let farthest = |all: &[&Vec3]| all.iter().map(|p| p.dot(&along)).fold(f64::NEG_INFINITY, f64::max);
                    let single =
                        many.support(&[Aabb { center: Vec3::zeros(), half: Vec3::zeros() }], &along).dot(&along);
                    let reach = many.support(&boxes, &along).dot(&along) - single;
                    assert!(
                        reach >= farthest(&within(limit)) - 1e-6 && reach <= farthest(&wider) + diagonal,
                        "{reach}"
                    );
                }
            }
        }
    }
    assert!(boxed > 100, "{boxed}");
}

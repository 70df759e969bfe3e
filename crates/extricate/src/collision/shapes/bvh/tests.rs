//! Trees contain every triangle once, in all boxes above it; tests of eight lanes equal tests of
//! one.

use crate::collision::narrow_phase::triangle::{self, Triangle, closest_on_triangle};
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::bvh::block::Block;
use crate::collision::shapes::bvh::*;
use crate::math::{LANES, Pose, Vec3};
use pulp::{Arch, Scalar, Simd, WithSimd};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(rng: &mut ChaCha8Rng, scale: f64) -> Vec3 {
    Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5))
}

fn soup(rng: &mut ChaCha8Rng, count: usize, size: f64) -> Vec<[Vec3; 3]> {
    (0..count)
        .map(|_| {
            let origin = random(rng, 1.0);
            [0; 3].map(|_| origin + random(rng, size))
        })
        .collect()
}

struct Gaps<'a>(&'a Boxes, &'a View, &'a Cuboid, f32);

impl WithSimd for Gaps<'_> {
    type Output = (u32, Lanes, Lanes);

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self(boxes, view, other, limit) = self;
        let (near, gaps) = boxes.near(simd, view, &view.see(other, limit));
        (near, gaps, boxes.lower_bounds(simd, view, &view.see(other, 0.0)))
    }
}

struct Near<'a>(&'a Block, &'a Probe, f64);

impl WithSimd for Near<'_> {
    type Output = (u32, u32);

    fn with_simd<S: Simd>(self, simd: S) -> (u32, u32) {
        let Self(block, probe, limit) = self;
        (block.near(simd, &probe.triangle, limit, 0xff).0, probe.near(simd, &block.boxes))
    }
}

struct Met<'a>(&'a Boxes, [f32; 3], [f32; 3]);

impl WithSimd for Met<'_> {
    type Output = u32;

    fn with_simd<S: Simd>(self, simd: S) -> u32 {
        self.0.met_by(simd, &self.1, &self.2, 1e-5)
    }
}

/// Whether `cuboid` contains `point`, to the rounding of `f32`.
fn holds(cuboid: &Cuboid, point: &Vec3) -> bool {
    (0..3).all(|i| (point[i] - f64::from(cuboid.center[i])).abs() <= f64::from(cuboid.half[i]))
}

#[test]
fn every_triangle_is_in_one_block_and_in_all_boxes_above() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let same = soup(&mut rng, 1, 0.1)[0];
    let groups = [soup(&mut rng, 3000, 0.1), vec![same; 500], soup(&mut rng, 7, 0.1), vec![same; 1]];
    let tree = build(&groups);
    let mut all = 0;
    for (index, group) in tree.groups.iter().enumerate() {
        let mut found: Vec<[Vec3; 3]> = Vec::new();
        let mut stack = vec![(group.root, *tree.bounds_of(group.root))];
        while let Some((at, bounds)) = stack.pop() {
            if at.is_block() {
                let block = &tree.blocks[at.index()];
                assert!(group.blocks.contains(&at.index()) && block.group == index as u32);
                for lane in 0..block.len() {
                    let triangle = block.triangle(lane);
                    let number = (at.index() * LANES + lane) as u32;
                    assert_eq!(tree.triangle(number).unwrap().points, triangle.points);
                    assert!(triangle.points.iter().all(|p| holds(&bounds, p) && holds(&block.bounds, p)));
                    assert!(triangle.points.iter().all(|p| holds(&block.boxes.get(lane), p)));
                    found.push(triangle.points);
                }
                continue;
            }
            let node = &tree.nodes[at.index()];
            for lane in 0..LANES {
                let child = node.boxes.get(lane);
                if child.half[0] >= 0.0 {
                    assert!((0..3).all(|i| child.center[i].abs() < 2.0 && child.half[i] < 2.0));
                    stack.push((node.children[lane], child));
                }
            }
        }
        let key = |t: &[Vec3; 3]| [t[0].x, t[1].y, t[2].z].map(f64::to_bits);
        let mut expected = groups[index].clone();
        expected.sort_by_key(key);
        found.sort_by_key(key);
        assert_eq!(found, expected);
        all += found.len();
    }
    assert_eq!(all, tree.triangles(0..tree.blocks.len()).count());
    let full = groups[0].len().div_ceil(LANES);
    assert!(tree.groups[0].blocks.len() < full + full / 8, "{} blocks, {full} full ones", tree.groups[0].blocks.len());
}

#[test]
fn closest_point_equals_a_scan() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for scale in [1e-6, 1.0, 1e6] {
        let group: Vec<[Vec3; 3]> = soup(&mut rng, 400, 0.2).iter().map(|t| t.map(|p| p * scale)).collect();
        let tree = build(&[group]);
        let mut stack = Vec::new();
        for _ in 0..300 {
            let p = random(&mut rng, 3.0 * scale);
            let all = tree.triangles(0..tree.blocks.len());
            let expected = all.map(|t| (closest_on_triangle(&t, &p) - p).norm_squared()).fold(f64::INFINITY, f64::min);
            let found = tree.closest_point(tree.root, &p, f64::INFINITY, 0.0, &mut stack).unwrap();
            assert_eq!(found.squared, expected);
            assert_eq!((found.point - p).norm_squared(), expected);
            assert!(tree.closest_point(tree.root, &p, expected, 0.0, &mut stack).is_none());
        }
    }
}

/// Least distance of random points of two boxes, many of them at corners; `pose` moves the second
/// box.
fn sampled_distance(a: &Cuboid, b: &Cuboid, pose: &Pose, rng: &mut ChaCha8Rng) -> f64 {
    let mut within = |cuboid: &Cuboid| {
        Vec3::from_fn(|i, _| {
            let side = (3.0 * (rng.random::<f64>() - 0.5)).clamp(-1.0, 1.0);
            f64::from(cuboid.center[i]) + side * f64::from(cuboid.half[i])
        })
    };
    let cloud: Vec<Vec3> = (0..40).map(|_| pose.point(&within(b))).collect();
    (0..40).map(|_| within(a)).flat_map(|p| cloud.iter().map(move |q| (p - q).norm())).fold(f64::INFINITY, f64::min)
}

#[test]
fn boxes_never_part_what_is_near() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let (mut parted, mut bounded) = (0, 0);
    for round in 0..1500 {
        let scale = [1e-6, 1.0, 1e6][round % 3];
        let mut cuboid = |size: f64| {
            let (center, half) = (random(&mut rng, 2.0 * scale), random(&mut rng, size * scale).abs());
            Aabb::between(&(center - half), &(center + half))
        };
        let all: Vec<Aabb> = (0..7).map(|_| cuboid(1.0)).collect();
        let other = Cuboid::around(&cuboid(1.0));
        let boxes = Boxes::new(&all);
        let pose = Pose::from_xyz_rpy(random(&mut rng, 3.0 * scale).into(), random(&mut rng, 6.0).into());
        let own = Cuboid::around(&Aabb::between(&Vec3::repeat(-2.0 * scale), &Vec3::repeat(2.0 * scale)));
        let view = View::new(&pose, &own, &other);
        let limit = [0.0, 0.1 * scale][round % 2];
        let (near, gaps, bounds) = Arch::new().dispatch(Gaps(&boxes, &view, &other, limit as f32));
        let scalar = Gaps(&boxes, &view, &other, limit as f32).with_simd(Scalar::new());
        assert_eq!((near, gaps, bounds), scalar, "the same bits on every processor");
        assert_eq!(near >> 7, 0, "nothing is in the last lane");
        for (lane, bound) in bounds.iter().enumerate().take(7) {
            let distance = sampled_distance(&boxes.get(lane), &other, &pose, &mut rng);
            assert!(near >> lane & 1 == 1 || distance > limit);
            assert!(f64::from(*bound) <= distance, "{bound} {distance}");
            parted += u32::from(near >> lane & 1 == 0);
            bounded += u32::from(*bound > 0.0);
        }
    }
    assert!(parted > 3000 && bounded > 3000, "{parted} {bounded}");
}

#[test]
fn blocks_part_only_what_is_apart_and_nearly_all_of_that() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut passed, mut close, mut parted) = (0, 0, 0);
    for round in 0..4000 {
        let mut group = soup(&mut rng, 8, 0.6);
        match round % 5 {
            0 => group.iter_mut().flatten().for_each(|p| p.z = 0.25), // coplanar
            1 => group.iter_mut().for_each(|t| t[2] = t[0] + (t[1] - t[0]) * 0.3), // segments
            2 => group.iter_mut().for_each(|t| *t = [t[0]; 3]),       // points
            _ => {}
        }
        let mut points = soup(&mut rng, 1, 0.6)[0];
        if round % 10 < 2 {
            points.iter_mut().for_each(|p| p.z = 0.25);
        }
        let block = Block::new(&group, 0);
        let limit = [0.0, 1e-4, 0.05][round % 3];
        let probe = Probe::new(&Triangle::new(points), &Pose::identity(), limit as f32, 1e-5);
        let (near, wide) = Arch::new().dispatch(Near(&block, &probe, limit));
        assert_eq!((near, wide), Near(&block, &probe, limit).with_simd(Scalar::new()));
        for lane in 0..LANES {
            let is_near = triangle::nearer(&block.triangle(lane), &probe.triangle, limit);
            assert!(!is_near || (near & wide) >> lane & 1 == 1, "{round} {lane}");
            if round % 5 > 2 {
                passed += near >> lane & 1;
                close += u32::from(is_near);
            }
        }
        let (some, gaps) = block.near(Scalar::new(), &probe.triangle, limit, 0b101);
        assert_eq!(near & 0b101, some);
        for (lane, gap) in gaps.into_iter().enumerate() {
            assert!(gap <= 0.0 || triangle::closest(&block.triangle(lane), &probe.triangle, gap * gap).is_none());
            parted += u32::from(gap > 0.0);
        }
    }
    assert!(close > 300 && passed < close + close / 4, "{passed} pass, {close} are near");
    assert!(parted > 3000, "{parted}");
}

#[test]
fn rays_meet_the_boxes_that_they_cross() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for _ in 0..500 {
        let all: Vec<Aabb> = soup(&mut rng, 8, 0.5).iter().map(|t| Aabb::around(t.iter())).collect();
        let (boxes, origin, direction) = (Boxes::new(&all), random(&mut rng, 2.0), random(&mut rng, 1.0));
        let place = [origin.x as f32, origin.y as f32, origin.z as f32];
        let inverse = [0, 1, 2].map(|i| (1.0 / direction[i]) as f32);
        let met = Arch::new().dispatch(Met(&boxes, place, inverse));
        assert_eq!(met, Met(&boxes, place, inverse).with_simd(Scalar::new()));
        for (lane, bounds) in all.iter().enumerate() {
            let crosses = (0..4000).any(|k| bounds.contains(&(origin + direction * (f64::from(k) * 2e-3))));
            assert!(!crosses || met >> lane & 1 == 1);
        }
    }
}

//! Distances known by hand.

use crate::collision::convex_distance::tests::*;
use std::f64::consts::FRAC_PI_2;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(Vec3::new(x, y, z))
}

fn turned(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    Pose::from_xyz_rpy(xyz, rpy)
}

fn sphere(radius: f64) -> ConvexShape {
    rounded(ConvexCore::Point, radius)
}

fn cuboid(x: f64, y: f64, z: f64) -> ConvexShape {
    rounded(ConvexCore::Box { half_extents: Vec3::new(x, y, z) }, 0.0)
}

fn capsule(half_length: f64, radius: f64) -> ConvexShape {
    rounded(ConvexCore::Segment { half_length }, radius)
}

fn cylinder(radius: f64, half_length: f64) -> ConvexShape {
    rounded(ConvexCore::Cylinder { radius, half_length }, 0.0)
}

/// Checks the distance, both ways round, and that the witness points and bounds belong to it.
#[track_caller]
fn assert_distance(first: &ConvexShape, pose_first: &Pose, second: &ConvexShape, pose_second: &Pose, expected: f64) {
    for [(a, pose_a), (b, pose_b)] in
        [[(first, pose_first), (second, pose_second)], [(second, pose_second), (first, pose_first)]]
    {
        let found = separation(a, pose_a, b, pose_b, f64::INFINITY).unwrap();
        assert!((found.distance - expected).abs() < 1e-9, "{expected} {found:?}");
        assert!(found.depth_lower <= -expected + 1e-12 && found.depth_lower > -expected - 1e-8, "{expected} {found:?}");
        let between = found.point_first - found.point_second;
        assert!((between - found.normal * found.distance).norm() < 1e-7, "{found:?}");
        assert!((found.normal.norm() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn spheres() {
    let (a, b) = (sphere(0.3), sphere(0.5));
    assert_distance(&a, &at(1.0, 2.0, 2.0), &b, &at(0.0, 0.0, 0.0), 3.0 - 0.8);
    assert_distance(&a, &at(0.1, 0.0, 0.0), &b, &at(0.0, 0.0, 0.0), 0.1 - 0.8);
    assert_distance(&a, &at(0.1, 0.2, 0.3), &b, &at(0.1, 0.2, 0.3), -0.8);
    assert_distance(&a, &at(0.8, 0.0, 0.0), &b, &at(0.0, 0.0, 0.0), 0.0);
}

#[test]
fn sphere_and_box() {
    let (ball, block) = (sphere(0.1), cuboid(1.0, 2.0, 3.0));
    let pose = turned([0.5, -0.5, 0.25], [0.3, 0.2, -0.4]);
    for (local, expected) in [
        ([1.5, 0.3, 0.2], 0.5 - 0.1),
        ([1.3, 2.4, 0.0], 0.5 - 0.1),
        ([2.0, 4.0, 5.0], 3.0 - 0.1),
        ([0.9, 0.3, 0.2], -0.1 - 0.1),
        ([0.0, 0.0, 2.8], -0.2 - 0.1),
        ([0.0, 0.0, 0.0], -1.0 - 0.1),
        ([1.0, 0.0, 0.0], -0.1),
        ([1.0, 2.0, 3.0], -0.1),
        ([1.0 + 1e-10, 2.0, 0.0], 1e-10 - 0.1),
    ] {
        assert_distance(&ball, &Pose::translation(pose.point(&local.into())), &block, &pose, expected);
    }
}

#[test]
fn capsules() {
    let (a, b) = (capsule(1.0, 0.1), capsule(0.5, 0.2));
    let upright = at(0.0, 0.0, 0.0);
    assert_distance(&a, &upright, &b, &at(0.6, 0.0, 0.7), 0.3);
    assert_distance(&a, &upright, &b, &turned([0.0, 0.9, 0.1], [0.0, FRAC_PI_2, 0.0]), 0.6);
    assert_distance(&a, &upright, &b, &at(0.0, 3.0, 5.5), 5.0 - 0.3);
    // Cores that cross, lie in one another, or only touch at an end.
    assert_distance(&a, &upright, &b, &turned([0.0, 0.0, 0.1], [0.0, FRAC_PI_2, 0.0]), -0.3);
    assert_distance(&a, &upright, &b, &at(0.0, 0.0, 0.2), -0.3);
    assert_distance(&a, &upright, &b, &at(0.0, 0.0, 1.5), -0.3);
    assert_distance(&a, &upright, &b, &at(0.0, 0.0, 1.9), 0.1);
}

#[test]
fn boxes_with_parallel_faces() {
    let (a, b) = (cuboid(0.5, 0.5, 0.5), cuboid(1.0, 2.0, 0.25));
    let origin = Pose::identity();
    assert_distance(&a, &at(1.6, 0.3, 0.1), &b, &origin, 0.1);
    assert_distance(&a, &at(1.8, 2.9, 0.0), &b, &origin, 0.5);
    assert_distance(&a, &at(0.0, 0.0, 0.0), &b, &origin, -0.75);
    assert_distance(&a, &at(1.5, 2.5, 0.75), &b, &origin, 0.0);
    for gap in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0, -1e-12, -1e-10, -1e-8, -1e-6, -1e-4, -1e-2] {
        assert_distance(&a, &at(0.2, -0.3, 0.75 + gap), &b, &origin, gap);
        assert_distance(&a, &at(0.5, 1.5, 0.75 + gap), &b, &origin, gap);
        // An edge on a face, and an edge across an edge.
        let edge = turned([0.1, 0.2, 0.25 + 0.5_f64.sqrt() + gap], [FRAC_PI_2 / 2.0, 0.0, 0.0]);
        assert_distance(&a, &edge, &b, &origin, gap);
        let other = turned([0.0, 0.0, -(0.5_f64.sqrt())], [0.0, FRAC_PI_2 / 2.0, 0.0]);
        let one = turned([0.0, 0.0, 0.5_f64.sqrt() + gap], [FRAC_PI_2 / 2.0, 0.0, 0.0]);
        assert_distance(&a, &one, &a, &other, gap);
    }
}

#[test]
fn cylinders() {
    let (a, ground) = (cylinder(0.2, 0.5), cuboid(2.0, 2.0, 1.0));
    let below = at(0.0, 0.0, -1.0);
    for tilt in [0.0_f64, 1e-9, 1e-4, 0.3, 1.0, FRAC_PI_2 - 1e-7, FRAC_PI_2] {
        for gap in [0.3, 1e-4, 1e-9, 0.0, -1e-9, -1e-4, -0.05] {
            let height = 0.2 * tilt.sin() + 0.5 * tilt.cos() + gap;
            assert_distance(&a, &turned([0.3, -0.2, height], [tilt, 0.0, 0.7]), &ground, &below, gap);
        }
    }
    let b = cylinder(0.3, 0.4);
    let origin = Pose::identity();
    assert_distance(&a, &at(0.6, 0.8, 0.1), &b, &origin, 0.5);
    assert_distance(&a, &at(0.24, 0.32, 0.1), &b, &origin, -0.1);
    assert_distance(&a, &at(0.1, 0.0, 0.95), &b, &origin, 0.05);
    assert_distance(&a, &at(0.1, 0.0, 0.85), &b, &origin, -0.05);
    assert_distance(&a, &turned([0.0, 0.7, 0.0], [0.0, FRAC_PI_2, 0.0]), &b, &origin, 0.2);
    assert_distance(&a, &turned([0.0, 0.45, 0.0], [0.0, FRAC_PI_2, 0.0]), &b, &origin, -0.05);
    // A ball beside the rim.
    assert_distance(&sphere(0.1), &at(0.6 * 0.6, 0.6 * 0.8, 0.8), &b, &origin, 0.5 - 0.1);
}

#[test]
fn triangles() {
    let flat = rounded(ConvexCore::Triangle([Vec3::zeros(), Vec3::x(), Vec3::y()]), 0.0);
    let origin = Pose::identity();
    assert_distance(&flat, &at(0.1, 0.1, 0.3), &flat, &origin, 0.3);
    assert_distance(&flat, &at(0.1, 0.1, 0.0), &flat, &origin, 0.0);
    assert_distance(&flat, &at(2.0, 0.0, 0.0), &flat, &origin, 1.0);
    assert_distance(&flat, &turned([0.2, 0.2, 1e-7], [0.0, -FRAC_PI_2, 0.0]), &flat, &origin, 1e-7);
    // Standing on edge, pushed through by 0.1.
    assert_distance(&flat, &turned([0.2, 0.2, -0.1], [0.0, -FRAC_PI_2, 0.0]), &flat, &origin, -0.1);
}

//! Distances against closed forms, slow twins and their own guarantees.

mod closed_forms;
mod guarantees;
mod slow_twin;

use crate::collision::convex_distance::*;
use crate::collision::shapes::convex::{ConvexCore, ConvexShape, HullPoints};
use crate::math::{Pose, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn rounded(core: ConvexCore, radius: f64) -> ConvexShape {
    ConvexShape { core, radius }
}

fn random_vector(rng: &mut ChaCha8Rng) -> Vec3 {
    Vec3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0)
}

fn random_pose(rng: &mut ChaCha8Rng, reach: f64) -> Pose {
    let angles = random_vector(rng) * std::f64::consts::PI;
    let mut pose = Pose::from_xyz_rpy([0.0; 3], angles.into());
    if rng.random::<f64>() < 0.3 {
        // Faces and edges exactly parallel.
        let quarter = random_vector(rng).map(|x| (2.0 * x).round() * std::f64::consts::FRAC_PI_2);
        pose = Pose::from_xyz_rpy([0.0; 3], quarter.into());
        pose.rotation.iter_mut().for_each(|entry| *entry = entry.round());
    }
    pose.translation = random_vector(rng) * reach;
    pose
}

/// A polytope within a unit cube or so: random, with coplanar and duplicate points, flat, thin, or
/// lower dimensional.
fn random_polytope(rng: &mut ChaCha8Rng) -> ConvexCore {
    let points = |rng: &mut ChaCha8Rng, count: usize| (0..count).map(|_| random_vector(rng) * 0.5).collect::<Vec<_>>();
    match (rng.random::<f64>() * 10.0) as usize {
        0 => ConvexCore::Point,
        1 => ConvexCore::Segment { half_length: 0.5 * rng.random::<f64>() },
        2 => ConvexCore::Box { half_extents: random_vector(rng).abs() * 0.5 },
        3 => ConvexCore::Triangle([0; 3].map(|_| random_vector(rng) * 0.5)),
        4 => {
            let [a, b] = [random_vector(rng) * 0.5, random_vector(rng) * 0.5];
            let width = 10.0_f64.powf(-1.0 - 9.0 * rng.random::<f64>());
            ConvexCore::Triangle([a, b, a + (b - a) * rng.random::<f64>() + random_vector(rng) * width])
        }
        5 => {
            let mut lattice = points(rng, 9);
            lattice.iter_mut().for_each(|p| *p = p.map(|x| (x * 4.0).round() / 4.0));
            lattice.push(lattice[0]);
            ConvexCore::Hull(HullPoints::new(&lattice))
        }
        6 => {
            let mut flat = points(rng, 6);
            flat.iter_mut().for_each(|p| p.z = 0.1);
            ConvexCore::Hull(HullPoints::new(&flat))
        }
        7 => {
            let top = [0; 3].map(|_| random_vector(rng) * 0.5);
            let lowest = top.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            ConvexCore::Prism { top, bottom: lowest - 0.01 - rng.random::<f64>() }
        }
        _ => ConvexCore::Hull(HullPoints::new(&points(rng, 8))),
    }
}

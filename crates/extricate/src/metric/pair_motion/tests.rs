//! Compares Taylor's formula with the motion of points.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cspace::sampling::uniform;
use crate::kinematics::forward;
use crate::math::LANES;
use crate::metric::pair_motion::*;
use crate::scene::builtin;

/// Compares the growth of `n . (a - b)` along a geodesic, as seen from the common frame, with its
/// Taylor polynomial and the bounds on derivatives.
#[test]
fn points_move_as_derivatives_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let (mut seen, mut closest) = (0, f64::INFINITY);
    for name in builtin::NAMES {
        let scene = Arc::new(builtin::scene(name).unwrap());
        let metric = Metric::of_kind(scene.clone(), MetricKind::Joint);
        let space = &scene.space;
        let [mut q, mut to] = [(); 2].map(|()| vec![0.0; space.nq()]);
        let (mut poses, mut after, mut motion) = (Vec::new(), Vec::new(), PairMotion::default());
        for round in 0..300 {
            uniform(space, &mut rng, &mut q);
            forward(&scene, &q, &mut poses);
            let frames = [0, 0].map(|_: usize| rng.random_range(0..scene.frames.len()));
            let mut unit = || Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5);
            let (a, b, n) = (unit() * 2.0, unit() * 2.0, unit().normalize());
            metric.pair_motion(&poses, frames, |_| false, &mut motion);
            metric.place_points(&poses, [&a, &b], &mut motion);
            let mut tangent: Vec<f64> = (0..space.nv()).map(|_| rng.random::<f64>() - 0.5).collect();
            let length = [1e-3, 0.1, 0.4, 1.0][round % 4];
            let norm = space.factors().iter().map(|f| f.tangents().map(|v| f.weight * tangent[v].powi(2)).sum::<f64>());
            let norm = norm.sum::<f64>().sqrt();
            tangent.iter_mut().for_each(|t| *t *= length / norm);
            space.integrate(&q, &tangent, &mut to);
            // Limits may have stopped some joints.
            space.difference(&q, &to, &mut tangent);
            let length = metric.distance(&q, &to);
            forward(&scene, &to, &mut after);
            let weight = |v: usize| space.factors().iter().find(|f| f.tangents().contains(&v)).unwrap().weight.sqrt();
            let e: Vec<f64> = motion.coordinates().iter().map(|v| tangent[*v] * weight(*v)).collect();
            let common = common_frame(&scene, frames);
            let local = |poses: &[Pose], frame: usize, p: &Vec3| {
                poses[common].inverse_point(&after_point(&poses[frame], &poses_of(&scene, &q)[frame], p))
            };
            let n_common = poses[common].inverse_vector(&n);
            let gap = |poses: &[Pose]| n_common.dot(&(local(poses, frames[0], &a) - local(poses, frames[1], &b)));
            let grown = gap(&after) - gap(&poses);
            let g: Vec<f64> = motion.columns().iter().map(|column| n.dot(column)).collect();
            let mut h = Vec::new();
            motion.hessian(&[[n.x], [n.y], [n.z]], &mut h);
            let linear: f64 = g.iter().zip(&e).map(|(g, e)| g * e).sum();
            let width = e.len();
            let bent: f64 = (0..width * width).map(|i| h[i][0] * e[i / width] * e[i % width]).sum();
            let [second, third] = motion.derivatives(length);
            let (second, third) = (second * length.powi(2) / 2.0, third * length.powi(3) / 6.0);
            let rest = grown - linear - 0.5 * bent;
            assert!(bent.abs() <= 2.0 * second * (1.0 + 1e-9) + 1e-12, "{name} {frames:?}: {bent} {second}");
            assert!(rest.abs() <= third * (1.0 + 1e-9) + 1e-12, "{name} {frames:?}: {rest} {third} at {length}");
            if third > 1e-3 {
                seen += 1;
                closest = closest.min(third / rest.abs());
            }
        }
    }
    assert!(seen > 300 && closest < 20.0, "{seen} {closest}");
}

/// Lanes give each pair of points the same result as a single evaluation, in every built-in scene.
#[test]
fn lanes_tell_what_single_pairs_do() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let (mut seen, mut motions) = (0, PairMotions::default());
    for name in builtin::NAMES {
        let scene = Arc::new(builtin::scene(name).unwrap());
        let metric = Metric::of_kind(scene.clone(), MetricKind::Joint);
        let (mut q, mut motion) = (vec![0.0; scene.space.nq()], PairMotion::default());
        for round in 0..200 {
            uniform(&scene.space, &mut rng, &mut q);
            let poses = poses_of(&scene, &q);
            let frames = [0, 0].map(|_: usize| rng.random_range(0..scene.frames.len()));
            metric.pair_motion(&poses, frames, |_| false, &mut motion);
            let mut unit = || Vec3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0);
            let points: Vec<[Vec3; 2]> = (0..1 + round % LANES).map(|_| [unit(), unit()]).collect();
            let distance = [0.0, 0.3, 1.5][round % 3];
            motion.place_all(&points, distance, &mut motions);
            for (lane, [a, b]) in points.iter().enumerate() {
                metric.place_points(&poses, [a, b], &mut motion);
                let [second, third] = motion.derivatives(distance);
                let near = |x: f64, y: f64| assert!((x - y).abs() <= 1e-12 * (1.0 + y.abs()), "{name}: {x} {y}");
                near(motions.second[lane], second);
                near(motions.third[lane], third);
                for (of_lanes, column) in motions.columns.iter().zip(motion.columns()) {
                    (0..3).for_each(|axis| near(of_lanes[axis][lane], column[axis]));
                }
                seen += usize::from(second > 0.0);
            }
        }
    }
    assert!(seen > 2_000, "{seen}");
}

fn poses_of(scene: &Scene, q: &[f64]) -> Vec<Pose> {
    let mut poses = Vec::new();
    forward(scene, q, &mut poses);
    poses
}

/// Moves a point of the world with a frame from pose `before` to `pose`.
fn after_point(pose: &Pose, before: &Pose, p: &Vec3) -> Vec3 {
    pose.point(&before.inverse_point(p))
}

//! Reaches in lanes against reaches computed one after another.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};

use super::*;
use crate::cspace::sampling::uniform;
use crate::kinematics::forward;
use crate::math::linear_algebra::{cholesky_solve, dot, forward_solve};
use crate::metric::Metric;
use crate::scene::{MetricKind, builtin};

/// Covers zero coefficients, needs of zero, and roots beyond the ceiling.
#[test]
fn roots_in_lanes_are_those_of_one() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let (mut inside, mut ends) = (0, 0);
    for _ in 0..2_000 {
        let mut number = |most: f64| if rng.random::<f64>() < 0.1 { 0.0 } else { most * rng.random::<f64>().powi(3) };
        let [c, p, q, s] = [0.01, 2.0, 5.0, 9.0].map(|most| lanes(|_| number(most)));
        let needed = lanes(|k| number(1.0) - 0.02 * (k % 2) as f64);
        let ceiling = 0.01 + number(2.0);
        for (k, found) in roots([&c, &p, &q, &s], &needed, ceiling).into_iter().enumerate() {
            let expected = root([c[k], p[k], q[k], s[k]], needed[k], ceiling);
            assert!((found - expected).abs() <= 1e-10 * expected, "{found} {expected}");
            let value = c[k] + found * (p[k] + found * (q[k] + found * s[k]));
            assert!(found == 0.0 || value <= needed[k], "{value} {}", needed[k]);
            let is_end = found == 0.0 || found == ceiling;
            (inside, ends) = (inside + usize::from(!is_end), ends + usize::from(is_end));
        }
    }
    assert!(inside > 5_000 && ends > 2_000, "{inside} {ends}");
}

/// Uses a random pair of bodies of every built-in scene, random points and random directions.
#[test]
fn corners_in_lanes_reach_what_one_does() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let (mut seen, mut scratch, mut motion) = (0, ReachScratch::default(), PairMotion::default());
    for name in builtin::NAMES {
        let scene = Arc::new(builtin::scene(name).unwrap());
        let metric = Metric::of_kind(scene.clone(), MetricKind::Joint);
        let (mut q, mut poses) = (vec![0.0; scene.space.nq()], Vec::new());
        for round in 0..300 {
            uniform(&scene.space, &mut rng, &mut q);
            forward(&scene, &q, &mut poses);
            let frames = [0, 0].map(|_: usize| rng.random_range(0..scene.frames.len()));
            let mut unit = || Vec3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0);
            let (a, b, directions) = (unit(), unit(), [unit(), unit(), unit()]);
            let needs = directions.map(|n| (n.normalize(), 0.3 * n.norm_squared()));
            metric.pair_motion(&poses, frames, |_| false, &mut motion);
            metric.place_points(&poses, [&a, &b], &mut motion);
            let ceiling = [0.1, 0.5, 2.0][round % 3];
            let curvature = Curvature::of(&mut motion, ceiling);
            let found = least_reach(&motion, &curvature, &needs, (ceiling, ceiling), &mut scratch);
            let single = needs.iter().map(|(n, needed)| reach(&motion, &curvature, n, *needed, ceiling, ceiling));
            let expected = single.fold(ceiling, f64::min);
            assert!((found - expected).abs() <= 1e-12 * (1.0 + expected), "{name} {frames:?}: {found} {expected}");
            seen += usize::from(found < ceiling);
        }
    }
    assert!(seen > 500, "{seen}");
}

/// Slow twin: the reach of one corner.
fn reach(motion: &PairMotion, curvature: &Curvature, n: &Vec3, needed: f64, enough: f64, ceiling: f64) -> f64 {
    if needed <= 0.0 {
        return 0.0;
    }
    let gradient: Vec<f64> = motion.columns().iter().map(|column| n.dot(column)).collect();
    let slope = dot(&gradient, &gradient).sqrt() + ROUNDING * curvature.first;
    let third = curvature.third;
    let mut best = root([0.0, slope, 0.5 * curvature.second, third], needed, ceiling);
    if best >= enough.min(ceiling) {
        return best;
    }
    let mut hessian = Vec::new();
    motion.hessian(&[[n.x], [n.y], [n.z]], &mut hessian);
    let hessian = hessian.as_flattened();
    let width = gradient.len();
    // The second derivative along the gradient, near which the largest value lies.
    let along = hessian.chunks_exact(width).zip(&gradient).map(|(row, g)| g * dot(row, &gradient)).sum::<f64>()
        / (slope * slope).max(f64::MIN_POSITIVE);
    let most = curvature.second * (1.0 + 1e-6) + f64::MIN_POSITIVE;
    let likely = root([0.0, slope, 0.5 * along.max(0.0), third], needed, ceiling);
    let mut multiplier = slope / likely + along;
    for _ in 0..MAX_MULTIPLIERS {
        // A multiplier is not negative, since it weighs the longer distance.
        multiplier = multiplier.max(1e-3 * most);
        let mut factor: Vec<f64> = hessian.iter().map(|entry| -entry).collect();
        // Slightly less than the multiplier, by far more than the rounding of the factor.
        (0..width).for_each(|k| factor[k * width + k] += multiplier * (1.0 - 1e-9));
        if !is_definite(&mut factor, width, 1e-4 * multiplier) {
            multiplier = (2.0 * multiplier.max(0.25 * most)).min(most + multiplier.abs());
            continue;
        }
        let mut solved = gradient.clone();
        cholesky_solve(&factor, width, &mut solved);
        let constant = 0.5 * dot(&gradient, &solved) * (1.0 + 1e-8);
        let found = root([constant, 0.0, 0.5 * multiplier, third], needed, ceiling);
        best = best.max(found);
        if best >= enough.min(ceiling) {
            break;
        }
        let length = dot(&solved, &solved).sqrt();
        let off = (length - found) / found.max(1e-12 * length);
        if found <= 0.0 || off.abs() < 0.02 {
            break;
        }
        forward_solve(&factor, width, &mut solved);
        multiplier += off * length * length / dot(&solved, &solved);
    }
    best
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; returns `false` if a
/// pivot is below `least`.
fn is_definite(m: &mut [f64], n: usize, least: f64) -> bool {
    for j in 0..n {
        for i in j..n {
            let sum = m[i * n + j] - dot(&m[i * n..i * n + j], &m[j * n..j * n + j]);
            if i == j && (sum <= least || sum.is_nan()) {
                return false;
            }
            m[i * n + j] = if i == j { sum.sqrt() } else { sum / m[j * n + j] };
        }
    }
    true
}

//! How far a configuration has to go before two points have parted along a direction.
//!
//! Within distance `r`, `n . (a - b)` grows by at most the largest value of `g . e + e' H e / 2`
//! over `|e| <= r`, and `K r^3 / 6`, see [`crate::metric::pair_motion`]. For every `m` with `P = m
//! I - H` positive definite,
//!
//! `g . e + e' H e / 2 = (g . e - e' P e / 2) + m |e|^2 / 2 <= g' P^-1 g / 2 + m r^2 / 2`
//!
//! which is the Lagrangian dual of the trust-region problem: with the best `m` nothing is lost.
//!
//! # Source
//! J. J. Moré and D. C. Sorensen, "Computing a trust region step", SIAM J. Sci. Stat. Comput. 4,
//! 1983, doi:10.1137/0904038, for the search for `m`.

use crate::math::Vec3;
use crate::math::linear_algebra::{cholesky_solve, dot, forward_solve};
use crate::metric::pair_motion::PairMotion;

/// Memory that reaches reuse.
#[derive(Debug, Clone, Default)]
pub struct ReachScratch {
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    factor: Vec<f64>,
    solved: Vec<f64>,
}

/// Bounds on derivatives in every direction, of the points that are looked at.
#[derive(Debug, Clone, Copy, Default)]
pub struct Curvature {
    /// On second ones here.
    pub second: f64,
    /// On third ones up to the ceiling, over 6.
    pub third: f64,
    /// Largest of all gradients, for what rounding adds to them.
    pub first: f64,
}

/// Share by which bounds are lowered for rounding: that of some hundred operations, many times
/// over.
const ROUNDING: f64 = 1e-12;
/// How many multipliers are tried.
const TRIES: usize = 3;

impl Curvature {
    /// Of the points that `motion` was placed at, within `ceiling`.
    pub fn of(motion: &mut PairMotion, ceiling: f64) -> Self {
        let first = motion.columns().iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        Self { second: motion.second(), third: motion.third(ceiling) / 6.0, first }
    }
}

/// A distance (metric units), at most `ceiling`, within which `n . (a - b)` grows by less than
/// `needed` \[m\]. Stops refining once it reaches `enough`.
///
/// # Guarantee
/// Proved. At least as far as bounds on all second derivatives tell.
pub fn reach(
    motion: &PairMotion,
    curvature: &Curvature,
    n: &Vec3,
    needed: f64,
    (enough, ceiling): (f64, f64),
    scratch: &mut ReachScratch,
) -> f64 {
    if needed <= 0.0 {
        return 0.0;
    }
    if motion.rate() > 0.0 {
        return (needed / motion.rate() * (1.0 - ROUNDING)).min(ceiling);
    }
    let ReachScratch { gradient, hessian, factor, solved } = scratch;
    gradient.clear();
    gradient.extend(motion.columns().iter().map(|column| n.dot(column)));
    let slope = dot(gradient, gradient).sqrt() + ROUNDING * curvature.first;
    let third = curvature.third;
    let mut best = root([0.0, slope, 0.5 * curvature.second, third], needed, ceiling);
    if best >= enough.min(ceiling) {
        return best;
    }
    motion.hessian(n, hessian);
    let width = gradient.len();
    // What it is along the gradient, where the largest value is nearly.
    let along = hessian.chunks_exact(width).zip(&*gradient).map(|(row, g)| g * dot(row, gradient)).sum::<f64>()
        / (slope * slope).max(f64::MIN_POSITIVE);
    let most = curvature.second * (1.0 + 1e-6) + f64::MIN_POSITIVE;
    let likely = root([0.0, slope, 0.5 * along.max(0.0), third], needed, ceiling);
    let mut multiplier = slope / likely + along;
    for _ in 0..TRIES {
        // Not negative: it is what a longer way counts.
        multiplier = multiplier.max(1e-3 * most);
        factor.clear();
        factor.extend(hessian.iter().map(|entry| -entry));
        // A little less than the multiplier: what rounding does to the factor is far below.
        (0..width).for_each(|k| factor[k * width + k] += multiplier * (1.0 - 1e-9));
        if !is_definite(factor, width, 1e-4 * multiplier) {
            multiplier = (2.0 * multiplier.max(0.25 * most)).min(most + multiplier.abs());
            continue;
        }
        solved.clear();
        solved.extend_from_slice(gradient);
        cholesky_solve(factor, width, solved);
        let constant = 0.5 * dot(gradient, solved) * (1.0 + 1e-8);
        let found = root([constant, 0.0, 0.5 * multiplier, third], needed, ceiling);
        best = best.max(found);
        if best >= enough.min(ceiling) {
            break;
        }
        let length = dot(solved, solved).sqrt();
        let off = (length - found) / found.max(1e-12 * length);
        if found <= 0.0 || off.abs() < 0.02 {
            break;
        }
        forward_solve(factor, width, solved);
        multiplier += off * length * length / dot(solved, solved);
    }
    best
}

/// What [`rough_reach`] would be at most, were nothing bent.
pub fn linear_reach(motion: &PairMotion, n: &Vec3, needed: f64) -> f64 {
    if motion.rate() > 0.0 {
        return needed / motion.rate();
    }
    let squared: f64 = motion.columns().iter().map(|column| n.dot(column).powi(2)).sum();
    needed / squared.sqrt().max(f64::MIN_POSITIVE)
}

/// As [`reach`], as far as bounds on all second derivatives tell.
pub fn rough_reach(motion: &PairMotion, curvature: &Curvature, n: &Vec3, needed: f64, ceiling: f64) -> f64 {
    if motion.rate() > 0.0 {
        return (needed / motion.rate() * (1.0 - ROUNDING)).min(ceiling);
    }
    let squared: f64 = motion.columns().iter().map(|column| n.dot(column).powi(2)).sum();
    let slope = squared.sqrt() + ROUNDING * curvature.first;
    root([0.0, slope, 0.5 * curvature.second, curvature.third], needed, ceiling)
}

/// Largest `r` up to `ceiling` with `p(r) <= needed`, for coefficients of `p` from the constant one
/// up that are not negative; 0 where there is none.
fn root(p: [f64; 4], needed: f64, ceiling: f64) -> f64 {
    let value = |r: f64| p[0] + r * (p[1] + r * (p[2] + r * p[3]));
    let rest = needed * (1.0 - ROUNDING) - p[0];
    if rest <= 0.0 {
        return 0.0;
    }
    // Above the root, from where Newton's steps descend to it.
    let mut r = ceiling;
    if value(r) <= needed * (1.0 - ROUNDING) {
        return r;
    }
    r = r.min(rest / p[1]).min((rest / p[2]).sqrt());
    for _ in 0..12 {
        let over = value(r) - p[0] - rest;
        let step = over / (p[1] + r * (2.0 * p[2] + 3.0 * r * p[3]));
        r -= step;
        if step <= 1e-13 * r {
            break;
        }
    }
    r *= 1.0 - 1e-11;
    if value(r) <= needed { r } else { 0.0 }
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; `false` where a pivot
/// is below `least`.
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

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

use crate::math::LANES;
use crate::math::Vec3;
use crate::math::linear_algebra::{cholesky_solve, dot, forward_solve};
use crate::metric::pair_motion::{Lanes, PairMotion, PairMotions, lanes};

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
/// Newton's steps to a root in lanes: from as near as they begin, four mostly do.
const STEPS: usize = 6;
/// How many multipliers are tried.
const TRIES: usize = 3;

impl Curvature {
    /// Of the points that `motion` was placed at, within `ceiling`.
    pub fn of(motion: &mut PairMotion, ceiling: f64) -> Self {
        let first = motion.columns().iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        let [second, third] = motion.derivatives(ceiling);
        Self { second, third: third / 6.0, first }
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
        return reach_by_rate(motion, needed, ceiling);
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

/// As [`reach`], where the metric says how far any point moves.
pub fn reach_by_rate(motion: &PairMotion, needed: f64, ceiling: f64) -> f64 {
    (needed / motion.rate() * (1.0 - ROUNDING)).clamp(0.0, ceiling)
}

/// As [`reach`], as far as bounds on all second derivatives tell, of each lane; under the joint
/// metric, along directions by axis of the world.
#[inline(always)]
pub fn rough_reaches(motions: &PairMotions, n: &[Lanes; 3], needed: &Lanes, ceiling: f64) -> Lanes {
    let [mut squared, mut first] = [[0.0; LANES]; 2];
    for [x, y, z] in &motions.columns {
        let along = lanes(|k| n[0][k] * x[k] + n[1][k] * y[k] + n[2][k] * z[k]);
        squared = lanes(|k| squared[k] + along[k] * along[k]);
        first = lanes(|k| first[k] + x[k] * x[k] + y[k] * y[k] + z[k] * z[k]);
    }
    let slope = lanes(|k| squared[k].sqrt() + ROUNDING * first[k].sqrt());
    let (half, third) = (lanes(|k| 0.5 * motions.second[k]), lanes(|k| motions.third[k] / 6.0));
    roots([&slope, &half, &third], needed, ceiling)
}

/// The same as [`root`] of each lane, for coefficients from the linear one up.
#[inline(always)]
fn roots([p, q, s]: [&Lanes; 3], needed: &Lanes, ceiling: f64) -> Lanes {
    let smaller = |a: f64, b: f64| if a < b { a } else { b };
    let value = |r: &Lanes| lanes(|k| r[k] * (p[k] + r[k] * (q[k] + r[k] * s[k])));
    let rest = lanes(|k| needed[k] * (1.0 - ROUNDING));
    let mut r = lanes(|k| smaller(smaller(ceiling, rest[k] / p[k]), (rest[k] / q[k]).sqrt()));
    for _ in 0..STEPS {
        let now = value(&r);
        let slope = lanes(|k| p[k] + r[k] * (2.0 * q[k] + 3.0 * r[k] * s[k]));
        r = lanes(|k| r[k] - (now[k] - rest[k]) / slope[k]);
    }
    let mut found = lanes(|k| r[k] * (1.0 - 1e-11));
    let (at_found, at_ceiling) = (value(&found), value(&[ceiling; LANES]));
    for k in 0..LANES {
        if rest[k] <= 0.0 {
            found[k] = 0.0;
        } else if at_ceiling[k] <= rest[k] {
            found[k] = ceiling;
        } else if !(found[k] <= ceiling && at_found[k] <= needed[k]) {
            found[k] = root([0.0, p[k], q[k], s[k]], needed[k], ceiling);
        }
    }
    found
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// This holds too if a coefficient is zero, if nothing is needed, and if the root is beyond the
    /// ceiling.
    #[test]
    fn roots_in_lanes_are_those_of_one() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let (mut inside, mut ends) = (0, 0);
        for _ in 0..2_000 {
            let mut number =
                |most: f64| if rng.random::<f64>() < 0.1 { 0.0 } else { most * rng.random::<f64>().powi(3) };
            let [p, q, s] = [2.0, 5.0, 9.0].map(|most| lanes(|_| number(most)));
            let needed = lanes(|k| number(1.0) - 0.02 * (k % 2) as f64);
            let ceiling = 0.01 + number(2.0);
            for (k, found) in roots([&p, &q, &s], &needed, ceiling).into_iter().enumerate() {
                let expected = root([0.0, p[k], q[k], s[k]], needed[k], ceiling);
                assert!((found - expected).abs() <= 1e-10 * expected, "{found} {expected}");
                let value = found * (p[k] + found * (q[k] + found * s[k]));
                assert!(found == 0.0 || value <= needed[k], "{value} {}", needed[k]);
                let is_end = found == 0.0 || found == ceiling;
                (inside, ends) = (inside + usize::from(!is_end), ends + usize::from(is_end));
            }
        }
        assert!(inside > 5_000 && ends > 2_000, "{inside} {ends}");
    }
}

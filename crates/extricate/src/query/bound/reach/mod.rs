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

use std::array;

use crate::math::{LANES, Vec3, vectorized};
use crate::metric::pair_motion::{Lanes, PairMotion, PairMotions, lanes};

#[derive(Debug, Clone, Default)]
pub struct ReachScratch {
    gradient: Vec<Corners>,
    hessian: Vec<Corners>,
    factor: Vec<Corners>,
    solved: Vec<Corners>,
}

/// A number for each of three corners; the fourth lane repeats the first.
type Corners = [f64; 4];

/// Bounds on derivatives in every direction, for the placed points.
#[derive(Debug, Clone, Copy, Default)]
pub struct Curvature {
    /// Bound on second derivatives at the configuration.
    pub second: f64,
    /// Bound on third derivatives up to the ceiling, divided by 6.
    pub third: f64,
    /// Upper bound on the norm of the gradient along any direction; rounding is proportional to it.
    pub first: f64,
}

/// Share by which bounds are lowered, many times the rounding error of some hundred operations.
const ROUNDING: f64 = 1e-12;
/// Newton steps to a root in lanes; from the start value, four mostly suffice.
const NEWTON_STEPS: usize = 6;
/// Multipliers tried for each corner; three prove the same (lab L121).
const MAX_MULTIPLIERS: usize = 2;

impl Curvature {
    /// Bounds the derivatives of the points that `motion` was placed at, up to `ceiling`.
    pub fn of(motion: &mut PairMotion, ceiling: f64) -> Self {
        let first = motion.columns().iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        let [second, third] = motion.derivatives(ceiling);
        Self { second, third: third / 6.0, first }
    }
}

/// Returns the least distance (metric units), at most `ceiling`, within which `n . (a - b)` grows
/// by less than `needed` \[m\], over three pairs of `n` and `needed`. Stops refining once all three
/// reach `enough`.
///
/// # Guarantee
/// Proved; never less than what bounds on all second derivatives prove alone.
pub fn least_reach(
    motion: &PairMotion,
    curvature: &Curvature,
    needs: &[(Vec3, f64); 3],
    (enough, ceiling): (f64, f64),
    scratch: &mut ReachScratch,
) -> f64 {
    let least = |of: &mut dyn Iterator<Item = f64>| of.fold(ceiling, f64::min);
    if motion.rate() > 0.0 {
        return least(&mut needs.iter().map(|(_, needed)| reach_by_rate(motion, *needed, ceiling)));
    }
    if needs.iter().any(|(_, needed)| *needed <= 0.0) {
        return 0.0;
    }
    let reaches = vectorized(
        #[inline(always)]
        || reaches(motion, curvature, needs, (enough.min(ceiling), ceiling), scratch),
    );
    least(&mut reaches.into_iter())
}

#[inline(always)]
fn corners(of: impl FnMut(usize) -> f64) -> Corners {
    array::from_fn(of)
}

#[inline(always)]
fn reaches(
    motion: &PairMotion,
    curvature: &Curvature,
    needs: &[(Vec3, f64); 3],
    (enough, ceiling): (f64, f64),
    scratch: &mut ReachScratch,
) -> Corners {
    let ReachScratch { gradient, hessian, factor, solved } = scratch;
    let n: [Corners; 3] = [0, 1, 2].map(|axis| corners(|k| needs[k % 3].0[axis]));
    let needed = corners(|k| needs[k % 3].1);
    gradient.clear();
    gradient.extend(motion.columns().iter().map(|v| corners(|k| n[0][k] * v.x + n[1][k] * v.y + n[2][k] * v.z)));
    let width = gradient.len();
    let squared = gradient.iter().fold([0.0; 4], |sum, g| corners(|k| sum[k] + g[k] * g[k]));
    let slope = corners(|k| squared[k].sqrt() + ROUNDING * curvature.first);
    let (zero, third) = ([0.0; 4], [curvature.third; 4]);
    let mut best = roots([&zero, &slope, &[0.5 * curvature.second; 4], &third], &needed, ceiling);
    if best.iter().all(|reach| *reach >= enough) {
        return best;
    }
    motion.hessian(&n, hessian);
    // The largest value lies nearly along the gradient, so start from the second derivative there.
    let mut along = zero;
    for (row, g) in hessian.chunks_exact(width).zip(&*gradient) {
        let product = row.iter().zip(&*gradient).fold(zero, |sum, (h, g)| corners(|k| sum[k] + h[k] * g[k]));
        along = corners(|k| along[k] + g[k] * product[k]);
    }
    let along = corners(|k| along[k] / (slope[k] * slope[k]).max(f64::MIN_POSITIVE));
    let most = curvature.second * (1.0 + 1e-6) + f64::MIN_POSITIVE;
    let likely = roots([&zero, &slope, &corners(|k| 0.5 * along[k].max(0.0)), &third], &needed, ceiling);
    let mut multiplier = corners(|k| slope[k] / likely[k] + along[k]);
    let mut is_settled = [false; 4];
    for _ in 0..MAX_MULTIPLIERS {
        // A multiplier is not negative, since it weighs the longer distance.
        multiplier = corners(|k| multiplier[k].max(1e-3 * most));
        let is_definite = factorize(hessian, &multiplier, width, factor);
        solved.clone_from(gradient);
        let squared = forward(factor, width, solved);
        let constant = corners(|k| 0.5 * squared[k] * (1.0 + 1e-8));
        let found = roots([&constant, &zero, &corners(|k| 0.5 * multiplier[k]), &third], &needed, ceiling);
        let length_squared = backward(factor, width, solved);
        let bent = forward(factor, width, solved);
        for k in 0..4 {
            if is_settled[k] {
                continue;
            }
            if !is_definite[k] {
                multiplier[k] = (2.0 * multiplier[k].max(0.25 * most)).min(most + multiplier[k].abs());
                continue;
            }
            best[k] = best[k].max(found[k]);
            let length = length_squared[k].sqrt();
            let off = (length - found[k]) / found[k].max(1e-12 * length);
            is_settled[k] = found[k] <= 0.0 || off.abs() < 0.02 || best[k] >= enough;
            if !is_settled[k] {
                multiplier[k] += off * length_squared[k] / bent[k];
            }
        }
        if is_settled == [true; 4] {
            break;
        }
    }
    best
}

/// Writes the Cholesky factor of `m I - H`, lower triangle, with the inverse of each pivot on the
/// diagonal; returns whether the matrix of each lane is definite.
#[inline(always)]
fn factorize(hessian: &[Corners], multiplier: &Corners, width: usize, factor: &mut Vec<Corners>) -> [bool; 4] {
    let mut is_definite = [true; 4];
    factor.clear();
    factor.resize(width * width, [0.0; 4]);
    let least = corners(|k| 1e-4 * multiplier[k]);
    // Slightly less than the multiplier, by far more than the rounding of the factor.
    let diagonal = corners(|k| multiplier[k] * (1.0 - 1e-9));
    for j in 0..width {
        for i in j..width {
            let mut sum = corners(|k| -hessian[i * width + j][k]);
            if i == j {
                sum = corners(|k| sum[k] + diagonal[k]);
            }
            for (x, y) in factor[i * width..i * width + j].iter().zip(&factor[j * width..j * width + j]) {
                sum = corners(|k| sum[k] - x[k] * y[k]);
            }
            if i == j {
                (0..4).for_each(|k| is_definite[k] &= sum[k] > least[k]);
                sum = corners(|k| sum[k].max(least[k]));
                factor[i * width + j] = corners(|k| 1.0 / sum[k].sqrt());
            } else {
                let inverse = factor[j * width + j];
                factor[i * width + j] = corners(|k| sum[k] * inverse[k]);
            }
        }
    }
    is_definite
}

/// Solves `L x = b` in place; returns the square of the solution.
#[inline(always)]
fn forward(factor: &[Corners], width: usize, x: &mut [Corners]) -> Corners {
    let mut squared = [0.0; 4];
    for i in 0..width {
        let mut sum = x[i];
        for (l, y) in factor[i * width..i * width + i].iter().zip(&x[..i]) {
            sum = corners(|k| sum[k] - l[k] * y[k]);
        }
        x[i] = corners(|k| sum[k] * factor[i * width + i][k]);
        squared = corners(|k| squared[k] + x[i][k] * x[i][k]);
    }
    squared
}

/// Solves `L' x = b` in place; returns the square of the solution.
#[inline(always)]
fn backward(factor: &[Corners], width: usize, x: &mut [Corners]) -> Corners {
    let mut squared = [0.0; 4];
    for i in (0..width).rev() {
        let mut sum = x[i];
        for j in i + 1..width {
            sum = corners(|k| sum[k] - factor[j * width + i][k] * x[j][k]);
        }
        x[i] = corners(|k| sum[k] * factor[i * width + i][k]);
        squared = corners(|k| squared[k] + x[i][k] * x[i][k]);
    }
    squared
}

/// Returns the reach if the metric itself bounds how far any point moves.
pub fn reach_by_rate(motion: &PairMotion, needed: f64, ceiling: f64) -> f64 {
    (needed / motion.rate() * (1.0 - ROUNDING)).clamp(0.0, ceiling)
}

/// Returns the reach of each lane under the joint metric, by bounds on all second derivatives
/// alone; `n` is given by axis of the world.
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
    roots([&[0.0; LANES], &slope, &half, &third], needed, ceiling)
}

/// Returns [`root`] of each lane.
#[inline(always)]
fn roots<const N: usize>(p: [&[f64; N]; 4], needed: &[f64; N], ceiling: f64) -> [f64; N] {
    let smaller = |a: f64, b: f64| if a < b { a } else { b };
    let [constant, p, q, s] = p;
    let value = |r: &[f64; N]| -> [f64; N] { array::from_fn(|k| r[k] * (p[k] + r[k] * (q[k] + r[k] * s[k]))) };
    let rest: [f64; N] = array::from_fn(|k| needed[k] * (1.0 - ROUNDING) - constant[k]);
    let mut r: [f64; N] = array::from_fn(|k| smaller(smaller(ceiling, rest[k] / p[k]), (rest[k] / q[k]).sqrt()));
    for _ in 0..NEWTON_STEPS {
        let now = value(&r);
        let slope: [f64; N] = array::from_fn(|k| p[k] + r[k] * (2.0 * q[k] + 3.0 * r[k] * s[k]));
        r = array::from_fn(|k| r[k] - (now[k] - rest[k]) / slope[k]);
    }
    let mut found: [f64; N] = array::from_fn(|k| r[k] * (1.0 - 1e-11));
    let (at_found, at_ceiling) = (value(&found), value(&[ceiling; N]));
    for k in 0..N {
        if rest[k] <= 0.0 {
            found[k] = 0.0;
        } else if at_ceiling[k] <= rest[k] {
            found[k] = ceiling;
        } else if !(found[k] <= ceiling && constant[k] + at_found[k] <= needed[k]) {
            found[k] = root([constant[k], p[k], q[k], s[k]], needed[k], ceiling);
        }
    }
    found
}

/// Returns the largest `r` up to `ceiling` with `p(r) <= needed`, or 0 if there is none. The
/// coefficients of `p`, from the constant one up, are not negative.
fn root(p: [f64; 4], needed: f64, ceiling: f64) -> f64 {
    let value = |r: f64| p[0] + r * (p[1] + r * (p[2] + r * p[3]));
    let rest = needed * (1.0 - ROUNDING) - p[0];
    if rest <= 0.0 {
        return 0.0;
    }
    // Newton steps descend to the root from above.
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

#[cfg(test)]
mod tests;

//! Seeded samplers of a [`ConfigSpace`]: uniform and low-discrepancy points.

use std::f64::consts::{PI, TAU};

use rand::{Rng, RngExt};

use super::{ConfigSpace, Manifold};
use crate::math::elementary::sin_cos;

/// Maps a point of the unit cube `[0, 1)^nv` to a configuration, uniform in the space's own
/// measure.
///
/// # Source
/// Rotations: K. Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
pub fn from_unit_cube(space: &ConfigSpace, u: impl Fn(usize) -> f64, out: &mut [f64]) {
    for factor in space.factors() {
        let (q, v) = (factor.q, factor.v);
        match factor.manifold {
            // Rounding may exceed the limit by a hair.
            Manifold::Interval { lower, upper } => out[q] = (lower + u(v) * (upper - lower)).min(upper),
            Manifold::Circle => out[q] = -PI + TAU * u(v),
            Manifold::Rotation => {
                let (r, s) = ((1.0 - u(v)).sqrt(), u(v).sqrt());
                let (sin_a, cos_a) = sin_cos(TAU * u(v + 1));
                let (sin_b, cos_b) = sin_cos(TAU * u(v + 2));
                out[q..q + 4].copy_from_slice(&[r * sin_a, r * cos_a, s * sin_b, s * cos_b]);
            }
        }
    }
}

/// Writes a uniformly random configuration to `out`.
pub fn uniform(space: &ConfigSpace, rng: &mut impl Rng, out: &mut [f64]) {
    let cube: Vec<f64> = (0..space.nv()).map(|_| rng.random::<f64>()).collect();
    from_unit_cube(space, |k| cube[k], out);
}

/// The Halton sequence with a random shift (Cranley-Patterson): low-discrepancy points, each
/// computed from its index alone.
///
/// # Source
/// J. H. Halton, 1960, doi:10.1007/BF01386213; R. Cranley and T. N. L. Patterson, 1976,
/// doi:10.1137/0713071. Above 20 dimensions plain Halton points correlate; permuting each digit
/// (the "reverse" permutation of B. Vandewoestyne and R. Cools, 2006,
/// doi:10.1016/j.cam.2005.05.022) removes that.
pub struct Halton {
    primes: Vec<u64>,
    shift: Vec<f64>,
}

impl Halton {
    /// Makes the sequence for `dimensions` coordinates, shifted by `seed`.
    pub fn new(dimensions: usize, seed: u64) -> Self {
        use rand::SeedableRng;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let primes =
            (2u64..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0)).take(dimensions).collect();
        Self { primes, shift: (0..dimensions).map(|_| rng.random::<f64>()).collect() }
    }

    /// Returns coordinate `k` in `[0, 1)` of point `index`.
    pub fn coordinate(&self, index: u64, k: usize) -> f64 {
        let base = self.primes[k];
        let (mut rest, mut scale, mut value) = (index + 1, 1.0, 0.0);
        while rest > 0 {
            scale /= base as f64;
            let digit = rest % base;
            value += scale * if digit == 0 { 0 } else { base - digit } as f64;
            rest /= base;
        }
        (value + self.shift[k]).fract()
    }

    /// Writes the configuration of point `index` to `out`.
    pub fn config(&self, space: &ConfigSpace, index: u64, out: &mut [f64]) {
        from_unit_cube(space, |k| self.coordinate(index, k), out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_fills_every_dimension_evenly() {
        let halton = Halton::new(24, 7);
        for k in 0..24 {
            let mut counts = [0usize; 8];
            for i in 0..8000 {
                counts[(halton.coordinate(i, k) * 8.0) as usize] += 1;
            }
            assert!(counts.iter().all(|c| (900..1100).contains(c)), "dimension {k}: {counts:?}");
        }
    }

    #[test]
    fn random_rotations_are_unit() {
        let mut space = ConfigSpace::default();
        space.push("r", Manifold::Rotation, 1.0);
        let mut q = vec![0.0; 4];
        for i in 0..100 {
            Halton::new(3, i).config(&space, i, &mut q);
            assert!((q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }
}

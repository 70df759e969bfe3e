//! Sine and cosine of several angles at once. The operations do not depend on their number, so that
//! one configuration and a block get the same bits, on every processor.

use pulp::Simd;

use crate::math::elementary::sin_cos;

/// Largest angle \[rad\] that the reduction below is made for; [`sin_cos`] computes those beyond.
pub const MAX_ANGLE_RAD: f64 = 1e5;

/// Rounding constant `1.5 * 2^52`: adding it leaves the nearest integer in the low bits of the sum.
const ROUNDING_SHIFT: f64 = 6_755_399_441_055_744.0;

/// `pi / 2` in three pieces. The first two have 33 bits, so that products with a quadrant below
/// `2^20` are exact.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Taylor coefficients of `(sin x - x) / x^3` in `x^2`, highest first: the next one adds less than
/// 1e-19 on `[-pi/4, pi/4]`.
const SINE_COEFFICIENTS: [f64; 8] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// Taylor coefficients of `(cos x - 1 + x^2 / 2) / x^4` in `x^2`, highest first.
const COSINE_COEFFICIENTS: [f64; 7] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
];

/// Returns the sines and the cosines of angles \[rad\].
///
/// # Guarantee
/// Values are within 2.3e-16 of the exact ones (measured over a million angles up to
/// [`MAX_ANGLE_RAD`], see the test). [`sin_cos`] computes all other angles.
///
/// # Source
/// Reduction: W. J. Cody and W. Waite, *Software Manual for the Elementary Functions*, 1980. No
/// fused operations, so that results do not depend on the processor.
#[inline(always)]
pub fn sines_cosines<S: Simd, const N: usize>(simd: S, angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    let (x, rest) = S::as_simd_f64s(angles);
    assert!(rest.is_empty(), "whole registers");
    let (s, _) = S::as_mut_simd_f64s(&mut sines);
    let (c, _) = S::as_mut_simd_f64s(&mut cosines);
    for ((x, s), c) in x.iter().zip(s).zip(c) {
        (*s, *c) = reduced(simd, *x);
    }
    if !angles.iter().all(|x| x.abs() <= MAX_ANGLE_RAD) {
        for (k, x) in angles.iter().enumerate().filter(|(_, x)| x.is_nan() || x.abs() > MAX_ANGLE_RAD) {
            (sines[k], cosines[k]) = sin_cos(*x);
        }
    }
    (sines, cosines)
}

#[inline(always)]
fn reduced<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let splat = |value: f64| simd.splat_f64s(value);
    let shifted = simd.add_f64s(simd.mul_f64s(x, splat(std::f64::consts::FRAC_2_PI)), splat(ROUNDING_SHIFT));
    let quadrant = simd.sub_f64s(shifted, splat(ROUNDING_SHIFT));
    let less = |x: S::f64s, piece: f64| simd.sub_f64s(x, simd.mul_f64s(quadrant, splat(piece)));
    let r = less(less(less(x, HALF_PI[0]), HALF_PI[1]), HALF_PI[2]);
    let r2 = simd.mul_f64s(r, r);
    let polynomial = |coefficients: &[f64]| {
        let mut p = splat(coefficients[0]);
        for c in &coefficients[1..] {
            p = simd.add_f64s(simd.mul_f64s(p, r2), splat(*c));
        }
        p
    };
    let sine = simd.add_f64s(r, simd.mul_f64s(simd.mul_f64s(r, r2), polynomial(&SINE_COEFFICIENTS)));
    // Computes 1 - x^2/2 first: it is exact but for one rounding, and the rest is small.
    let half = simd.sub_f64s(splat(1.0), simd.mul_f64s(splat(0.5), r2));
    let cosine = simd.add_f64s(half, simd.mul_f64s(simd.mul_f64s(r2, r2), polynomial(&COSINE_COEFFICIENTS)));

    let bits = simd.transmute_u64s_f64s(shifted);
    let has =
        |bits: S::u64s, bit: u64| simd.greater_than_u64s(simd.and_u64s(bits, simd.splat_u64s(bit)), simd.splat_u64s(0));
    let odd = has(bits, 1);
    let negated = |mask: S::m64s, x: S::f64s| simd.select_f64s(mask, simd.neg_f64s(x), x);
    let s = negated(has(bits, 2), simd.select_f64s(odd, cosine, sine));
    let next = simd.add_u64s(bits, simd.splat_u64s(1));
    let c = negated(has(next, 2), simd.select_f64s(odd, sine, cosine));
    (s, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn sines_are_those_of_the_standard_library_to_the_last_place() {
        struct Wide<'a>(&'a [f64; 8]);
        impl pulp::WithSimd for Wide<'_> {
            type Output = ([f64; 8], [f64; 8]);
            fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
                sines_cosines(simd, self.0)
            }
        }
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut worst: f64 = 0.0;
        for i in 0..125_000 {
            let scale = [1.0, 4.0, 100.0, 1e5][i % 4];
            let mut angles = [0.0; 8].map(|_: f64| scale * (2.0 * rng.random::<f64>() - 1.0));
            if i % 4 == 1 {
                // Angles next to multiples of pi/4 test the cancellation in the reduction.
                angles = angles.map(|x| x.round() * std::f64::consts::FRAC_PI_4 + 1e-9 * x);
            }
            let (sines, cosines) = pulp::Arch::new().dispatch(Wide(&angles));
            assert_eq!((sines, cosines), sines_cosines(pulp::Scalar::new(), &angles), "{angles:?}");
            for k in 0..8 {
                let (s, c) = angles[k].sin_cos();
                worst = worst.max((s - sines[k]).abs()).max((c - cosines[k]).abs());
            }
        }
        assert!(worst < 2.3e-16, "{worst}");
    }

    #[test]
    fn angles_beyond_the_reduction_are_exact_too() {
        let angles = [1e9, -3e5, 1e5, 0.0, -0.0, 7e8, 1.0, 100_001.0];
        let (sines, cosines) = sines_cosines(pulp::Scalar::new(), &angles);
        for k in 0..8 {
            assert!((sines[k] - angles[k].sin()).abs() < 2.3e-16 && (cosines[k] - angles[k].cos()).abs() < 2.3e-16);
        }
        assert!(sines_cosines(pulp::Scalar::new(), &[f64::NAN, f64::INFINITY]).0.iter().all(|s| s.is_nan()));
    }
}

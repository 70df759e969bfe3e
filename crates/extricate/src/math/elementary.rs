//! Elementary functions with the same bits on every platform. The standard library uses the
//! platform's own: the last bit of a logarithm differs between Linux and a browser, and a search
//! that starts elsewhere may end elsewhere.
//!
//! Joint angles are many, so `kinematics` computes their sines and cosines eight at a time.

/// Returns the natural logarithm of `x`.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Returns the logarithm of `x` to the base 2.
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

/// Returns the sine and cosine of an angle \[rad\].
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// Returns the angle \[rad\] of the vector `(x, y)`.
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Returns the length of the vector `(x, y)`.
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_standard_library_but_for_the_last_bit() {
        for (x, y) in [(0.3, 0.7), (1.0, -1e-9), (2.5, 1e3), (1e-3, -4.0)] {
            let close = |a: f64, b: f64| assert!((a - b).abs() <= 4e-16 * b.abs().max(1e-300), "{x} {y}: {a} {b}");
            close(ln(x), x.ln());
            close(log2(x), x.log2());
            close(sin_cos(y).0, y.sin());
            close(sin_cos(y).1, y.cos());
            close(atan2(y, x), y.atan2(x));
            close(hypot(x, y), x.hypot(y));
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }
}

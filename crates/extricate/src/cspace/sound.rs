//! Checks that a configuration space and its configurations, read as bytes, are what this program
//! writes. It reports what is wrong and repairs nothing.

use super::{ConfigSpace, LIMIT_TOLERANCE, Manifold};
use crate::math::FARTHEST;

/// Weights of the joint metric that a scene may give.
pub const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;
/// Tolerance of the length of a stored quaternion, which was normalised when it was made.
const UNIT_LENGTH_TOLERANCE: f64 = 1e-9;

impl ConfigSpace {
    /// Checks that factors exist, one behind the other, with ordered limits and allowed weights.
    ///
    /// # Errors
    /// The message names the factor, the value and what was expected.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.factors.is_empty() {
            return Err("space: got no factor, expected at least one".into());
        }
        let mut again = ConfigSpace::default();
        for (number, factor) in self.factors.iter().enumerate() {
            let fault = |problem: String| Err(format!("space: factor {number}: {problem}"));
            if let Manifold::Interval { lower, upper } = factor.manifold
                && !(-FARTHEST <= lower && lower <= upper && upper <= FARTHEST)
            {
                return fault(format!("got limits [{lower:?}, {upper:?}], expected lower <= upper, within 1e9"));
            }
            if !WEIGHTS.contains(&factor.weight) {
                return fault(format!("got the weight {:?}, expected 1e-9 to 1e9", factor.weight));
            }
            let expected = again.push("", factor.manifold, factor.weight);
            if (factor.q, factor.v) != expected {
                return fault(format!("got the coordinates {:?}, expected {expected:?}", (factor.q, factor.v)));
            }
        }
        if (self.nq, self.nv) != (again.nq, again.nv) {
            let expected = (again.nq, again.nv);
            return Err(format!("space: got {:?} coordinates, expected {expected:?}", (self.nq, self.nv)));
        }
        Ok(())
    }

    /// Checks that every row of a list is a configuration within limits.
    ///
    /// # Errors
    /// The message names the row, its value and what was expected.
    pub(crate) fn check_rows(&self, rows: &[f64]) -> Result<(), String> {
        if !rows.len().is_multiple_of(self.nq) {
            return Err(format!("got {} numbers, expected rows of {}", rows.len(), self.nq));
        }
        rows.chunks_exact(self.nq)
            .enumerate()
            .try_for_each(|(row, q)| self.check_row(q).map_err(|problem| format!("row {row}: {problem}")))
    }

    fn check_row(&self, q: &[f64]) -> Result<(), String> {
        for factor in &self.factors {
            let x = &q[factor.coordinates()];
            let (sound, expected) = match factor.manifold {
                Manifold::Interval { lower, upper } => {
                    let sound = lower - LIMIT_TOLERANCE <= x[0] && x[0] <= upper + LIMIT_TOLERANCE;
                    (sound, format!("a value within [{lower}, {upper}]"))
                }
                Manifold::Circle => (x[0].abs() <= std::f64::consts::PI, "an angle within [-pi, pi]".into()),
                Manifold::Rotation => {
                    let squared: f64 = x.iter().map(|c| c * c).sum();
                    ((squared - 1.0).abs() <= 2.0 * UNIT_LENGTH_TOLERANCE, "a unit quaternion x, y, z, w".into())
                }
            };
            if !sound {
                return Err(format!("`{}` (coordinate {}): got {x:?}, expected {expected}", factor.name, factor.q));
            }
        }
        Ok(())
    }

    /// Returns whether every coordinate is finite and within its limits, as a witness has to be
    /// besides being collision-free.
    pub(crate) fn is_within(&self, q: &[f64]) -> bool {
        q.iter().all(|x| x.is_finite()) && self.outside(q).next().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::tests::space;

    #[test]
    fn a_space_that_no_scene_has_is_refused() {
        type Spoil = fn(&mut ConfigSpace);
        let refused = |spoil: Spoil| {
            let mut space = space();
            spoil(&mut space);
            space.check().err().unwrap_or_default()
        };
        let limits: Spoil = |space| space.factors[0].manifold = Manifold::Interval { lower: 1.0, upper: 0.0 };
        let spoils: [(Spoil, &str); 8] = [
            (|_| (), ""),
            (|space| space.factors.clear(), "got no factor"),
            (limits, "factor 0: got limits [1.0, 0.0]"),
            (|space| space.factors[1].weight = f64::NAN, "factor 1: got the weight NaN"),
            (|space| space.factors[1].q = 7, "factor 1: got the coordinates (7, 1), expected (1, 1)"),
            (|space| space.factors[2].v = usize::MAX, "factor 2: got the coordinates"),
            (|space| space.nq = usize::MAX, "coordinates, expected (6, 5)"),
            (|space| space.nv = 0, "got (6, 0) coordinates"),
        ];
        for (spoil, expected) in spoils {
            let message = refused(spoil);
            assert!(message.contains(expected) && message.is_empty() == expected.is_empty(), "{message}");
        }
    }

    #[test]
    fn rows_beyond_limits_are_named() {
        let space = space();
        let sound = [0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(space.check_rows(&[sound, sound].concat()), Ok(()));
        for (at, value) in [(0, 2.1), (0, f64::NAN), (1, 1e308), (2, f64::INFINITY), (5, 0.9)] {
            let mut other = sound;
            other[at] = value;
            let message = space.check_rows(&[sound, other].concat()).unwrap_err();
            assert!(message.starts_with("row 1: `") && message.contains("expected"), "{message}");
            assert_eq!(space.is_within(&other), (at, value) == (5, 0.9) || value == 1e308, "{at}: {value}");
        }
        assert!(space.check_rows(&sound[1..]).unwrap_err().contains("expected rows of 6"));
    }
}

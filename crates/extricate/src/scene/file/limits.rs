//! Limits of joints and bounds of moving bases, as a scene file writes them.

use serde::Deserialize;

use super::arrays::exactly;
use crate::error::{Error, Result};
use crate::math::FARTHEST;

/// Bounds of several coordinates [m or rad].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table `{ min = [..], max = [..] }`")]
pub struct BoundsEntry {
    /// Least value of each coordinate.
    pub min: Vec<f64>,
    /// Greatest value of each coordinate.
    pub max: Vec<f64>,
}

/// Limits of one joint [m or rad].
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected [lower, upper] or { min = [..], max = [..] }")]
pub enum LimitsEntry {
    /// Limits of its one coordinate, or of each of its translations.
    Interval(#[serde(deserialize_with = "exactly")] [f64; 2]),
    /// One entry for a single coordinate, or one for each translation; a planar joint may have
    /// another for its angle.
    Bounds(BoundsEntry),
}

impl BoundsEntry {
    /// Returns `(min, max)` of each coordinate. `counts` are the allowed numbers of entries, `what`
    /// is the element in messages.
    ///
    /// # Errors
    /// [`Error::Input`] if the lengths differ or are not allowed, a number is not within 1e9, or a
    /// minimum exceeds its maximum.
    pub fn intervals(&self, file: &str, what: &str, counts: &[usize]) -> Result<Vec<(f64, f64)>> {
        if self.min.len() != self.max.len() || !counts.contains(&self.min.len()) {
            let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
            let found = format!("got {} and {} numbers", self.min.len(), self.max.len());
            return Err(Error::input(
                file,
                what,
                format!("min and max: {found}, expected {} each", counts.join(" or ")),
            ));
        }
        self.min.iter().zip(&self.max).map(|(&min, &max)| interval(file, what, min, max)).collect()
    }
}

/// Checks that `lower` and `upper` are within 1e9 and in order.
pub fn interval(file: &str, what: &str, lower: f64, upper: f64) -> Result<(f64, f64)> {
    if -FARTHEST <= lower && lower <= upper && upper <= FARTHEST {
        return Ok((lower, upper));
    }
    let problem = format!("got [{lower:?}, {upper:?}], expected finite limits within 1e9, lower <= upper");
    Err(Error::input(file, what, problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_checked() {
        let bounds = |min: &[f64], max: &[f64]| {
            let entry = BoundsEntry { min: min.to_vec(), max: max.to_vec() };
            entry.intervals("s.toml", "robot \"a\": bounds", &[2, 3]).map_err(|e| e.to_string())
        };
        assert_eq!(bounds(&[0.0, 1.0], &[2.0, 3.0]).unwrap(), [(0.0, 2.0), (1.0, 3.0)]);
        assert!(bounds(&[0.0], &[1.0]).unwrap_err().contains("expected 2 or 3 each"));
        assert!(bounds(&[0.0, 2.0], &[1.0, 1.0]).unwrap_err().contains("[2.0, 1.0]"));
        assert!(bounds(&[-1e300; 2], &[1e300; 2]).unwrap_err().contains("[-1e300, 1e300], expected finite limits"));
    }
}

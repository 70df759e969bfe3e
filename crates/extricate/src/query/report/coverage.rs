//! How usual the place of a query is: whether the model has samples as near to it as to the
//! configurations it was measured on.

use std::cmp::Ordering;

/// Coverage below which a query is said to lie far from what was learned.
pub const FAR: f64 = 0.01;

/// Distances of held-out colliding configurations to the sample that a refined query of them begins
/// with, to compare a query's with.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Coverage {
    /// Metric units, ascending.
    distances: Vec<f64>,
}

impl Coverage {
    /// From the distances of configurations that were drawn uniformly and not learned from, in
    /// metric units.
    pub fn new(mut distances: Vec<f64>) -> Self {
        distances.sort_by(f64::total_cmp);
        Self { distances }
    }

    /// The distances, ascending.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// Share of the held-out configurations, the query itself counted among them, whose first
    /// sample is at least as far as `distance`: about 1 in well sampled places, near 0 where the
    /// query is farther from any sample than nearly all of them. `None` where nothing was held out.
    ///
    /// # Guarantee
    /// Of queries that are uniform among the colliding configurations, a share of at most `a` has a
    /// coverage of at most `a`, over the draws of the held-out ones too. (Queries that begin
    /// elsewhere look among more samples, and find none farther.)
    ///
    /// # Source
    /// A conformal p-value: V. Vovk, A. Gammerman and G. Shafer, "Algorithmic Learning in a Random
    /// World", 2005, doi:10.1007/b106715, proposition 2.3, with the distance to the first sample
    /// for a nonconformity score.
    pub fn of(&self, distance: f64) -> Option<f64> {
        if self.distances.is_empty() {
            return None;
        }
        let nearer = self.distances.partition_point(|d| d.total_cmp(&distance) == Ordering::Less);
        Some((self.distances.len() - nearer + 1) as f64 / (self.distances.len() + 1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_share_of_those_at_least_as_far() {
        let coverage = Coverage::new(vec![0.3, 0.1, 0.2]);
        for (distance, expected) in [(0.0, 1.0), (0.1, 1.0), (0.15, 0.75), (0.3, 0.5), (0.31, 0.25), (1e9, 0.25)] {
            assert_eq!(coverage.of(distance), Some(expected), "{distance}");
        }
        assert_eq!(Coverage::default().of(0.1), None);
    }

    #[test]
    fn of_like_queries_a_share_of_a_is_called_a_or_less() {
        // Any distribution; low-discrepancy numbers in place of random ones make the shares exact.
        let spread = |i: usize, shift: f64| (i as f64 * 0.618_033_988_749_895 + shift).fract().powi(3);
        let coverage = Coverage::new((0..400).map(|i| spread(i, 0.1)).collect());
        for level in [0.01, 0.1, 0.5] {
            let low = (0..5000).filter(|i| coverage.of(spread(*i, 0.7)).unwrap() <= level).count() as f64 / 5000.0;
            assert!((0.5 * level..1.1 * level).contains(&low), "{level}: {low}");
        }
    }
}

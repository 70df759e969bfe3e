//! Figures of how good a model is: their types, and how they are computed from measured values.

use serde::{Deserialize, Serialize};

/// How densely the boundary is sampled, in the scene's metric.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Density {
    /// Median distance from a boundary sample to the nearest other one.
    pub spacing_median: f64,
    /// 95th percentile of the same distance.
    pub spacing_p95: f64,
    /// Median distance from a held-out colliding configuration to its nearest boundary sample.
    pub reach_median: f64,
    /// 95th percentile of the same distance.
    pub reach_p95: f64,
}

/// How much farther refined answers are than those of a search about ten times as long, on held-out
/// colliding configurations.
///
/// The longer search starts from the same samples, among others. What both miss is not seen, so the
/// true excess is at least this.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Excess {
    /// Held-out colliding configurations that were queried, drawn uniformly; nothing was learned
    /// from them.
    pub queries: usize,
    /// Median of `depth / depth of the longer search - 1`.
    pub median: f64,
    /// 95th percentile of the same ratio.
    pub p95: f64,
    /// Share of queries with an excess of at most 0.05.
    pub within_5pct: f64,
    /// 95 % confidence interval of `within_5pct`.
    pub within_5pct_interval: [f64; 2],
}

/// How much of the depth refined queries leave unproved, on the same configurations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Held-out colliding configurations that were queried.
    pub queries: usize,
    /// Median of `1 - lower_bound / depth`.
    pub median: f64,
    /// 95th percentile of the same share.
    pub p95: f64,
}

impl Gap {
    /// Summarises gaps, in any order; `None` if there are none.
    pub fn of(gaps: &[f64]) -> Option<Self> {
        let (median, p95) = (percentile(gaps, 0.5), percentile(gaps, 0.95));
        (!gaps.is_empty()).then_some(Self { queries: gaps.len(), median, p95 })
    }
}

impl Excess {
    /// Summarises excesses, in any order; `None` if there are none.
    pub fn of(excesses: &[f64]) -> Option<Self> {
        let near = excesses.iter().filter(|excess| **excess <= 0.05).count();
        (!excesses.is_empty()).then(|| Self {
            queries: excesses.len(),
            median: percentile(excesses, 0.5),
            p95: percentile(excesses, 0.95),
            within_5pct: near as f64 / excesses.len() as f64,
            within_5pct_interval: wilson(near, excesses.len()),
        })
    }
}

/// Returns the smallest of `values` that at least `share` of them do not exceed (nearest rank); 0
/// if there are none.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied().unwrap_or(0.0)
}

/// 0.975 quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// Returns the 95 % confidence interval of the probability of an event that occurred in `successes`
/// of `trials`; `[0, 1]` without trials.
///
/// # Source
/// E. B. Wilson, "Probable inference, the law of succession, and statistical inference", 1927,
/// doi:10.1080/01621459.1927.10502953. Unlike other normal approximations, it keeps its level for
/// shares near 0 and 1.
pub fn wilson(successes: usize, trials: usize) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let scale = 1.0 / (1.0 + Z * Z / n);
    let centre = scale * (p + Z * Z / (2.0 * n));
    let half = scale * Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    // Rounding must not leave the share itself outside.
    [(centre - half).clamp(0.0, p), (centre + half).clamp(p, 1.0)]
}

/// Returns the interval of a measured accuracy; `None` if it was not measured.
pub fn interval(accuracy: Option<f64>, trials: usize) -> Option<[f64; 2]> {
    accuracy.map(|share| wilson((share * trials as f64).round() as usize, trials))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_solve_the_equation_that_defines_them() {
        // Both ends are the probabilities from which the observed share is 1.96 standard deviations
        // away.
        for (successes, trials) in [(0, 5), (1, 10), (19, 20), (64, 64), (970, 1000)] {
            let (p, n) = (successes as f64 / trials as f64, trials as f64);
            let [low, high] = wilson(successes, trials);
            assert!(0.0 <= low && low <= p && p <= high && high <= 1.0);
            for end in [low, high].into_iter().filter(|end| (*end - p).abs() > 1e-12) {
                let deviations = (p - end).abs() / (end * (1.0 - end) / n).sqrt();
                assert!((deviations - Z).abs() < 1e-9, "{successes} of {trials}: {deviations}");
            }
        }
        // To four digits, from the closed form by hand: 10 of 10 gives 10 / (10 + 1.96^2).
        assert!((wilson(10, 10)[0] - 0.7225).abs() < 1e-4);
        assert_eq!(wilson(0, 0), [0.0, 1.0]);
    }

    #[test]
    fn percentiles_are_values_that_occurred() {
        let values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!((percentile(&values, 0.5), percentile(&values, 0.95), percentile(&values, 1.0)), (10.0, 19.0, 20.0));
        assert_eq!((percentile(&values[..1], 0.5), percentile(&[], 0.5)), (20.0, 0.0));
    }

    #[test]
    fn an_excess_of_nothing_is_not_claimed() {
        assert_eq!(Excess::of(&[]), None);
        let excess = Excess::of(&[0.0, 0.0, 0.05, 0.2]).unwrap();
        assert_eq!((excess.queries, excess.median, excess.p95, excess.within_5pct), (4, 0.0, 0.2, 0.75));
    }
}

//! Summarises many answers.

use extricate::Answer;
use serde::Serialize;

use crate::report::{count, duration, percent, quantile};

/// Collects the values of many answers.
#[derive(Debug, Default)]
pub struct Summary {
    depths: Vec<f64>,
    seconds: Vec<f64>,
    tightness: Vec<f64>,
    displacements: Vec<f64>,
    checks: Vec<f64>,
    verified: usize,
    free: usize,
}

/// Shares, medians and percentiles of many answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    pub queries: usize,
    /// Queries that were free already; the quantiles exclude them.
    pub free: usize,
    /// Share of witnesses checked during the query.
    pub verified: f64,
    /// Median depth, in the scene's metric.
    pub depth_median: f64,
    /// 95th percentile of the depth, in the scene's metric.
    pub depth_p95: f64,
    /// Median ratio of lower bound to depth.
    pub lower_over_depth_median: f64,
    /// Median of the largest displacement of any point \[m\].
    pub max_displacement_median: f64,
    /// Median time of a query \[s\].
    pub seconds_median: f64,
    /// 95th percentile of the time of a query \[s\].
    pub seconds_p95: f64,
    /// Median number of checks.
    pub checks_median: f64,
}

impl Summary {
    pub fn add(&mut self, answer: &Answer, seconds: f64) {
        self.verified += usize::from(answer.verified);
        if answer.depth == 0.0 {
            self.free += 1;
            return;
        }
        self.depths.push(answer.depth);
        self.seconds.push(seconds);
        self.tightness.push(answer.lower_bound / answer.depth);
        self.displacements.push(answer.max_displacement);
        self.checks.push(answer.checks as f64);
    }

    /// Number of answers that were added.
    pub fn queries(&self) -> usize {
        self.free + self.depths.len()
    }

    /// Computes medians and percentiles, which are `NaN` if nothing collided.
    pub fn figures(&mut self) -> Figures {
        let queries = self.queries();
        Figures {
            queries,
            free: self.free,
            verified: self.verified as f64 / queries.max(1) as f64,
            depth_median: quantile(&mut self.depths, 0.5),
            depth_p95: quantile(&mut self.depths, 0.95),
            lower_over_depth_median: quantile(&mut self.tightness, 0.5),
            max_displacement_median: quantile(&mut self.displacements, 0.5),
            seconds_median: quantile(&mut self.seconds, 0.5),
            seconds_p95: quantile(&mut self.seconds, 0.95),
            checks_median: quantile(&mut self.checks, 0.5),
        }
    }
}

impl Figures {
    /// Rows of the summary of `query`.
    pub fn rows(&self, unit: &str) -> Vec<(&'static str, String)> {
        let mut rows = vec![
            ("queries", format!("{} ({} of them free already)", count(self.queries), count(self.free))),
            ("verified", percent(self.verified)),
        ];
        if self.queries > self.free {
            rows.extend([
                (
                    "depth",
                    format!("median {:.4} {unit}, 95th percentile {:.4} {unit}", self.depth_median, self.depth_p95),
                ),
                ("lower bound", format!("median {} of the depth", percent(self.lower_over_depth_median))),
                (
                    "time",
                    format!("median {}, 95th percentile {}", duration(self.seconds_median), duration(self.seconds_p95)),
                ),
                ("checks", format!("median {:.0}", self.checks_median)),
            ]);
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::query::row::tests::answer;

    #[test]
    fn free_queries_do_not_dilute_the_figures() {
        let mut summary = Summary::default();
        for (depth, verified) in [(0.0, true), (0.2, true), (0.4, true), (0.6, false)] {
            summary.add(&answer(depth, verified), 1e-4);
        }
        let figures = summary.figures();
        assert_eq!((figures.queries, figures.free), (4, 1));
        assert_eq!(figures.depth_median, 0.4);
        assert_eq!(figures.verified, 0.75);
        assert_eq!(figures.lower_over_depth_median, 0.25);
        assert_eq!(figures.rows("rad").len(), 6);
    }

    #[test]
    fn a_summary_of_free_queries_has_no_quantiles() {
        let mut summary = Summary::default();
        summary.add(&answer(0.0, true), 1e-4);
        assert_eq!(summary.figures().rows("rad").len(), 2);
    }
}

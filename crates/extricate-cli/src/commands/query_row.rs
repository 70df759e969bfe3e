//! One answer as a row of text or a line of JSON, and the summary of many.

use extricate::{Answer, Effort, Scene};
use serde::Serialize;

use crate::report::{duration, pair_names, pairs_in_words, percent, quantile};

/// An answer with names in place of indices: the JSON output of `query`.
#[derive(Debug, Serialize)]
pub struct QueryRow<'a> {
    /// Distance from the query to the witness, in the scene's metric; 0 where the query is free.
    pub depth: f64,
    /// Proved: no free configuration is nearer.
    pub lower_bound: f64,
    /// The free configuration.
    pub witness: &'a [f64],
    /// Time of the library call alone \[s\].
    pub seconds: f64,
    /// Collision checks and distance evaluations spent.
    pub checks: usize,
    /// Largest displacement of any point of the robot \[m\].
    pub max_displacement: f64,
    /// Pairs that collide at the query.
    pub colliding: Vec<[&'a str; 2]>,
    /// Pairs that touch at the witness.
    pub touching: Vec<[&'a str; 2]>,
    /// Whether the witness was checked during this query.
    pub verified: bool,
    /// How hard the query tried.
    pub effort: Effort,
}

impl<'a> QueryRow<'a> {
    /// Names the pairs of `answer`.
    pub fn new(answer: &'a Answer, seconds: f64, scene: &'a Scene) -> Self {
        Self {
            depth: answer.depth,
            lower_bound: answer.lower_bound,
            witness: &answer.witness,
            seconds,
            checks: answer.checks,
            max_displacement: answer.max_displacement,
            colliding: pair_names(scene, &answer.colliding),
            touching: pair_names(scene, &answer.touching),
            verified: answer.verified,
            effort: answer.effort,
        }
    }

    /// The row for the query of input line `line`.
    pub fn text(&self, line: usize) -> String {
        let verified = if self.verified { "yes" } else { "no" };
        let pairs = if self.colliding.is_empty() { "none".into() } else { pairs_in_words(&self.colliding, 2) };
        format!(
            "{line:>6}  {:>9.5}  {:>9.5}  {:>9.2}  {:>9}  {:>6}  {verified:<8}  {pairs}",
            self.depth,
            self.lower_bound,
            100.0 * self.max_displacement,
            duration(self.seconds),
            self.checks,
        )
    }
}

/// Titles of the columns of [`QueryRow::text`].
pub fn header(unit: &str) -> String {
    let title = format!(
        "{:>6}  {:>9}  {:>9}  {:>9}  {:>9}  {:>6}  {:<8}  colliding pairs",
        "line", "depth", "at least", "moved", "time", "checks", "verified"
    );
    format!("{title}\n{:>6}  {:>9}  {:>9}  {:>9}", "", format!("[{unit}]"), format!("[{unit}]"), "[cm]")
}

/// Figures of many answers.
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

/// The figures that are shown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Queries answered.
    pub queries: usize,
    /// Those that were free already; the quantiles below leave them out.
    pub free: usize,
    /// Share of witnesses checked during the query.
    pub verified: f64,
    /// Median depth, in the scene's metric.
    pub depth_median: f64,
    /// 95th percentile.
    pub depth_p95: f64,
    /// Median of lower bound over depth.
    pub lower_over_depth_median: f64,
    /// Median of the largest displacement of any point \[m\].
    pub max_displacement_median: f64,
    /// Median time \[s\].
    pub seconds_median: f64,
    /// 95th percentile.
    pub seconds_p95: f64,
    /// Median number of checks.
    pub checks_median: f64,
}

impl Summary {
    /// Adds one answer.
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

    /// How many were added.
    pub fn queries(&self) -> usize {
        self.free + self.depths.len()
    }

    /// Medians and percentiles; `NaN` where nothing collided.
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
            ("queries", format!("{} ({} of them free already)", self.queries, self.free)),
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

    fn answer(depth: f64, verified: bool) -> Answer {
        Answer {
            depth,
            lower_bound: depth / 4.0,
            witness: vec![0.5],
            effort: Effort::Refined,
            checks: 40,
            max_displacement: depth * 0.5,
            colliding: vec![],
            touching: vec![],
            verified,
        }
    }

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

    #[test]
    fn json_has_the_documented_keys() {
        let answer = answer(0.2, true);
        let row = QueryRow {
            depth: answer.depth,
            lower_bound: answer.lower_bound,
            witness: &answer.witness,
            seconds: 1e-4,
            checks: 40,
            max_displacement: 0.1,
            colliding: vec![["arm", "shelf"]],
            touching: vec![["arm", "shelf"]],
            verified: true,
            effort: answer.effort,
        };
        assert_eq!(
            serde_json::to_string(&row).unwrap(),
            "{\"depth\":0.2,\"lower_bound\":0.05,\"witness\":[0.5],\"seconds\":0.0001,\"checks\":40,\
             \"max_displacement\":0.1,\"colliding\":[[\"arm\",\"shelf\"]],\"touching\":[[\"arm\",\"shelf\"]],\
             \"verified\":true,\"effort\":\"refined\"}"
        );
        assert!(row.text(3).ends_with("yes       arm - shelf"), "{}", row.text(3));
        let widths: Vec<_> = header("rad").lines().map(|l| l.find("depth").or(l.find("[rad]"))).collect();
        assert!(widths.iter().all(Option::is_some));
    }
}

//! The table that the demo prints, in words that need no manual.

use extricate::{Scene, Statistics};
use serde::Serialize;

use crate::commands::learn::held_out_accuracy;
use crate::commands::query::summary::Figures;
use crate::report::{count, duration, metric_unit, percent, two_columns};

/// Results of the demo, printed as JSON or as a table.
#[derive(Serialize)]
pub struct DemoReport<'a> {
    pub scene: &'a str,
    /// Figures of the queries before learning.
    pub at_once: Figures,
    /// Share of the quick answers with the model that are at most 5 % farther than those before
    /// learning.
    pub as_near: f64,
    /// Statistics of the model.
    pub learned: &'a Statistics,
    /// Wall time of learning \[s\].
    pub learning_seconds: f64,
    /// Figures of the same queries with the model.
    pub queries: Figures,
    /// Path of the page of some answers.
    pub page: String,
}

impl DemoReport<'_> {
    pub fn text(&self, scene: &Scene) -> String {
        let (learned, queries, unit) = (self.learned, &self.queries, metric_unit(scene));
        let obstacles = scene.bodies().iter().filter(|b| b.robot.is_none()).count();
        let learning = [
            (
                "robot",
                format!("{} degrees of freedom, {} checked pairs", scene.space().nv(), count(scene.pairs().len())),
            ),
            ("obstacles", obstacles.to_string()),
            (
                "labels spent",
                format!("{} exact collision checks in {}", count(learned.labels), duration(self.learning_seconds)),
            ),
            ("held-out accuracy", held_out_accuracy(learned)),
            ("stored", format!("{} boundary samples, each verified free", count(learned.boundary_samples))),
        ];
        let asked = [
            ("verified", format!("{} of the answers checked collision-free at query time", percent(queries.verified))),
            ("time", spread(duration(queries.seconds_median), duration(queries.seconds_p95))),
            ("depth", spread(angle(queries.depth_median, unit), angle(queries.depth_p95, unit))),
            (
                "lower bound",
                format!(
                    "median {} of the depth: proved, nothing free is nearer",
                    percent(queries.lower_over_depth_median)
                ),
            ),
            (
                "moved",
                format!("median {:.1} cm, the farthest point of the arm", 100.0 * queries.max_displacement_median),
            ),
            ("checks", format!("median {:.0} collision and distance evaluations", queries.checks_median)),
            (
                "learning buys",
                format!(
                    "{:.1} times fewer checks than without; {} of these answers are as near within 5 %",
                    self.at_once.checks_median / queries.checks_median,
                    percent(self.as_near)
                ),
            ),
        ];
        format!(
            "Scene {}: what was learned\n{}\n\nNearest exit of the same {} collisions with the model, effort quick\n{}",
            self.scene,
            two_columns(&learning),
            count(queries.queries),
            two_columns(&asked),
        )
    }
}

/// Formats the figures that are known before learning.
pub fn at_once_text(queries: &Figures, scene: &Scene, page: &str) -> String {
    let unit = metric_unit(scene);
    let rows = [
        ("verified", percent(queries.verified)),
        ("time", spread(duration(queries.seconds_median), duration(queries.seconds_p95))),
        ("depth", spread(angle(queries.depth_median, unit), angle(queries.depth_p95, unit))),
        ("checks", format!("median {:.0}", queries.checks_median)),
    ];
    let asked = count(queries.queries);
    let table = two_columns(&rows);
    format!(
        "At once, before anything is learned: nearest exit of {asked} random collisions\n{table}\n\nPage: {page} (open it in a browser)\n"
    )
}

fn spread(median: String, p95: String) -> String {
    format!("median {median}, 95 % within {p95}")
}

fn angle(depth: f64, unit: &str) -> String {
    if unit == "rad" { format!("{depth:.3} rad ({:.1} deg)", depth.to_degrees()) } else { format!("{depth:.4} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::learn::tests::statistics;
    use extricate::builtin;
    use serde_json::json;

    #[test]
    fn the_table_says_everything_that_was_promised() {
        let statistics = statistics(json!({
            "labels": 12345, "accuracy_free": 0.97, "accuracy_free_interval": [0.96, 0.98],
        }));
        let scene = builtin::scene("planar-arm").unwrap();
        let queries = Figures {
            queries: 1000,
            free: 0,
            verified: 1.0,
            depth_median: 0.2,
            depth_p95: 0.9,
            lower_over_depth_median: 0.3,
            max_displacement_median: 0.12,
            seconds_median: 3e-4,
            seconds_p95: 1e-3,
            checks_median: 80.0,
        };
        let at_once = Figures { checks_median: 160.0, ..queries.clone() };
        let first = at_once_text(&at_once, &scene, "a.html");
        assert!(["median 160", "1,000 random", "a.html"].iter().all(|part| first.contains(part)), "{first}");
        let report = DemoReport {
            scene: "shelf-arm",
            at_once,
            as_near: 0.98,
            learned: &statistics,
            learning_seconds: 19.9,
            queries,
            page: "a.html".into(),
        };
        let text = report.text(&scene);
        for part in [
            "12,345",
            "97 % on free",
            "same 1,000",
            "100 %",
            "0.200 rad (11.5 deg)",
            "300 us",
            "30 %",
            "2.0 times fewer",
            "98 %",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
    }
}

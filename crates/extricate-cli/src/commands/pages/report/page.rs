//! A report as a page: a verdict, plots with explanations, and the statistics of the model.

use std::fmt::Write;

use extricate::Model;
use extricate_view::{document, escaped};

use super::measure::{Measured, Quality};
use super::plots::{curve, histogram};
use crate::commands::learn::{statistics_rows, word_for};
use crate::report::{count, metric_unit, percent, quantile};

/// Largest number of pairs that are listed.
const MAX_PAIRS: usize = 15;

/// Renders the page of `measured` for the model in the file `name`.
pub fn html(model: &Model, name: &str, measured: &Measured) -> String {
    let unit = metric_unit(model.scene());
    let mut body = format!("<h1>{}</h1>\n<p class=\"verdict\">{}</p>\n", escaped(name), verdict(measured));
    body += "<div class=\"plots\">\n";
    body += &figure(
        "How near answers are, by budget",
        &curve(&points(measured), "checks of a query").to_string(),
        "Share of the queries whose answer is within 5 % of the best that any search found here. The last point is \
         without a budget.",
    );
    body += &figure(
        "Depth",
        &histogram(&measured.depths, 0.0, None, &format!("depth [{unit}]")).to_string(),
        "How far random configurations in collision are from the nearest free one.",
    );
    body += &figure(
        "How much of the depth is proved",
        &histogram(&measured.proved, 0.0, Some(1.0), "lower bound / depth").to_string(),
        "At 1, nothing can be nearer than the answer.",
    );
    body += "</div>\n<h2>Where boundary samples touch</h2>\n";
    body += &touching(measured);
    body += "<h2>Statistics of the model</h2>\n<table>\n";
    for (label, value) in statistics_rows(model.statistics(), unit) {
        let _ = writeln!(body, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&value));
    }
    body += "</table>\n";
    document(name, &body)
}

fn verdict(measured: &Measured) -> String {
    let Quality { checks, within_5pct, excess_p95 } = measured.refined;
    let word = word_for(within_5pct);
    let mut proved = measured.proved.clone();
    format!(
        "{word}: {} of {} random collisions are within 5 % of the best that a longer search found; 19 of 20 answers are \
         farther than it by at most {}. A query takes {checks:.0} checks in the median, and proves {} of the depth.",
        percent(within_5pct),
        count(measured.queries),
        percent(excess_p95),
        percent(quantile(&mut proved, 0.5))
    )
}

fn points(measured: &Measured) -> Vec<(f64, f64)> {
    measured.budgets.iter().chain([&measured.refined]).map(|quality| (quality.checks, quality.within_5pct)).collect()
}

fn figure(title: &str, plot: &str, meaning: &str) -> String {
    format!("<figure><h2>{title}</h2>\n{plot}\n<figcaption>{meaning}</figcaption></figure>\n")
}

fn touching(measured: &Measured) -> String {
    let most = measured.touching.first().map_or(1, |(_, count)| *count).max(1);
    let mut text = format!(
        "<p>Of {} boundary samples, how many touch with a pair. A pair that should matter and is not here was hardly \
         learned; one that is everywhere may overlap by design.</p>\n<table>\n",
        count(measured.samples)
    );
    for ([first, second], times) in measured.touching.iter().take(MAX_PAIRS) {
        let _ = writeln!(
            text,
            "<tr><th>{} &ndash; {}</th><td><meter max=\"{most}\" value=\"{times}\"></meter> {}</td></tr>",
            escaped(first),
            escaped(second),
            count(*times)
        );
    }
    if measured.touching.len() > MAX_PAIRS {
        let _ = writeln!(text, "<tr><td>and {} pairs more</td></tr>", count(measured.touching.len() - MAX_PAIRS));
    }
    text + "</table>\n"
}

//! `extricate check --segments`: checks whether all configurations between two given ones are free.

use extricate::{CheckScratch, Checker, SegmentOptions, SegmentOutcome};
use serde::Serialize;

use crate::input::Configs;
use crate::output::Output;
use crate::progress::Progress;
use crate::{notice, report};

/// JSON output for one segment.
#[derive(Serialize)]
struct Verdict<'a> {
    outcome: &'static str,
    free_until: f64,
    at: Option<f64>,
    pair: Option<[&'a str; 2]>,
}

pub fn check_segments(
    mut configs: Configs,
    checker: &Checker,
    options: &SegmentOptions,
    json: bool,
) -> anyhow::Result<()> {
    let mut scratch = CheckScratch::default();
    let mut out = Output::new(configs.is_stream());
    let mut progress = Progress::beside_rows("checking");
    let (mut free, mut total) = (0, 0);
    while let Some(entry) = configs.next_segment(checker.scene())? {
        for note in configs.take_notes() {
            progress.aside(|| notice::warning(note));
        }
        match entry {
            Ok((line, [from, to])) => {
                if !json && total == 0 {
                    out.line(format_args!("{:>6}  {:<9}  {:>10}  {:>10}  pair", "line", "", "free until", "at"))?;
                }
                let outcome = checker.segment(&from, &to, options, &mut scratch);
                let verdict = verdict(checker, outcome);
                free += usize::from(outcome == SegmentOutcome::Free);
                total += 1;
                if json { out.json(&verdict)? } else { out.line(row(line, &verdict))? }
            }
            Err(bad) => {
                progress.aside(|| configs.report(&bad));
                if json {
                    out.json(&bad)?;
                }
            }
        }
        progress.update(configs.fraction(), || format!("{} segments", report::count(total)));
    }
    if !json && total > 0 {
        let share = report::percent(free as f64 / total as f64);
        out.line(format_args!("{} segments, {} free ({share})", report::count(total), report::count(free)))?;
    }
    out.finish()?;
    drop(progress);
    configs.conclude()
}

fn verdict(checker: &Checker, outcome: SegmentOutcome) -> Verdict<'_> {
    let (outcome, free_until, at, pair) = match outcome {
        SegmentOutcome::Free => ("free", 1.0, None, None),
        SegmentOutcome::Contact { free_until, colliding_at, pair } => {
            ("contact", free_until, Some(colliding_at), Some(pair))
        }
        SegmentOutcome::Undecided { free_until, near_at, pair } => ("undecided", free_until, Some(near_at), Some(pair)),
        _ => ("undecided", 0.0, None, None),
    };
    Verdict { outcome, free_until, at, pair: pair.map(|pair| checker.scene().pair_names(pair)) }
}

fn row(line: usize, verdict: &Verdict) -> String {
    let at = verdict.at.map_or(String::new(), |at| format!("{at:.6}"));
    let pair = verdict.pair.map_or(String::new(), |pair| report::pairs_in_words(&[pair], 1));
    format!("{line:>6}  {:<9}  {:>10.6}  {at:>10}  {pair}", verdict.outcome, verdict.free_until).trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_say_where_and_what() {
        let mut verdict =
            Verdict { outcome: "contact", free_until: 0.25, at: Some(0.250_01), pair: Some(["hand", "table"]) };
        assert_eq!(row(3, &verdict), "     3  contact      0.250000    0.250010  hand - table");
        verdict = Verdict { outcome: "free", free_until: 1.0, at: None, pair: None };
        assert_eq!(row(12, &verdict), "    12  free         1.000000");
        assert_eq!(
            serde_json::to_string(&verdict).unwrap(),
            r#"{"outcome":"free","free_until":1.0,"at":null,"pair":null}"#
        );
    }
}

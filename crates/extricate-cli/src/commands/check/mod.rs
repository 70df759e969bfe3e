//! `extricate check`: reports whether configurations are free, their clearance and colliding pairs.
//! The module `segments` checks segments.

pub mod segments;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use extricate::{CheckScratch, Checker, Config, LEAST_RESOLUTION, Label, SegmentOptions};
use serde::Serialize;

use super::{load_scene, prepare, tell_warnings};
use crate::args::{InputArgs, LoadArgs};
use crate::output::Output;
use crate::progress::Progress;
use crate::{notice, report};
use segments::check_segments;

/// Arguments of `check`.
#[derive(Args)]
#[command(
    after_help = "With --json, each line is one object: free (bool), clearance [m] (least signed distance of any checked \
                        pair; negative if two overlap, null if no pair is checked), colliding (list of [name, name]). \
                        `free` means that every checked pair keeps the scene's clearance.\n\n\
                        With --segments, each line of input is a pair of configurations, {\"from\": [...], \"to\": [...]} or an \
                        array of two. The command checks the whole segment between them, along the geodesic. With --json: \
                        outcome (\"free\": every configuration of the segment is proved free; \"contact\"; \"undecided\": two \
                        bodies come so near to the clearance that neither is proved), free_until (fraction of the segment that \
                        is proved free), at (fraction at which a configuration collides, or nearly collides if undecided; null \
                        if free), pair ([name, name] or null)."
)]
pub struct CheckArgs {
    /// Scene file (TOML), URDF or model file
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    /// Check the segments between pairs of configurations, not single configurations
    #[arg(long, conflicts_with = "q")]
    segments: bool,
    /// With --segments: resolution in metres; a contact is located within about this much motion
    #[arg(long, value_name = "METRES", requires = "segments", value_parser = parse_resolution, default_value = "1e-4")]
    resolution: f64,
    #[command(flatten)]
    load: LoadArgs,
}

/// JSON output for one configuration.
#[derive(Serialize)]
struct Verdict<'a> {
    free: bool,
    clearance: f64,
    colliding: Vec<[&'a str; 2]>,
}

pub fn run(args: &CheckArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?;
    let scene = Arc::new(load_scene(&args.scene, &args.load)?);
    tell_warnings(&scene);
    let checker = prepare(scene.clone());
    if args.segments {
        return check_segments(configs, &checker, &SegmentOptions::default().resolution(args.resolution), json);
    }
    let mut scratch = CheckScratch::default();
    let mut out = Output::new(configs.is_stream());
    let mut progress = Progress::beside_rows("checking");
    let (mut free, mut total) = (0, 0);
    while let Some(entry) = configs.next(&scene)? {
        for note in configs.take_notes() {
            progress.aside(|| notice::warning(note));
        }
        match entry {
            Ok((line, q)) => {
                if !json && total == 0 {
                    out.line(format_args!("{:>6}  {:<9}  {:>14}  colliding pairs", "line", "", "clearance [mm]"))?;
                }
                let verdict = judge(&checker, &q, &mut scratch);
                free += usize::from(verdict.free);
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
        progress.update(configs.fraction(), || report::counted(total, "configuration", "configurations"));
    }
    if !json && total > 0 {
        let share = report::percent(free as f64 / total as f64);
        out.line(format_args!(
            "{}, {} free ({share})",
            report::counted(total, "configuration", "configurations"),
            report::count(free)
        ))?;
    }
    out.finish()?;
    drop(progress);
    configs.conclude()
}

fn parse_resolution(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(metres) if metres >= LEAST_RESOLUTION && metres.is_finite() => Ok(metres),
        _ => Err(format!("expected a length of at least {LEAST_RESOLUTION} m")),
    }
}

fn judge<'a>(checker: &'a Checker, q: &Config, scratch: &mut CheckScratch) -> Verdict<'a> {
    let free = checker.label(q, scratch) == Label::Free;
    let mut pairs = Vec::new();
    if !free {
        checker.colliding_pairs(q, scratch, &mut pairs);
    }
    let clearance = checker.clearance(q, scratch);
    Verdict { free, clearance, colliding: report::pair_names(checker.scene(), &pairs) }
}

fn row(line: usize, verdict: &Verdict) -> String {
    let word = if verdict.free { "free" } else { "colliding" };
    let pairs = report::pairs_in_words(&verdict.colliding, usize::MAX);
    format!("{line:>6}  {word:<9}  {:>14}  {pairs}", report::fixed(verdict.clearance * 1e3, 3)).trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_say_what_collides() {
        let mut verdict = Verdict { free: false, clearance: -0.0125, colliding: vec![["a", "b"], ["c", "d"]] };
        assert_eq!(row(7, &verdict), "     7  colliding         -12.500  a - b, c - d");
        verdict = Verdict { free: false, clearance: -1e-9, colliding: vec![["a", "b"]] };
        assert_eq!(row(7, &verdict), "     7  colliding           0.000  a - b");
        verdict = Verdict { free: true, clearance: 0.5, colliding: vec![] };
        assert_eq!(row(12, &verdict), "    12  free              500.000");
    }

    #[test]
    fn an_infinite_clearance_is_null() {
        let verdict = Verdict { free: true, clearance: f64::INFINITY, colliding: vec![] };
        assert_eq!(serde_json::to_string(&verdict).unwrap(), r#"{"free":true,"clearance":null,"colliding":[]}"#);
    }
}

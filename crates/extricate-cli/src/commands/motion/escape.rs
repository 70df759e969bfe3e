//! `extricate escape`: finds a path out of collision for each of many configurations.

use std::cell::OnceCell;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use extricate::{Escape, EscapeMethod, EscapeOptions, Scene};
use serde::Serialize;

use super::config;
use crate::args::{self, InputArgs, LoadArgs, length, seconds, seed, whole};
use crate::commands::{kept_links, load_solver, with_advice};
use crate::input::BadLine;
use crate::output::Output;
use crate::progress::Progress;
use crate::{notice, report};

/// Help text on the keys of `--json`.
const KEYS: &str = "The path is proved: only pairs of bodies that collide at the query collide on it, and none of them gets \
deeper by more than the tolerance. With --json, each line is one object, in the order of the input: points (configurations, \
the query first; empty if no path was found), free_from (index into points; the path is proved free from this point on), \
method (\"free\": the query is free, \"nearest\": a straight edge to the nearest exit, \"exit\": a straight edge to another \
exit, \"pushed\": the colliding pairs were separated step by step, \"grown\": trees; null if no path was found), colliding \
(list of [name, name], signed distance [m]), deepening (most that any of these pairs was measured deeper than at the query \
[m]), needed_tolerance (if no path was found: the least of 1, 2, 5 and 10 mm, in metres, with which, as a larger --tolerance, \
there is one; else null), length (in the scene's metric), max_displacement [m], checks, error (only if no path was found: a message, which also \
names the pairs that collide in all tested configurations, if there are any).";

/// Arguments of `escape`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct EscapeArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    /// Clearance in metres for the end of a path; a near end with less clearance, at least the
    /// scene's, is preferred to a far one. The default is the scene's clearance plus 1 mm
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true)]
    aim: Option<f64>,
    /// Depth in metres by which a pair that collides at the query may get deeper on the path
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, default_value = "1e-3")]
    tolerance: f64,
    /// Links that keep their places all along the path: a name or JSON, as for `query --keep`
    #[arg(long, value_name = "LINK")]
    keep: Option<String>,
    /// Prefer the exit nearest to this configuration, among exits about as near as the nearest one
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    toward: Option<String>,
    /// Try straight edges to up to K exits
    #[arg(long, value_name = "K", value_parser = args::exits, allow_negative_numbers = true, default_value_t = 6)]
    exits: usize,
    /// Spend at most N checks on the trees, which grow only if nothing simpler leads out of
    /// collision
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = 20_000)]
    tree_checks: usize,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Give up on a query after about this many checks
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    max_checks: Option<usize>,
    /// Give up on a query after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Find paths in this world, as for `query`
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

/// JSON output for one path.
#[derive(Serialize)]
pub struct Row<'a> {
    points: &'a [Vec<f64>],
    free_from: usize,
    method: Option<EscapeMethod>,
    colliding: Vec<([&'a str; 2], f64)>,
    deepening: f64,
    needed_tolerance: Option<f64>,
    length: f64,
    max_displacement: f64,
    checks: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a str>,
}

impl<'a> Row<'a> {
    /// `error` is the reason if no path was found.
    pub fn new(escape: &'a Escape, scene: &'a Scene, error: Option<&'a str>) -> Self {
        let colliding = escape.colliding.iter().map(|(pair, distance)| (scene.pair_names(*pair), *distance)).collect();
        let Escape { points, free_from, method, deepening, length, max_displacement, checks, .. } = escape;
        let needed_tolerance = escape.needed_tolerance;
        let (free_from, method, deepening, length) = (*free_from, *method, *deepening, *length);
        let (max_displacement, checks) = (*max_displacement, *checks);
        Self {
            points,
            free_from,
            method,
            colliding,
            deepening,
            needed_tolerance,
            length,
            max_displacement,
            checks,
            error,
        }
    }

    fn text(&self, line: usize) -> String {
        let method = self.method.map_or("none", EscapeMethod::name);
        let (points, from) = (self.points.len(), self.free_from);
        let (length, moved, checks) = (self.length, self.max_displacement, report::count(self.checks));
        format!("{line:>6}  {method:<8}  {points:>6}  {from:>9}  {length:>10.4}  {moved:>9.4}  {checks:>8}")
    }
}

fn header(unit: &str) -> String {
    let length = format!("[{unit}]");
    format!(
        "{:>6}  {:<8}  {:>6}  {:>9}  {length:>10}  {:>9}  {:>8}",
        "line", "found by", "points", "free from", "moved [m]", "checks"
    )
}

pub fn run(args: &EscapeArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?;
    let solver = load_solver(&args.file, args.world.as_deref(), &args.load)?;
    let mut options = EscapeOptions::default().tolerance(args.tolerance).exits(args.exits).seed(args.seed);
    (options.aim, options.tree_checks) = (args.aim, args.tree_checks);
    options.termination = args::termination(args.max_checks, args.max_seconds);
    let scene = solver.scene();
    options.keep = kept_links(args.keep.as_deref(), scene)?;
    options.toward = args.toward.as_ref().map(|words| config("--toward", words, scene)).transpose()?;
    let told = OnceCell::new();
    let no_path = || told.get_or_init(|| with_advice("no path was found", &solver)).as_str();
    // A path may take minutes, so each is flushed: a later failure does not lose it.
    let mut out = Output::new(true);
    let mut progress = Progress::beside_rows("escaping");
    let (mut total, mut found) = (0, 0);
    while let Some(entry) = configs.next(scene)? {
        for note in configs.take_notes() {
            progress.aside(|| notice::warning(note));
        }
        let answered = entry.and_then(|(line, q)| {
            let escape = solver.escape(&q, &options);
            escape.map(|escape| (line, escape)).map_err(|error| BadLine { line, error: error.to_string() })
        });
        match answered {
            Ok((line, escape)) => {
                if !json && total == 0 {
                    out.line(header(report::metric_unit(scene)))?;
                }
                total += 1;
                found += usize::from(escape.is_found());
                let row = Row::new(&escape, scene, (!escape.is_found()).then(&no_path));
                if json { out.json(&row)? } else { out.line(row.text(line))? }
            }
            Err(bad) => {
                progress.aside(|| configs.report(&bad));
                if json {
                    out.json(&bad)?;
                }
            }
        }
        progress.update(configs.fraction(), || report::counted(total, "path", "paths"));
    }
    drop(progress);
    let all = report::counted(total, "query", "queries");
    let missing = format!("{} of {all}", report::count(total - found));
    if !json && total > 0 {
        let share = report::percent(found as f64 / total as f64);
        if let Some(told) = report::what_a_unit_is(scene, "`weights` of the metric") {
            out.line(format_args!("\nin lengths, {told}"))?;
        }
        out.line(format_args!("\nfound a path for {} of {all} ({share})", report::count(found)))?;
    }
    out.finish()?;
    let none = || with_advice("none was found", &solver);
    match (configs.conclude(), found < total) {
        (Ok(()), false) => Ok(()),
        (Ok(()), true) => bail!("found no path for {missing}: {}", none()),
        (Err(bad), false) => Err(bad),
        (Err(bad), true) => bail!("{bad}; found no path for {missing}: {}", none()),
    }
}

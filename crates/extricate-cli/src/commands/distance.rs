//! `extricate distance`: how far configurations are from the boundary of the free ones.

use std::cell::OnceCell;
use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use extricate::{Config, QueryOptions, Scene, SignedDistance};
use serde::Serialize;

use crate::args::{self, InputArgs, LoadArgs, above_zero, seconds, whole};
use crate::commands::{load_solver, with_advice};
use crate::input::BadLine;
use crate::output::Output;
use crate::progress::Progress;
use crate::report;

/// Help text on the keys of `--json`.
const KEYS: &str = "Distances are in the scene's metric: negative for a configuration that collides, where it is minus the \
depth, else the distance to the nearest configuration in contact. Limits of joints are no contacts. With --json, each line is \
one object, in the order of the input: distance (null if nothing in contact was found, or none within --within), bound (proved, \
of the same sign: nothing nearer is on the other side), witness (the nearest free configuration, or the nearest in contact, \
which is free and just touches; null if there is none), gradient (of the distance, in tangent coordinates), pairs ([name, name] \
of the bodies that collide, or that touch at the witness), checks, cut_short (whether a limit ended the search).";

/// Message for a colliding configuration without an answer.
const NONE_FREE: &str = "no free configuration was found";

/// Arguments of `distance`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct DistanceArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    /// End the search for a free configuration once nothing is proved to touch within this
    /// distance, in the scene's metric
    #[arg(long, value_name = "D", value_parser = above_zero, allow_negative_numbers = true)]
    within: Option<f64>,
    /// Give up on a configuration after about this many checks
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    max_checks: Option<usize>,
    /// Give up on a configuration after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Threads that work; 0 for one per core
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = 0)]
    threads: usize,
    /// Measure in this world, as for `query`
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

/// JSON output for one configuration.
#[derive(Serialize)]
struct Row<'a> {
    distance: f64,
    bound: f64,
    witness: Option<&'a [f64]>,
    gradient: &'a [f64],
    pairs: Vec<[&'a str; 2]>,
    checks: usize,
    cut_short: bool,
}

impl<'a> Row<'a> {
    fn new(found: &'a SignedDistance, scene: &'a Scene) -> Self {
        let SignedDistance { distance, bound, witness, gradient, pairs, checks, cut_short, .. } = found;
        Self {
            distance: *distance,
            bound: *bound,
            witness: witness.as_deref(),
            gradient,
            pairs: pairs.iter().map(|pair| scene.pair_names(*pair)).collect(),
            checks: *checks,
            cut_short: *cut_short,
        }
    }

    fn text(&self, line: usize) -> String {
        let pair = self.pairs.first().map_or(String::new(), |[a, b]| format!("{a}, {b}"));
        let (distance, bound) = (self.distance, self.bound);
        let checks = report::count(self.checks);
        format!("{line:>6}  {distance:>14.4}  {bound:>10.4}  {checks:>8}  {pair}").trim_end().into()
    }
}

pub fn run(args: &DistanceArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?;
    let limits = args::termination(args.max_checks, args.max_seconds);
    let solver = load_solver(&args.file, args.world.as_deref(), &args.load)?
        .options(QueryOptions::default().termination(limits))?;
    let scene = solver.scene();
    let told = OnceCell::new();
    let none_free = || told.get_or_init(|| with_advice(NONE_FREE, &solver)).as_str();
    let mut out = Output::new(configs.is_stream());
    let mut progress = Progress::beside_rows("measuring");
    let (mut total, mut missing) = (0, 0);
    loop {
        let block = configs.next_block(scene, args.threads, &progress)?;
        if block.is_empty() {
            break;
        }
        let queries: Vec<Config> = block.iter().flatten().map(|(_, q)| q.clone()).collect();
        let mut found = Vec::with_capacity(queries.len());
        solver.signed_distances(queries, args.within, args.threads, &mut |answered| {
            found.push(answered.answer);
            ControlFlow::Continue(())
        })?;
        let mut found = found.into_iter();
        for entry in block {
            let bad = match entry {
                Ok((line, _)) => match found.next().flatten() {
                    Some(distance) => {
                        if !json && total == 0 {
                            out.line(header(report::metric_unit(scene)))?;
                        }
                        total += 1;
                        let row = Row::new(&distance, scene);
                        if json {
                            out.json(&row)?
                        } else {
                            out.line(row.text(line))?
                        }
                        continue;
                    }
                    None => {
                        missing += 1;
                        progress.aside(|| configs.report(&BadLine { line, error: NONE_FREE.into() }));
                        BadLine { line, error: none_free().into() }
                    }
                },
                Err(bad) => bad,
            };
            if json {
                out.json(&bad)?;
            }
        }
        progress.update(configs.fraction(), || report::counted(total, "distance", "distances"));
    }
    drop(progress);
    if !json
        && total > 0
        && let Some(told) = report::what_a_unit_is(scene, "`weights` of the metric")
    {
        out.line(format_args!("\nin distances, {told}"))?;
    }
    out.finish()?;
    configs.conclude()?;
    if missing > 0 {
        let have = if missing == 1 { "configuration has" } else { "configurations have" };
        bail!("{} {have} no distance: {}", report::count(missing), none_free());
    }
    Ok(())
}

fn header(unit: &str) -> String {
    let unit = format!("[{unit}]");
    format!("{:>6}  {:>14}  {:>10}  {:>8}  pair", "line", format!("distance {unit}"), "bound", "checks")
}

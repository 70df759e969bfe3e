//! `extricate repair`: a path that collides as one that is proved free.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use extricate::{RepairOptions, Repaired, Rows, Termination};
use serde::Serialize;

use crate::args::{LoadArgs, length, seconds, seed, whole};
use crate::commands::query::asker::Asked;
use crate::input::Configs;
use crate::notice;
use crate::output::Output;
use crate::progress::busy;
use crate::report;

/// What is printed.
const KEYS: &str = "Prints the path: one {\"q\": [...], \"place\": 2.25} a line, which the other commands read; place is where \
on the old path the configuration stands for, here a quarter of the edge from row 2 to row 3 (rows count from 0). Every \
configuration between two lines, along the geodesic, is proved free. With --json, one object: points (empty where no path \
was found), places, deviation (largest distance of a point from its place, in the scene's metric), length, length_before, \
stretches (that were replaced), gaps (that trees closed), checks. Exit status 1 where no path was found, which proves \
nothing.";

/// Arguments of `repair`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct RepairArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// The path, one configuration a line, as for `query --input`; `-` reads standard input
    #[arg(long, value_name = "FILE")]
    path: PathBuf,
    /// Clearance in metres that configurations are pushed out to, or as much of it as is kept
    /// nearby. By default a tenth of the radius of the smallest moving body beyond the scene's
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true)]
    aim: Option<f64>,
    /// Most that the new path may be from the old one, and rows that are cut off from the new one,
    /// in the scene's metric
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    max_deviation: Option<f64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Give up after about this many checks
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = 100_000)]
    max_checks: usize,
    /// Give up after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Repair in this world, as for `query`: the one in which an obstacle has moved
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Line<'a> {
    q: &'a [f64],
    place: f64,
}

/// Runs the command.
pub fn run(args: &RepairArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = Configs::open(&args.path)?;
    let asked = Asked::load(&args.file, args.world.as_deref(), &args.load)?;
    let scene = asked.scene();
    let mut points = Vec::new();
    while let Some(entry) = configs.next(scene)? {
        configs.take_notes().iter().for_each(notice::warning);
        match entry {
            Ok((_, q)) => points.extend_from_slice(&q),
            // A path without one of its rows is another path.
            Err(bad) => bail!("{}: line {}: {}", args.path.display(), bad.line, bad.error),
        }
    }
    configs.conclude()?;
    let termination = Termination { max_checks: Some(args.max_checks), max_seconds: args.max_seconds, stop: None };
    let (aim, max_deviation, seed) = (args.aim, args.max_deviation, args.seed);
    let options = RepairOptions { aim, max_deviation, seed, termination, ..RepairOptions::default() };
    let rows = Rows::new(&points, scene.space.nq())?;
    let repaired = busy("repairing", || asked.view().repair(rows, &options))?;
    print(&repaired, json, report::metric_unit(scene))?;
    if !repaired.is_found() {
        bail!("no path was found in {} checks", report::count(repaired.checks));
    }
    Ok(())
}

fn print(repaired: &Repaired, json: bool, unit: &str) -> anyhow::Result<()> {
    let mut out = Output::new(false);
    if json {
        out.json(repaired)?;
        return out.finish();
    }
    for (q, place) in repaired.points.iter().zip(&repaired.places) {
        out.json(&Line { q, place: *place })?;
    }
    out.finish()?;
    if repaired.is_found() {
        let Repaired { stretches, deviation, length, length_before, checks, .. } = repaired;
        let checks = report::count(*checks);
        notice::note(format_args!(
            "{stretches} stretches replaced, at most {deviation:.4} {unit} away; {length:.4} {unit} long, before {length_before:.4}; {checks} checks"
        ));
    }
    Ok(())
}

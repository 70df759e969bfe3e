//! `extricate repair`: turns a path that collides into one that is proved free.

use std::path::PathBuf;

use anyhow::{anyhow, bail};
use clap::Args;
use extricate::{RepairOptions, Repaired, Rows, Scene};
use serde::Serialize;

use crate::args::{self, LoadArgs, length, seconds, seed, whole};
use crate::commands::{kept_links, load_solver};
use crate::input::Configs;
use crate::notice;
use crate::output::Output;
use crate::progress::busy;
use crate::report;

/// Help text on the output.
const KEYS: &str = "Prints the path, one {\"q\": [...], \"place\": 2.25} per line, which the other commands read. place is the \
position on the old path that corresponds to the configuration: 2.25 is a quarter of the edge from row 2 to row 3 (rows count \
from 0). Every configuration between two lines, along the geodesic, is proved free. With --json, prints one object: points \
(empty if no path was found), places, deviation (largest distance of a point from its place, in the scene's metric), length, \
length_before, stretches (number of replaced stretches), gaps (number of gaps that trees closed), checks. If no path was \
found, the exit status is 1; that does not prove that there is none.";

/// Arguments of `repair`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct RepairArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// File of the path: one configuration per line, as for `query --input`; or one line with the
    /// whole path, as for `view --paths`: an array, {"path": [...]} or a JointTrajectory. `-` reads
    /// standard input
    #[arg(long, value_name = "FILE")]
    path: PathBuf,
    /// Clearance in metres to which configurations are pushed out, or as much of it as they can
    /// keep nearby. The default is the scene's clearance plus a tenth of the radius of the smallest
    /// moving body
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true)]
    aim: Option<f64>,
    /// Largest distance between the new path and the old one, also for rows of the old path that
    /// the new one cuts off, in the scene's metric
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    max_deviation: Option<f64>,
    /// Links that keep their places at the first line, all along the path: a name or JSON, as for
    /// `query --keep`. With --frames, each line keeps them where it has them
    #[arg(long, value_name = "LINK")]
    keep: Option<String>,
    /// Take the lines as frames of a motion: print one configuration for each, at the same time,
    /// 0.5 mm off what it touches unless --aim says otherwise
    #[arg(long)]
    frames: bool,
    /// With --frames, but not with --keep: longest step from frame to frame, in the scene's metric;
    /// the result lags behind longer steps
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true, requires = "frames")]
    max_step: Option<f64>,
    /// With --frames, keep contacts: pairs of bodies that are at most this far beyond the clearance
    /// in a line, or overlap there, stay as near if they can
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, requires = "frames")]
    touch: Option<f64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Give up after about this many checks
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = 100_000)]
    max_checks: usize,
    /// Give up after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Repair in this world, as for `query`, such as one in which an obstacle has moved
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

pub fn run(args: &RepairArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = Configs::open(&args.path)?;
    let solver = load_solver(&args.file, args.world.as_deref(), &args.load)?;
    let scene = solver.scene();
    let points = path_of(&mut configs, scene, args)?;
    configs.conclude()?;
    let mut options = RepairOptions::default().seed(args.seed);
    (options.aim, options.max_deviation) = (args.aim, args.max_deviation);
    (options.frames, options.max_step, options.touch) = (args.frames, args.max_step, args.touch);
    options.keep = kept_links(args.keep.as_deref(), scene)?;
    options.termination = args::termination(Some(args.max_checks), args.max_seconds);
    let rows = Rows::new(&points, scene.space().nq())?;
    let repaired = busy("repairing", || solver.repair(rows, &options))?;
    print(&repaired, json, report::metric_unit(scene))?;
    if !repaired.is_found() {
        bail!("no path was found in {}", report::counted(repaired.checks, "check", "checks"));
    }
    Ok(())
}

/// Reads all coordinates of the waypoints, one after another.
fn path_of(configs: &mut Configs, scene: &Scene, args: &RepairArgs) -> anyhow::Result<Vec<f64>> {
    let (mut points, mut whole) = (Vec::new(), None);
    let file = args.path.display();
    while let Some(entry) = configs.next_waypoints(scene)? {
        configs.take_notes().iter().for_each(notice::warning);
        // Without one of its rows it would be another path, so a bad line is an error.
        let (line, waypoints) = entry.map_err(|bad| anyhow!("{file}: line {}: {}", bad.line, bad.error))?;
        let is_whole = waypoints.len() > 1;
        if let Some(other) = whole.or((is_whole && !points.is_empty()).then_some(line)) {
            bail!("{file}: line {other}: got a whole path and more lines, expected one path");
        }
        whole = is_whole.then_some(line);
        waypoints.iter().for_each(|q| points.extend_from_slice(q));
    }
    Ok(points)
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
        let checks = report::counted(*checks, "check", "checks");
        let stretches = report::counted(*stretches, "stretch", "stretches");
        notice::note(format_args!(
            "{stretches} replaced, at most {deviation:.4} {unit} away; {length:.4} {unit} long, before {length_before:.4}; {checks}"
        ));
    }
    Ok(())
}

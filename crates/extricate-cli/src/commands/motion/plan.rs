//! `extricate plan`: finds a proved path between two free configurations.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use extricate::files::{OutputLock, check_not_read, check_roadmap_output, load_roadmap, save_roadmap};
use extricate::{Config, Plan, PlanMethod, PlanOptions, Roadmap, Scene, Stop};
use serde::Serialize;

use crate::args::{self, LoadArgs, length, seconds, seed, threads, whole};
use crate::commands::load_solver;
use crate::input::Configs;
use crate::interrupt::{StopOnInterrupt, uninterrupted};
use crate::notice;
use crate::output::Output;
use crate::progress::busy;
use crate::report;

/// Help text on the output.
const KEYS: &str = "Prints the path: one {\"q\": [...]} a line, from the first to the last configuration, which the other \
commands read; every configuration between two lines, along the geodesic, is proved free. With --json, one object: points, \
method (\"straight\", \"trees\" or \"roadmap\"; null where no path was found, and points is then empty), length (in the \
scene's metric), checks, nodes (of the roadmap). Exit status 1 where no path was found, which proves nothing.";

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct PlanArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// Where the path begins, a free configuration: its coordinates between commas
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    from: String,
    /// Where it ends
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    to: String,
    /// Begin with the roadmap in this file, where there is one, and leave what was added to it
    /// there
    #[arg(long, value_name = "FILE")]
    roadmap: Option<PathBuf>,
    /// How finely edges are proved, in metres: what passes something nearer than about this is not
    /// found
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, default_value = "1e-4")]
    resolution: f64,
    /// Leave the path as it was found, with points that are not needed
    #[arg(long)]
    no_shortcut: bool,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Give up after about this many checks
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = 1_000_000)]
    max_checks: usize,
    /// Give up after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Grow the roadmap on this many threads, 0 for one a core; the path is the same
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true, default_value_t = 0)]
    threads: usize,
    /// Plan in this world, as for `query`
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Line<'a> {
    q: &'a [f64],
}

pub fn run(args: &PlanArgs, json: bool) -> anyhow::Result<()> {
    let solver = load_solver(&args.file, args.world.as_deref(), &args.load)?;
    let scene = solver.scene();
    let (from, to) = (config("--from", &args.from, scene)?, config("--to", &args.to, scene)?);
    // Hold the lock from reading to writing; otherwise additions of another run would be lost.
    let _lock = args.roadmap.as_deref().map(|path| hold(path, args)).transpose()?;
    let mut roadmap = match &args.roadmap {
        Some(path) if path.exists() => load_roadmap(path, scene)?,
        _ => Roadmap::new(scene.space(), args.seed),
    };
    if let Some(path) = &args.roadmap {
        check_roadmap_output(path)?;
    }
    let listening = Arc::new(StopOnInterrupt::new());
    let stop = Stop::when(move || listening.asked());
    let options = PlanOptions::default()
        .resolution(args.resolution)
        .shortcut(!args.no_shortcut)
        .seed(args.seed)
        .threads(args.threads)
        .termination(args::termination(Some(args.max_checks), args.max_seconds).stop(stop.clone()));
    let plan = busy("planning", || solver.plan_with(&from, &to, &options, &mut roadmap))?;
    let was_stopped = stop.is_asked();
    // Print the path first, so that it is not lost if the roadmap cannot be written.
    let printed = print(&plan, scene, json);
    if let Some(path) = &args.roadmap {
        uninterrupted(|| save_roadmap(&roadmap, path))?;
    }
    printed?;
    match (plan.is_found(), was_stopped) {
        (true, _) => Ok(()),
        (false, true) => bail!("interrupted before a path was found"),
        (false, false) => bail!("no path was found in {}", report::counted(plan.checks, "check", "checks")),
    }
}

fn hold(roadmap: &Path, args: &PlanArgs) -> extricate::Result<OutputLock> {
    check_not_read(roadmap, [args.file.as_path()].into_iter().chain(args.world.as_deref()))?;
    OutputLock::take(roadmap)
}

fn print(plan: &Plan, scene: &Scene, json: bool) -> anyhow::Result<()> {
    let mut out = Output::new(false);
    if json {
        out.json(plan)?;
        return out.finish();
    }
    for q in &plan.points {
        out.json(&Line { q })?;
    }
    out.finish()?;
    if let Some(method) = plan.method {
        let points = report::counted(plan.points.len(), "point", "points");
        let (length, unit) = (plan.length, report::metric_unit(scene));
        let (method, checks) = (PlanMethod::name(method), report::counted(plan.checks, "check", "checks"));
        notice::note(format!("{points}, {length:.4} {unit}, found by {method} in {checks}"));
    }
    Ok(())
}

/// Parses the configuration of an option.
fn config(name: &str, word: &str, scene: &Scene) -> anyhow::Result<Config> {
    let mut configs = Configs::of_word(name, word);
    let entry = configs.next(scene)?.with_context(|| format!("{name}: got nothing, expected a configuration"))?;
    configs.take_notes().iter().for_each(notice::warning);
    entry.map(|(_, q)| q).map_err(|bad| anyhow::anyhow!("{name}: {}", bad.error))
}

//! `extricate plan`: finds a proved path between two free configurations.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use clap::Args;
use extricate::files::{OutputLock, check_not_read, check_roadmap_output, load_roadmap, save_roadmap};
use extricate::{Plan, PlanMethod, PlanOptions, Roadmap, Scene, Stop};
use serde::Serialize;

use super::{config, escape};
use crate::args::{self, LoadArgs, length, seconds, seed, threads, whole};
use crate::commands::{kept_links, load_solver};
use crate::interrupt::{StopOnInterrupt, uninterrupted};
use crate::notice;
use crate::output::Output;
use crate::progress::busy;
use crate::report;

/// Help text on the output.
const KEYS: &str = "Prints the path from the first to the last configuration, one {\"q\": [...]} per line, which the other \
commands read. Every configuration between two lines, along the geodesic, is proved free. If an end collides, the path begins \
or ends with an escape, on which collisions are proved to get no worse; a note says where the free part begins and ends. With \
--json, prints one object: points (empty if no path was found), free_from and free_to (indices into points; between them the \
path is proved free), start_escape and goal_escape (an object of `escape --json`; null if that end is free), method \
(\"straight\", \"trees\" or \"roadmap\"; null if no path was found), length (in the scene's metric), checks, nodes (in the \
roadmap), error (only if no path was found: the reason). If no path was found, the exit status is 1; that does not prove that \
there is none.";

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct PlanArgs {
    /// Scene file (TOML) or URDF, or a model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// Start of the path: the coordinates of a configuration, separated by commas
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    from: String,
    /// End of the path, in the same form
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    to: String,
    /// Start with the roadmap in this file, if the file exists, and save the extended roadmap to it
    #[arg(long, value_name = "FILE")]
    roadmap: Option<PathBuf>,
    /// Resolution in metres at which edges are proved; a path that passes a body at less than about
    /// this distance is not found
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, default_value = "1e-4")]
    resolution: f64,
    /// Depth in metres by which a pair that collides at an end may get deeper on the path
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, default_value = "1e-3")]
    tolerance: f64,
    /// Links that keep their places at the start, all along the path: a name or JSON, as for `query
    /// --keep`. The roadmap is then neither used nor extended
    #[arg(long, value_name = "LINK")]
    keep: Option<String>,
    /// Clearance in metres to which points of the free path are pushed off, or as much of it as
    /// they can keep nearby; without it the path is left short. Not with --keep
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Keep the path as it was found instead of shortening it
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
    /// Number of threads that grow the roadmap, 0 for one per core; the path does not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true, default_value_t = 0)]
    threads: usize,
    /// Plan in this world, as for `query`
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

/// Colliding pairs that a message names at most.
const MAX_NAMED_PAIRS: usize = 5;

/// JSON output.
#[derive(Serialize)]
struct Row<'a> {
    points: &'a [Vec<f64>],
    free_from: usize,
    free_to: usize,
    start_escape: Option<escape::Row<'a>>,
    goal_escape: Option<escape::Row<'a>>,
    method: Option<PlanMethod>,
    length: f64,
    checks: usize,
    nodes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
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
    let mut options = PlanOptions::default()
        .resolution(args.resolution)
        .tolerance(args.tolerance)
        .shortcut(!args.no_shortcut)
        .seed(args.seed)
        .threads(args.threads)
        .termination(args::termination(Some(args.max_checks), args.max_seconds).stop(stop.clone()));
    options.clearance = args.clearance;
    options.keep = kept_links(args.keep.as_deref(), scene)?;
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
        (false, false) => bail!(no_path(&plan, scene)),
    }
}

fn hold(roadmap: &Path, args: &PlanArgs) -> extricate::Result<OutputLock> {
    check_not_read(roadmap, [args.file.as_path()].into_iter().chain(args.world.as_deref()))?;
    OutputLock::take(roadmap)
}

fn print(plan: &Plan, scene: &Scene, json: bool) -> anyhow::Result<()> {
    let mut out = Output::new(false);
    if json {
        let error = (!plan.is_found()).then(|| no_path(plan, scene));
        let [start_escape, goal_escape] = [&plan.start_escape, &plan.goal_escape]
            .map(|found| found.as_ref().map(|found| escape::Row::new(found, scene, None)));
        let Plan { points, free_from, free_to, method, length, checks, nodes, .. } = plan;
        let (free_from, free_to, method, length) = (*free_from, *free_to, *method, *length);
        let (checks, nodes) = (*checks, *nodes);
        out.json(&Row { points, free_from, free_to, start_escape, goal_escape, method, length, checks, nodes, error })?;
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
        if plan.start_escape.is_some() || plan.goal_escape.is_some() {
            let (from, to) = (1 + plan.free_from, 1 + plan.free_to);
            notice::note(format!(
                "proved free from line {from} to line {to}; before and after, collisions get no worse"
            ));
        }
    }
    Ok(())
}

/// Says why there is no path: an end that no escape leads out of, or the search in between.
fn no_path(plan: &Plan, scene: &Scene) -> String {
    let checks = report::counted(plan.checks, "check", "checks");
    for (end, found) in [("--from", &plan.start_escape), ("--to", &plan.goal_escape)] {
        if let Some(found) = found.as_ref().filter(|found| !found.is_found()) {
            let pairs: Vec<String> = found
                .colliding
                .iter()
                .take(MAX_NAMED_PAIRS)
                .map(|(pair, _)| scene.pair_names(*pair).join(" and "))
                .collect();
            let tolerance = found.needed_tolerance.map_or(String::new(), |tolerance| {
                format!("; with --tolerance {tolerance} there is a path out of collision")
            });
            return format!(
                "no path was found in {checks}: {end} collides ({}), and no path leads out of collision{tolerance}",
                pairs.join(", ")
            );
        }
    }
    format!("no path was found in {checks}")
}

//! `extricate view`: writes a scene, configurations in it and their answers as one page for a
//! browser.
//!
//! `answers` reads the output of `query --json`, and `serve` serves the page to browsers of this
//! computer.

mod answers;
mod serve;

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use extricate::geometry::Body;
use extricate::{Config, Effort, QueryOptions, Solver, StreamOptions, files};
use extricate_view::{Live, is_page};
use serde_json::json;

use crate::args::{Limits, LoadArgs, exits, port, positive, seed};
use crate::commands::grasp::mesh_object;
use crate::commands::query::{Timed, ask, effort};
use crate::commands::{draw_colliding, load_solver};
use crate::input::Configs;
use crate::notice;
use crate::output::Output;
use crate::pages::{self, About, Shown, name_of};
use crate::progress::Progress;
use crate::report::count;
use answers::{Answers, Given};

/// Largest number of queries of a page, which contains them all.
const MAX_QUERIES: usize = 1000;
/// Largest number of waypoints of all paths of a page.
const MAX_WAYPOINTS: usize = 20_000;
/// Exits by default, if the effort finds several.
const DEFAULT_EXITS: usize = 3;

/// Message if no library is available for a live page.
const NOT_BUILT_IN: &str = "--live: this program was built without the library as WebAssembly; \
                            scripts/build-wasm.sh makes it, then give it with --wasm";

/// Arguments of `view`.
#[derive(Args)]
pub struct ViewArgs {
    /// Scene file (TOML), URDF or model file
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    /// A configuration to show: its coordinates, separated by commas. The option may be repeated
    #[arg(long, value_name = "Q", allow_hyphen_values = true, group = "configurations")]
    q: Vec<String>,
    /// File of configurations to show, one per line, in any form that `query` accepts; `-` reads
    /// standard input
    #[arg(long, value_name = "FILE", group = "configurations")]
    input: Option<PathBuf>,
    /// Show this many random colliding configurations if none are given
    #[arg(short = 'n', long = "count", value_name = "N", default_value_t = 5, value_parser = positive, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the random configurations
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Show the answers in this file instead of computing them: lines of `query --json` or `grasp
    /// --json` for the same configurations
    #[arg(long, value_name = "FILE", requires = "configurations", conflicts_with_all = ["exits", "effort"])]
    answers: Option<PathBuf>,
    /// Show the meshes in this folder that the lines of --input name, as for `grasp --objects`
    #[arg(long, value_name = "FOLDER", requires_all = ["input", "answers"], conflicts_with = "stream")]
    objects: Option<PathBuf>,
    /// Treat the configurations as frames of a motion, which the page plays. They are answered as
    /// `query --stream` does
    #[arg(long, requires = "input", conflicts_with_all = ["q", "exits"])]
    stream: bool,
    /// Show the paths in this file instead of configurations, one per line: an array of waypoints,
    /// {"path": [...]} or a JointTrajectory. The exact checker determines which parts are free
    #[arg(long, value_name = "FILE", conflicts_with_all = ["q", "input", "answers", "stream", "exits", "effort"])]
    paths: Option<PathBuf>,
    /// How hard to search, as for `query`
    #[arg(long, value_parser = effort(), default_value_t = Effort::Refined)]
    effort: Effort,
    /// Show up to K distinct exits, at most 9; by default 3, or 1 with an effort that finds only
    /// one
    #[arg(long, value_name = "K", value_parser = exits, allow_negative_numbers = true)]
    exits: Option<usize>,
    /// Show the scene in this world, as for `query`
    #[arg(long, visible_alias = "scene", value_name = "WORLD")]
    world: Option<PathBuf>,
    /// Page to write; an existing one is replaced
    #[arg(short, long, value_name = "FILE.html", default_value = "extricate-view.html")]
    output: PathBuf,
    /// Write no file; serve the page to browsers on this computer until Ctrl-C. Without PORT, a
    /// free port is chosen
    #[arg(long, value_name = "PORT", value_parser = port, num_args = 0..=1, default_missing_value = "0", conflicts_with = "output")]
    serve: Option<u16>,
    /// Put the library into the page: you can drag joints, waypoints of paths and obstacles, and
    /// the answer follows
    #[arg(long, conflicts_with = "objects")]
    live: bool,
    /// With --live: file of the library as WebAssembly, instead of the built-in one
    #[arg(long, value_name = "FILE.wasm", requires = "live")]
    wasm: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArgs,
}

impl ViewArgs {
    pub fn options(&self) -> QueryOptions {
        QueryOptions::default().effort(self.effort).exits(self.exits()).contacts(true)
    }

    fn exits(&self) -> usize {
        let usual = match self.effort {
            Effort::Nearest | Effort::Proved => 1,
            _ if self.stream => 1,
            _ => DEFAULT_EXITS,
        };
        self.exits.unwrap_or(usual)
    }
}

pub fn run(args: &ViewArgs, json: bool) -> anyhow::Result<()> {
    if args.serve.is_none() {
        let read = [&args.input, &args.answers, &args.paths, &args.world, &args.wasm];
        let read = read.into_iter().flatten().chain([&args.file]);
        files::check_not_read(&args.output, read.map(PathBuf::as_path))?;
        files::check_output(&args.output, "page of this program", is_page)?;
    }
    let solver = load_solver(&args.file, args.world.as_deref(), &args.load)?.options(args.options())?;
    let (shown, input) = match &args.paths {
        Some(path) => {
            let mut lines = Configs::open(path)?.with_limits(Limits::Forgive);
            (paths(&mut lines, &solver)?, Some(lines))
        }
        None => answered(args, &solver)?,
    };
    let html = page(args, &solver, shown)?;
    let mut out = Output::new(true);
    match args.serve {
        Some(port) => serve::serve(html.as_bytes(), port, |address| {
            let text = format!("http://{address}/ shows the page until Ctrl-C");
            if json { out.json(&json!({ "address": format!("http://{address}/") })) } else { out.line(text) }
        })?,
        None => {
            files::write_atomically(&args.output, html.as_bytes())?;
            let (page, bytes) = (args.output.display().to_string(), html.len());
            match json {
                true => out.json(&json!({ "page": page, "bytes": bytes }))?,
                false => out.line(format_args!("wrote {page} ({} kB); any browser shows it", count(bytes / 1000)))?,
            }
            out.finish()?;
        }
    }
    input.map_or(Ok(()), |configs| configs.conclude())
}

/// Returns configurations with their answers, and their input.
fn answered(args: &ViewArgs, solver: &Solver) -> anyhow::Result<(Vec<Shown>, Option<Configs>)> {
    let input = match (&args.input, args.q.is_empty()) {
        (Some(path), _) => Some(Configs::open(path)?),
        (None, false) => Some(Configs::of_words(&args.q)),
        (None, true) => None,
    };
    let mut input = input.map(|configs| configs.with_limits(Limits::Forgive));
    let (queries, objects) = match &mut input {
        Some(configs) => read(configs, solver, args)?,
        None => (draw(args, solver)?, Vec::new()),
    };
    let given = match &args.answers {
        Some(path) => Answers::open(path)?.read(solver.scene(), queries.len())?,
        None => answer(args, solver, &queries)?.into_iter().map(Given::Answer).collect(),
    };
    let objects = objects.into_iter().chain(std::iter::repeat(None));
    let shown = queries.into_iter().zip(given).zip(objects).map(|((q, given), object)| match given {
        Given::Answer(timed) => Shown::Answer(q, timed),
        Given::Grasp(grasp) => Shown::Grasp(q, grasp, object),
    });
    Ok((shown.collect(), input))
}

/// Reads all paths of an input, and reports those that cannot be used.
fn paths(lines: &mut Configs, solver: &Solver) -> anyhow::Result<Vec<Shown>> {
    let (mut shown, mut waypoints) = (Vec::new(), 0);
    while let Some(entry) = lines.next_path(solver.scene())? {
        lines.take_notes().into_iter().for_each(notice::warning);
        match entry {
            Ok((line, (first, rest))) => {
                waypoints += 1 + rest.len();
                if shown.len() == MAX_QUERIES || waypoints > MAX_WAYPOINTS {
                    bail!(
                        "line {line}: got more than {MAX_QUERIES} paths or {MAX_WAYPOINTS} waypoints, \
                         expected fewer: a page holds them all"
                    )
                }
                shown.push(Shown::Path(first, rest));
            }
            Err(bad) => lines.report(&bad),
        }
    }
    Ok(shown)
}

/// Reads all configurations of an input with the objects that they name, and reports those that
/// cannot be used.
fn read(configs: &mut Configs, solver: &Solver, args: &ViewArgs) -> anyhow::Result<(Vec<Config>, Vec<Option<Body>>)> {
    let (mut queries, mut objects) = (Vec::new(), Vec::new());
    while let Some(entry) = configs.next_grasp(solver.scene(), args.objects.is_some())? {
        configs.take_notes().into_iter().for_each(notice::warning);
        match entry {
            Ok((line, _)) if queries.len() == MAX_QUERIES => {
                bail!("line {line}: got more than {MAX_QUERIES} configurations, expected fewer: a page holds them all")
            }
            Ok((_, (q, object))) => {
                queries.push(q);
                let load = |(folder, (file, scale)): (&PathBuf, (String, f64))| {
                    mesh_object(&folder.join(file), scale, &args.load)
                };
                objects.push(args.objects.as_ref().zip(object).map(load).transpose()?);
            }
            Err(bad) => configs.report(&bad),
        }
    }
    Ok((queries, objects))
}

fn draw(args: &ViewArgs, solver: &Solver) -> anyhow::Result<Vec<Config>> {
    if args.count > MAX_QUERIES {
        bail!("--count: got {}, expected at most {MAX_QUERIES}: a page holds them all", args.count);
    }
    draw_colliding(solver, args.count, args.seed)
}

fn answer(args: &ViewArgs, solver: &Solver, queries: &[Config]) -> extricate::Result<Vec<Timed>> {
    let mut stream = args.stream.then(|| solver.stream(StreamOptions::default())).transpose()?;
    let mut progress = Progress::new("querying");
    let mut answers = Vec::with_capacity(queries.len());
    for (at, q) in queries.iter().enumerate() {
        answers.extend(ask(solver, stream.as_mut(), vec![q.clone()], 1));
        progress.update(Some(at as f64 / queries.len() as f64), || format!("{} answers", count(at)));
    }
    Ok(answers)
}

fn page(args: &ViewArgs, solver: &Solver, shown: Vec<Shown>) -> anyhow::Result<String> {
    let effort = args.effort;
    let source = match (&args.paths, &args.answers) {
        (Some(path), _) => name_of(path),
        (None, Some(path)) => format!("the answers of {}", name_of(path)),
        _ if args.stream => format!("extricate query --effort {effort} --stream --json"),
        _ => format!("extricate query --effort {effort} --exits {} --json", args.exits()),
    };
    let title = name_of(args.world.as_deref().unwrap_or(&args.file));
    let live = args.live.then(|| live(args, solver)).transpose()?;
    let visuals = pages::visuals(&args.file, &args.load.options());
    let about = About { title: &title, source: &source, is_stream: args.stream, visuals, live: live.as_ref() };
    pages::html(solver, shown, &about)
}

/// Returns the library for the page with the scene or model that it opens there.
fn live(args: &ViewArgs, solver: &Solver) -> anyhow::Result<Live> {
    let program = match &args.wasm {
        Some(path) => std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?,
        None => Live::built_in().context(NOT_BUILT_IN)?.to_vec(),
    };
    // WebAssembly begins with the first four bytes, gzip with the last two.
    if !program.starts_with(b"\0asm") && !program.starts_with(&[0x1f, 0x8b]) {
        bail!("--wasm: got a file that is no WebAssembly, expected what scripts/build-wasm.sh makes");
    }
    Ok(Live::new(&program, solver))
}

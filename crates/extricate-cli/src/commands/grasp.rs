//! `extricate grasp`: releases hands from the objects that they penetrate.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;

use anyhow::{Context, bail};
use clap::Args;
use clap::builder::TypedValueParser;
use extricate::entries::{SceneFile, read_obstacles};
use extricate::files::{GrowingFile, check_not_read};
use extricate::geometry::Body;
use extricate::{Config, Grasp, Hand, Keep, QueryOptions, ReleaseOptions, Released, Scene, Solver, Stop};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde::Serialize;

use super::{load_scene, tell_warnings};
use crate::args::{self, InputArgs, Limits, LoadArgs, choice, length, seconds, share_or_more, threads, whole};
use crate::input::{BadLine, Configs};
use crate::output::Output;
use crate::progress::{Progress, busy};
use crate::{notice, report};

/// Help text on the keys of `--json`.
const KEYS: &str = "With --json, and in the file of --output, each line is one object, in the order of the input: line (number \
of the input line), config, moved (distance of config from the query, in the scene's metric), verified, contacts (link, distance \
[m], point on the object [m], normal into the object), touched and kept (names of the links that touched, and of those that \
still touch), fingers ([touched, kept]), kept_sides (whether every contact is on its side of the object), depth_before [m], \
quality (epsilon and force_closure; null with --friction 0 or without contacts), checks. If there is no answer, the object has \
only line and error.";

/// Usage in lines that fit a terminal, because clap does not wrap it.
const USAGE: &str = "extricate grasp [OPTIONS] <--q <Q>|--input <FILE>>\n           \
                     <--object <NAME>|--objects <FOLDER>> <SCENE|MODEL>";

/// Arguments of `grasp`.
#[derive(Args)]
#[command(after_help = KEYS, override_usage = USAGE)]
pub struct GraspArgs {
    /// Scene file (TOML), URDF or model file of the hand. The samples of a model are not used
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    object: ObjectArgs,
    /// Part of the grasp that the release keeps
    #[arg(long, value_parser = keep(), default_value_t = Keep::Contacts)]
    keep: Keep,
    /// Distance in metres beyond the clearance up to which a link touches the object
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true, default_value_t = 0.002)]
    touch: f64,
    /// Coefficient of friction, for the quality of the grasp; with 0, quality is not measured
    #[arg(long, value_name = "MU", value_parser = share_or_more, allow_negative_numbers = true, default_value_t = 0.8)]
    friction: f64,
    /// A configuration with open fingers, which determines the side of the object for each finger;
    /// by default every joint is at 0, or at the limit nearest to 0
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    open: Option<String>,
    /// Aim at this clearance in metres instead of the scene's
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Names of joints that do not move; `base` is the base of a floating hand
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    locked: Vec<String>,
    /// Weight a floating base as the scene does. By default, if the scene gives the base no
    /// weights, moving the hand costs about as much as moving its fingers
    #[arg(long)]
    scene_weights: bool,
    /// End each release after about this many collision checks and contact evaluations
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, help_heading = "Budget")]
    max_checks: Option<usize>,
    /// End each release after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Budget")]
    max_seconds: Option<f64>,
    /// Number of threads, 0 for one per core; the answers do not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true, default_value_t = 0, help_heading = "Budget")]
    threads: usize,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    load: LoadArgs,
}

/// The object that the hand holds.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct ObjectArgs {
    /// Name of the obstacle that the hand holds
    #[arg(long, value_name = "NAME")]
    object: Option<String>,
    /// Folder of meshes. Each line of input names one as its object, {"q": [...], "object":
    /// "cup.obj", "scale": 0.1}; the mesh is at the world's origin, and the scene's obstacles stay
    /// unchanged
    #[arg(long, value_name = "FOLDER")]
    objects: Option<PathBuf>,
}

/// The file that receives the answers.
#[derive(Args)]
#[command(next_help_heading = "Output")]
struct OutputArgs {
    /// Write the answers to this file as JSON, one per line. Each answer goes to FILE.part as soon
    /// as it is known, and FILE.part becomes FILE after the last. An existing FILE is replaced if
    /// it is a file of grasps, and refused otherwise
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Continue an earlier run from FILE.part, or from FILE
    #[arg(long, requires = "output")]
    resume: bool,
}

/// Parses the part of a grasp that a release keeps; `--help` describes each value.
fn keep() -> impl TypedValueParser<Value = Keep> {
    choice(Keep::ALL.iter().map(|keep| {
        let about = match *keep {
            Keep::Pose => "The pose alone, whatever it touches",
            _ => "The links that touch, each on its side of the object",
        };
        (keep.name(), about)
    }))
}

/// Number of lines that are read and then answered together.
const BLOCK_LINES: usize = 1024;

struct Line {
    number: usize,
    q: Config,
    object: Option<(String, f64)>,
}

/// JSON output for one line of the input.
#[derive(Serialize)]
struct Row<'a> {
    line: usize,
    #[serde(flatten)]
    grasp: Option<&'a Grasp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

pub fn run(args: &GraspArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?.with_limits(Limits::Forgive);
    let mut rows = Rows::open(args, json)?;
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    let weighted = if args.scene_weights { None } else { Hand::weighted(&scene) };
    let asked = AskedOfAll::new(args, weighted.unwrap_or(scene))?;
    let mut progress = Progress::beside_rows("releasing");
    let size = if configs.is_stream() { 1 } else { BLOCK_LINES };
    let mut is_last = false;
    while !is_last {
        let mut block = Vec::new();
        while block.len() < size && !is_last {
            let entry = configs.next_grasp(asked.solver.scene(), args.object.objects.is_some())?;
            for note in configs.take_notes() {
                progress.aside(|| notice::warning(note));
            }
            match entry {
                None => is_last = true,
                Some(Ok((number, _))) if number <= rows.done => {}
                Some(Err(bad)) if bad.line <= rows.done => {}
                Some(Ok((number, (q, object)))) => block.push(Ok(Line { number, q, object })),
                Some(Err(bad)) => {
                    progress.aside(|| configs.report(&bad));
                    block.push(Err(bad));
                }
            }
        }
        asked.answer(&block, |entry, released| {
            match entry {
                Ok(line) => rows.answer(line.number, released.unwrap_or(Ok(None)))?,
                Err(bad) => rows.bad(bad)?,
            }
            progress.update(configs.fraction(), || report::counted(rows.summary.all, "grasp", "grasps"));
            Ok(())
        })?;
    }
    drop(progress);
    rows.finish()?;
    configs.conclude()
}

type Entry = Result<Line, BadLine>;

/// Scene, hand and options that all lines share.
struct AskedOfAll<'a> {
    args: &'a GraspArgs,
    solver: Solver,
    /// Hand for the object of all lines; unset if each line names its own.
    hand: Option<Hand>,
    options: ReleaseOptions,
    pool: ThreadPool,
    /// Set if an answer could not be written: ends the remaining releases.
    is_over: Arc<AtomicBool>,
}

impl<'a> AskedOfAll<'a> {
    fn new(args: &'a GraspArgs, scene: Scene) -> anyhow::Result<Self> {
        let mut options = options(args, &scene)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let asks = Arc::clone(&is_over);
        options.query.termination.stop = Some(Stop::when(move || asks.load(Ordering::Relaxed)));
        let hand = args.object.object.as_deref().map(|name| Hand::new(&scene, name)).transpose()?;
        let solver = Solver::new(scene);
        busy("preparing the scene", || solver.prepare());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build();
        Ok(Self { args, solver, hand, options, pool: pool.context("cannot start threads")?, is_over })
    }

    /// Releases the grasps of a block of lines. `take` receives every line in order, as soon as its
    /// answer and all earlier ones are known.
    fn answer(
        &self,
        block: &[Entry],
        mut take: impl FnMut(&Entry, Option<Released>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let (send, answers) = mpsc::channel();
        let work = move || {
            // Sending fails if an answer could not be written, because the receiver is then gone.
            let tell = |at: usize, released: Released| drop(send.send((at, released)));
            self.pool.install(|| self.release(block, &tell));
        };
        let mut in_turn = || {
            let (mut waiting, mut next) = (BTreeMap::new(), 0);
            while let Some(entry) = block.get(next) {
                let released = waiting.remove(&next);
                if entry.is_err() || released.is_some() {
                    take(entry, released)?;
                    next += 1;
                    continue;
                }
                let Ok((at, released)) = answers.recv() else { bail!("the work ended without an answer") };
                waiting.insert(at, released);
            }
            Ok(())
        };
        thread::scope(|scope| {
            thread::Builder::new().spawn_scoped(scope, work).context("cannot start threads")?;
            let done = in_turn();
            self.is_over.store(done.is_err(), Ordering::Relaxed);
            done
        })
    }

    /// Passes each answer to `tell`, with the index of its line in the block.
    fn release(&self, block: &[Entry], tell: &(dyn Fn(usize, Released) + Sync)) {
        let lines = block.iter().enumerate().filter_map(|(at, entry)| Some((at, entry.as_ref().ok()?)));
        match &self.hand {
            Some(hand) => {
                let release = |line: &Line| self.solver.release(hand, &line.q, &self.options);
                lines.par_bridge().for_each(|(at, line)| tell(at, Ok(release(line))));
            }
            None => self.release_many(lines, tell),
        }
    }

    fn release_many<'b>(
        &self,
        lines: impl Iterator<Item = (usize, &'b Line)>,
        tell: &(dyn Fn(usize, Released) + Sync),
    ) {
        let folder = self.args.object.objects.as_deref().unwrap_or(Path::new("."));
        let (mut numbers, mut objects) = (HashMap::new(), Vec::new());
        let (mut places, mut grasps) = (Vec::new(), Vec::new());
        for (at, line) in lines {
            let (file, scale) = line.object.as_ref().map_or(("", 1.0), |(file, scale)| (file.as_str(), *scale));
            let number = *numbers.entry((file, scale.to_bits())).or_insert_with(|| {
                objects.push((folder.join(file), scale));
                objects.len() - 1
            });
            places.push(at);
            grasps.push((number, line.q.clone()));
        }
        let object_of = |number: usize| {
            let (path, scale) = &objects[number];
            mesh_object(path, *scale, &self.args.load)
        };
        let tell = |at: usize, released: Released| tell(places[at], released);
        self.solver.release_each(&grasps, &object_of, &self.options, &tell);
    }
}

fn options(args: &GraspArgs, scene: &Scene) -> anyhow::Result<ReleaseOptions> {
    let mut query = QueryOptions::default().termination(args::termination(args.max_checks, args.max_seconds));
    query.locked = scene.joints_named("--locked", args.locked.iter().map(String::as_str))?;
    query.clearance = args.clearance;
    let open = args.open.as_ref().map(|words| {
        let found = Configs::of_words(std::slice::from_ref(words)).next(scene)?.and_then(Result::ok);
        let expected = || format!("--open: got {words}, expected {} numbers within the limits", scene.space().nq());
        found.map(|(_, q)| q.to_vec()).with_context(expected)
    });
    let mut options = ReleaseOptions::default().keep(args.keep).touch(args.touch).query(query);
    options.friction = Some(args.friction).filter(|friction| *friction > 0.0);
    options.open = open.transpose()?;
    Ok(options)
}

/// Loads a mesh at the world's origin.
pub fn mesh_object(path: &Path, scale: f64, load: &LoadArgs) -> extricate::Result<Body> {
    let name = path.display().to_string();
    let entry = serde_json::json!({
        "obstacle": [{ "name": "object", "shape": { "mesh": name, "scale": scale } }]
    });
    let read = |error: serde_json::Error| extricate::Error::input(name.clone(), "object", error.to_string());
    let mut entries: SceneFile = serde_json::from_value(entry).map_err(read)?;
    entries.limits = load.limits();
    let (mut bodies, _) = read_obstacles("objects", &entries)?;
    bodies.pop().ok_or_else(|| extricate::Error::input(name, "object", "got no shape, expected a mesh"))
}

/// Kind of the output file, for messages.
const OUTPUT_KIND: &str = "file of grasps";

/// Whether a file begins as the output does: with the number of a line, see [`Row`].
fn is_grasps(head: &[u8]) -> bool {
    head.starts_with(b"{\"line\":")
}

/// Writes answers to standard output and to the file, and sums them up.
struct Rows {
    out: Output,
    json: bool,
    file: Option<GrowingFile>,
    /// Number of the last input line that an earlier run answered.
    done: usize,
    summary: Summary,
}

#[derive(Default)]
struct Summary {
    all: usize,
    answered: usize,
    fingers: [usize; 2],
    closed: usize,
}

impl Rows {
    fn open(args: &GraspArgs, json: bool) -> anyhow::Result<Self> {
        let mut rows = Self { out: Output::new(true), json, file: None, done: 0, summary: Summary::default() };
        let Some(path) = &args.output.output else { return Ok(rows) };
        let inputs = || [args.scene.as_path()].into_iter().chain(args.input.input.as_deref());
        check_not_read(path, inputs())?;
        let file = if args.output.resume {
            let read = |line: &[u8]| {
                rows.done = number_of(line)?;
                Ok(())
            };
            GrowingFile::resume(path, OUTPUT_KIND, is_grasps, read)?
        } else {
            let file = GrowingFile::begin(path, OUTPUT_KIND, is_grasps)?;
            if file.part().exists() {
                notice::warning(format_args!(
                    "{} is what another run left, and this one will replace it; --resume goes on with it",
                    file.part().display()
                ));
            }
            file
        };
        check_not_read(file.part(), inputs())?;
        rows.file = Some(file);
        Ok(rows)
    }

    fn answer(&mut self, line: usize, released: Released) -> anyhow::Result<()> {
        self.summary.all += 1;
        let (grasp, error) = match &released {
            Ok(Some(grasp)) => (Some(grasp), None),
            Ok(None) => (None, Some("no free configuration was found".to_string())),
            Err(error) => (None, Some(error.clone())),
        };
        if let Some(grasp) = grasp {
            self.summary.answered += 1;
            self.summary.fingers = [0, 1].map(|k| self.summary.fingers[k] + grasp.fingers[k]);
            self.summary.closed += usize::from(grasp.quality.is_some_and(|quality| quality.force_closure));
        }
        if let Some(error) = error.as_ref().filter(|_| !self.json || self.file.is_some()) {
            notice::error(format_args!("line {line}: {error}"));
        }
        self.write(&Row { line, grasp, error })?;
        match grasp {
            Some(grasp) if !self.json && self.file.is_none() => {
                if self.summary.answered == 1 {
                    self.out.line(HEADER)?;
                }
                self.out.line(text(line, grasp))
            }
            _ => Ok(()),
        }
    }

    fn bad(&mut self, bad: &BadLine) -> anyhow::Result<()> {
        self.write(&Row { line: bad.line, grasp: None, error: Some(bad.error.clone()) })
    }

    fn write(&mut self, row: &Row) -> anyhow::Result<()> {
        match &mut self.file {
            Some(file) => Ok(file.line(&serde_json::to_string(row)?)?),
            None if self.json => self.out.json(row),
            None => Ok(()),
        }
    }

    fn finish(mut self) -> anyhow::Result<()> {
        if let Some(file) = self.file.take() {
            file.finish()?;
        }
        let Summary { all, answered, fingers: [touched, kept], closed } = self.summary;
        if !self.json && all > 0 {
            let share = |part: usize, of: usize| report::percent(part as f64 / of.max(1) as f64);
            self.out.line(format_args!(
                "{}, {} released; {} of {} fingers kept ({}), force closure {}",
                report::counted(all, "grasp", "grasps"),
                report::count(answered),
                report::count(kept),
                report::count(touched),
                share(kept, touched),
                share(closed, answered),
            ))?;
        }
        self.out.finish()?;
        if answered < all {
            bail!("no answer for {} of {}", all - answered, report::counted(all, "grasp", "grasps"));
        }
        Ok(())
    }
}

const HEADER: &str = "  line      moved  fingers   epsilon  contacts  kept";

fn text(line: usize, grasp: &Grasp) -> String {
    let epsilon = grasp.quality.map_or(String::new(), |quality| format!("{:.4}", quality.epsilon));
    let [touched, kept] = grasp.fingers;
    let side = if grasp.kept_sides { "" } else { "; past the side" };
    let links = grasp.kept.join(", ");
    format!(
        "{line:>6}  {:>9.5}  {kept:>3}/{touched:<3}  {epsilon:>8}  {:>8}  {links}{side}",
        grasp.moved,
        grasp.contacts.len()
    )
}

/// Reads the number of the input line from a line of output.
fn number_of(line: &[u8]) -> Result<usize, String> {
    const EXPECTED: &str = "expected those of `extricate grasp --output`";
    let value: serde_json::Value =
        serde_json::from_slice(line).map_err(|error| format!("got lines that are no JSON ({error}), {EXPECTED}"))?;
    let number = value.get("line").and_then(serde_json::Value::as_u64);
    number.map(|number| number as usize).ok_or_else(|| format!("got a line without \"line\", {EXPECTED}"))
}

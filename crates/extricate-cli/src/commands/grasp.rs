//! `extricate grasp`: hands that hold an object and penetrate nothing.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use extricate::geometry::Body;
use extricate::internals::grasp::{Released, release_batch};
use extricate::internals::io;
use extricate::internals::scene::file::SceneFile;
use extricate::{Config, Grasp, Hand, Keep, QueryOptions, ReleaseOptions, Scene, Termination, World};
use rayon::prelude::*;
use serde::Serialize;

use super::{load_scene, tell_warnings};
use crate::args::{InputArgs, Limits, LoadArgs, length, seconds, share_or_more, threads, whole};
use crate::input::{BadLine, Configs};
use crate::output::Output;
use crate::progress::{Progress, busy};
use crate::{notice, report};

/// The keys of `--json`.
const KEYS: &str = "With --json (and in the file of --output), one object a line, in the order of the input: line (of the \
input), config (null where nothing free was found), moved (how far it is from the query, in the scene's metric), verified, \
contacts (link, distance [m], point on the object [m], normal into it), touched and kept (names of links that touched, and of \
those that still do), fingers ([touched, kept]), kept_sides (whether every contact is on its side of the object), depth_before \
[m], quality (epsilon and force_closure; null with --friction 0 or without contacts), checks; or error.";

/// Arguments of `grasp`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct GraspArgs {
    /// Scene file (TOML), URDF or model file of the hand. What a model has learned is not used
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    object: ObjectArgs,
    /// What is to stay: the links that touch, each on its side of the object; or the pose alone,
    /// whatever it touches
    #[arg(long, value_enum, default_value_t = KeepArg::Contacts)]
    keep: KeepArg,
    /// A link touches where it is nearer than this in metres beyond the clearance
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true, default_value_t = 0.002)]
    touch: f64,
    /// Coefficient of friction, for the quality of the grasp; 0 leaves it out
    #[arg(long, value_name = "MU", value_parser = share_or_more, allow_negative_numbers = true, default_value_t = 0.8)]
    friction: f64,
    /// A configuration with open fingers, which tells on which side of the object each is; by
    /// default every joint at 0, or at the limit nearest to it
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    open: Option<String>,
    /// Aim at this clearance in metres in place of the scene's
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Joints that stay where they are, by name; `base` is the base of a floating hand
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    locked: Vec<String>,
    /// Measure a floating base as the scene does. By default moving the hand is about as dear as
    /// moving its fingers, where the scene gives the base no weights
    #[arg(long)]
    scene_weights: bool,
    /// End each release after about this many collision checks and contact evaluations
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, help_heading = "Budget")]
    max_checks: Option<usize>,
    /// End each release after about this many seconds
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Budget")]
    max_seconds: Option<f64>,
    /// Work on this many threads, 0 for one a core; the answers are the same
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true, default_value_t = 0, help_heading = "Budget")]
    threads: usize,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    load: LoadArgs,
}

/// What is held.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct ObjectArgs {
    /// The obstacle that is held, by name
    #[arg(long, value_name = "NAME")]
    object: Option<String>,
    /// Each line names a mesh in this folder as its object, {"q": [...], "object": "cup.obj",
    /// "scale": 0.1}; it stands at the world's origin, without the scene's obstacles being changed
    #[arg(long, value_name = "FOLDER")]
    objects: Option<PathBuf>,
}

/// Where answers go.
#[derive(Args)]
#[command(next_help_heading = "Output")]
struct OutputArgs {
    /// Write the answers to this file, as JSON, one a line
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Go on with the file of --output where a run ended
    #[arg(long, requires = "output")]
    resume: bool,
}

/// [`Keep`] as the command line spells it.
#[derive(Clone, Copy, ValueEnum)]
enum KeepArg {
    /// The links that touch
    Contacts,
    /// The pose
    Pose,
}

/// Lines that are read before they are answered.
const BLOCK: usize = 1024;

/// A line of the input.
struct Line {
    number: usize,
    q: Config,
    object: Option<(String, f64)>,
}

/// One answer, as it is written.
#[derive(Serialize)]
struct Row<'a> {
    line: usize,
    #[serde(flatten)]
    grasp: Option<&'a Grasp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// Runs the command.
pub fn run(args: &GraspArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?.with_limits(Limits::Forgive);
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    let options = options(args, &scene)?;
    let weighted = if args.scene_weights { None } else { Hand::weighted(&scene) };
    let world = busy("preparing the scene", || World::new(weighted.unwrap_or(scene)));
    let hand = args.object.object.as_deref().map(|name| Hand::new(world.scene(), name)).transpose()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build().context("cannot start threads")?;
    let mut rows = Rows::open(&args.output, json, configs.is_stream())?;
    let mut progress = Progress::beside_rows("releasing");
    let size = if configs.is_stream() { 1 } else { BLOCK };
    let mut is_last = false;
    while !is_last {
        let mut block = Vec::new();
        while block.len() < size && !is_last {
            let entry = configs.next_grasp(world.scene(), args.object.objects.is_some())?;
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
        let lines: Vec<&Line> = block.iter().flatten().collect();
        let answers = pool.install(|| match &hand {
            Some(hand) => of_one(&world, hand, &lines, &options),
            None => of_many(&world, args, &lines, &options),
        });
        let mut answers = answers.into_iter();
        for entry in &block {
            let row = match entry {
                Ok(line) => rows.answer(line.number, answers.next().unwrap_or(Ok(None))),
                Err(bad) => rows.bad(bad),
            };
            row?;
        }
        progress.update(configs.fraction(), || format!("{} grasps", report::count(rows.summary.all)));
    }
    drop(progress);
    rows.finish()?;
    configs.conclude()
}

fn options(args: &GraspArgs, scene: &Scene) -> anyhow::Result<ReleaseOptions> {
    let locked = scene.joints_named("--locked", args.locked.iter().map(String::as_str))?;
    let termination =
        Termination { max_checks: args.max_checks, max_seconds: args.max_seconds, ..Termination::default() };
    let open = args.open.as_ref().map(|words| {
        let found = Configs::of_words(std::slice::from_ref(words)).next(scene)?.and_then(Result::ok);
        let expected = || format!("--open: got {words}, expected {} numbers within the limits", scene.space.nq());
        found.map(|(_, q)| q.to_vec()).with_context(expected)
    });
    Ok(ReleaseOptions {
        keep: match args.keep {
            KeepArg::Contacts => Keep::Contacts,
            KeepArg::Pose => Keep::Pose,
        },
        touch: args.touch,
        friction: Some(args.friction).filter(|friction| *friction > 0.0),
        open: open.transpose()?,
        query: QueryOptions { clearance: args.clearance, locked, termination, ..QueryOptions::default() },
    })
}

fn of_one(world: &World, hand: &Hand, lines: &[&Line], options: &ReleaseOptions) -> Vec<Released> {
    let view = world.view();
    let release = |scratch: &mut _, line: &&Line| Ok(hand.release(&view, &line.q, options, scratch));
    lines.par_iter().map_init(Default::default, release).collect()
}

fn of_many(world: &World, args: &GraspArgs, lines: &[&Line], options: &ReleaseOptions) -> Vec<Released> {
    let folder = args.object.objects.as_deref().unwrap_or(Path::new("."));
    let (mut numbers, mut objects) = (HashMap::new(), Vec::new());
    let mut grasps = Vec::new();
    for line in lines {
        let (file, scale) = line.object.as_ref().map_or(("", 1.0), |(file, scale)| (file.as_str(), *scale));
        let number = *numbers.entry((file, scale.to_bits())).or_insert_with(|| {
            objects.push((folder.join(file), scale));
            objects.len() - 1
        });
        grasps.push((number, line.q.clone()));
    }
    let object_of = |number: usize| {
        let (path, scale) = &objects[number];
        mesh_object(path, *scale, &args.load)
    };
    release_batch(world, &grasps, &object_of, options)
}

/// A mesh at the world's origin.
fn mesh_object(path: &Path, scale: f64, load: &LoadArgs) -> extricate::Result<Body> {
    let name = path.display().to_string();
    let entry = serde_json::json!({
        "obstacle": [{ "name": "object", "shape": { "mesh": name, "scale": scale } }]
    });
    let read = |error: serde_json::Error| extricate::Error::input(name.clone(), "object", error.to_string());
    let mut entries: SceneFile = serde_json::from_value(entry).map_err(read)?;
    entries.limits = load.limits();
    let (mut bodies, _) = io::read_obstacles("objects", &entries)?;
    bodies.pop().ok_or_else(|| extricate::Error::input(name, "object", "got no shape, expected a mesh"))
}

/// Where answers go, and what they come to.
struct Rows {
    out: Output,
    json: bool,
    file: Option<BufWriter<File>>,
    path: PathBuf,
    /// Lines of the input that an earlier run has answered.
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
    fn open(args: &OutputArgs, json: bool, is_stream: bool) -> anyhow::Result<Self> {
        let (out, path) = (Output::new(is_stream), args.output.clone().unwrap_or_default());
        let mut rows = Self { out, json, file: None, path, done: 0, summary: Summary::default() };
        if args.output.is_some() {
            let failed = format!("cannot write {}", rows.path.display());
            let file = OpenOptions::new().create(true).read(true).write(true).truncate(!args.resume).open(&rows.path);
            let mut file = file.context(failed.clone())?;
            let (done, length) = answered(&mut file).with_context(|| format!("cannot read {}", rows.path.display()))?;
            rows.done = done;
            // A run that was killed may have left half a line.
            file.set_len(length).and_then(|()| file.seek(std::io::SeekFrom::End(0))).context(failed)?;
            rows.file = Some(BufWriter::new(file));
        }
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
        if let Some(file) = &mut self.file {
            let written = serde_json::to_string(row).map_err(std::io::Error::from);
            let written = written.and_then(|text| writeln!(file, "{text}"));
            return written.with_context(|| format!("cannot write {}", self.path.display()));
        }
        if self.json { self.out.json(row) } else { Ok(()) }
    }

    fn finish(mut self) -> anyhow::Result<()> {
        if let Some(mut file) = self.file.take() {
            let written = file.flush().and_then(|()| file.get_ref().sync_all());
            written.with_context(|| format!("cannot write {}", self.path.display()))?;
        }
        let Summary { all, answered, fingers: [touched, kept], closed } = self.summary;
        if !self.json && all > 0 {
            let share = |part: usize, of: usize| report::percent(part as f64 / of.max(1) as f64);
            self.out.line(format_args!(
                "{} grasps, {} released; {} of {} fingers kept ({}), force closure {}",
                report::count(all),
                report::count(answered),
                report::count(kept),
                report::count(touched),
                share(kept, touched),
                share(closed, answered),
            ))?;
        }
        self.out.finish()?;
        if answered < all {
            bail!("{} of {all} grasps have no answer", all - answered);
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

/// The last line that a file answers, and how long it is up to there \[bytes\].
fn answered(file: &mut File) -> anyhow::Result<(usize, u64)> {
    let (mut reader, mut line, mut done, mut length) = (BufReader::new(file), Vec::new(), 0, 0);
    loop {
        line.clear();
        let read = reader.read_until(b'\n', &mut line)?;
        if read == 0 || line.last() != Some(&b'\n') {
            return Ok((done, length));
        }
        let value: serde_json::Value =
            serde_json::from_slice(&line).context("expected lines that `extricate grasp --output` wrote")?;
        let number = value.get("line").and_then(serde_json::Value::as_u64);
        done = number.context("got a line without \"line\", expected those of `extricate grasp --output`")? as usize;
        length += read as u64;
    }
}

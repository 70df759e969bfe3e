//! `extricate demo`: a built-in scene asked at once and drawn, then learned and asked again, with
//! nothing to prepare.

pub mod table;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use extricate::internals::io::{self, OutputLock};
use extricate::{Answer, Config, Effort, LearnOptions, QueryOptions, QueryScratch, Scene, World, builtin};
use extricate_view::{Live, is_page};

use super::learn::run::{Learned, learn_with_progress};
use super::query::summary::{Figures, Summary};
use super::sample::CollidingSampler;
use super::tell_warnings;
use crate::args::{positive, seconds, seed};
use crate::output::Output;
use crate::pages::{self, About, Shown};
use crate::picture;
use crate::progress::Progress;
use crate::report::count;
use table::{DemoReport, at_once_text};

/// Turns the seed into another one: no query shall be a configuration that the learner drew.
const QUERY_STREAM: u64 = 0x71_75_65_72_69_65_73;

/// Queries of the page, most.
const PAGE_QUERIES: usize = 8;
/// Exits of each.
const PAGE_EXITS: usize = 3;

/// Arguments of `demo`.
#[derive(Args)]
pub struct DemoArgs {
    /// Built-in scene
    #[arg(long, value_name = "NAME", default_value = builtin::NAMES[0], value_parser = PossibleValuesParser::new(builtin::NAMES))]
    scene: String,
    /// Colliding configurations to answer
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = positive, allow_negative_numbers = true)]
    queries: usize,
    /// Picture to write; an existing one is replaced
    #[arg(long, value_name = "PICTURE.svg", default_value = "extricate-demo.svg")]
    out: PathBuf,
    /// Page of some of the answers to write, for a browser; an existing one is replaced. By default
    /// beside the picture, under its name
    #[arg(long, value_name = "PAGE.html")]
    page: Option<PathBuf>,
    /// Only write the scene's files into this directory, for the other commands to use; replaces
    /// nothing
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Most seconds of learning
    #[arg(long, value_name = "T", default_value_t = 5.0, value_parser = seconds, allow_negative_numbers = true)]
    seconds: f64,
}

/// A query, its answer and how long it took \[s\].
pub struct Answered {
    /// Its exit.
    pub answer: Answer,
    /// Time of the library call \[s\].
    pub seconds: f64,
}

/// Runs the command.
pub fn run(args: &DemoArgs, json: bool) -> anyhow::Result<()> {
    if let Some(folder) = &args.export {
        return export(&args.scene, folder, json);
    }
    io::check_output(&args.out, "picture (SVG)", |head| head.starts_with(b"<svg"))?;
    let _lock = OutputLock::take(&args.out)?;
    let page = args.page.clone().unwrap_or_else(|| args.out.with_extension("html"));
    if io::is_same_output(&args.out, &page) {
        bail!("--page: got {}, which is the picture to write, expected another file", page.display());
    }
    io::check_output(&page, "page of this program", is_page)?;
    let _page_lock = OutputLock::take(&page)?;
    let scene = builtin::scene(&args.scene)?;
    tell_warnings(&scene);
    let world = World::new(scene.clone());
    let queries = draw(&world, args.queries, args.seed)?;
    let at_once = answer_all("answering at once", &queries, |q, scratch| {
        world.view().query_with(q, &QueryOptions::default(), scratch).context("nothing free was found")
    })?;
    let figures_at_once = figures(&at_once);
    draw_and_write(&world, (&args.scene, &queries), most_instructive(world.scene(), &at_once), [&args.out, &page])?;
    let (picture, page) = (args.out.display().to_string(), page.display().to_string());
    let mut out = Output::new(false);
    if !json {
        // Whoever waits for the model has answers meanwhile.
        out.line(at_once_text(&figures_at_once, world.scene(), [&picture, &page]))?;
        out.flush()?;
    }
    let options = LearnOptions { seconds: Some(args.seconds), seed: args.seed, ..LearnOptions::default() };
    let Learned { model, seconds: learning_seconds, .. } = learn_with_progress(scene, &options)?;
    let answers = answer_all("querying", &queries, |q, scratch| {
        let options = QueryOptions { effort: Effort::Quick, ..QueryOptions::default() };
        model.view().query_with(q, &options, scratch).context("nothing free was found")
    })?;
    let is_as_near = |(a, b): &(&Answered, &Answered)| b.answer.depth <= 1.05 * a.answer.depth;
    let as_near = at_once.iter().zip(&answers).filter(is_as_near).count();
    let report = DemoReport {
        scene: &args.scene,
        at_once: figures_at_once,
        as_near: as_near as f64 / answers.len().max(1) as f64,
        learned: model.statistics(),
        learning_seconds,
        queries: figures(&answers),
        picture,
        page,
    };
    if json {
        out.json(&report)?
    } else {
        out.line(report.text(model.scene()))?
    }
    out.finish()
}

/// The picture of the query at `shown`, and the page of it and of those after it, with several
/// exits each; live if the library is built in. Both show the nearest exits that the most thorough
/// effort finds.
fn draw_and_write(
    world: &World,
    (name, queries): (&str, &[Config]),
    shown: usize,
    [picture, page]: [&Path; 2],
) -> anyhow::Result<()> {
    let options = QueryOptions { effort: Effort::Exhaustive, exits: PAGE_EXITS, ..QueryOptions::default() };
    let mut scratch = QueryScratch::default();
    let chosen: Vec<&Config> =
        (0..PAGE_QUERIES.min(queries.len())).map(|at| &queries[(shown + at) % queries.len()]).collect();
    let mut answers = Vec::new();
    for q in &chosen {
        let started = Instant::now();
        answers.push((world.view().query_with(q, &options, &mut scratch), started.elapsed().as_secs_f64()));
    }
    if let (Some(q), Some((Some(answer), _))) = (chosen.first(), answers.first()) {
        picture::write(world.scene(), q, answer, picture)?;
    }
    let answers = chosen.into_iter().zip(answers).map(|(q, answer)| Shown::Answer(q.clone(), answer)).collect();
    let live = Live::built_in().map(|program| Live::of_scene(program, world.scene())).transpose()?;
    let command = format!("extricate query --effort exhaustive --exits {PAGE_EXITS} --json");
    let about = About { title: name, source: &command, is_stream: false, live: live.as_ref() };
    let html = pages::html(world.checker(), answers, &about)?;
    Ok(io::write_atomically(page, html.as_bytes())?)
}

fn figures(answers: &[Answered]) -> Figures {
    let mut summary = Summary::default();
    answers.iter().for_each(|a| summary.add(&a.answer, a.seconds));
    summary.figures()
}

/// Random colliding configurations.
fn draw(world: &World, count: usize, seed: u64) -> anyhow::Result<Vec<Config>> {
    let space = &world.scene().space;
    let mut sampler = CollidingSampler::new(world.checker(), seed ^ QUERY_STREAM);
    let mut query = vec![0.0; space.nq()];
    let draw = |_| {
        sampler.next(&mut query, |_, _| {})?;
        Ok(space.config(&query)?)
    };
    (0..count).map(draw).collect()
}

fn answer_all(
    doing: &'static str,
    queries: &[Config],
    ask: impl Fn(&Config, &mut QueryScratch) -> anyhow::Result<Answer>,
) -> anyhow::Result<Vec<Answered>> {
    let mut scratch = QueryScratch::default();
    let mut progress = Progress::new(doing);
    let mut answers = Vec::with_capacity(queries.len());
    for (index, q) in queries.iter().enumerate() {
        let started = Instant::now();
        let answer = ask(q, &mut scratch)?;
        answers.push(Answered { answer, seconds: started.elapsed().as_secs_f64() });
        progress.update(Some(index as f64 / queries.len() as f64), || format!("{} answers", count(index)));
    }
    Ok(answers)
}

/// The answer to draw: verified, in collision with an obstacle if any is, and of a displacement
/// that can be seen without being the worst (the 80th percentile).
fn most_instructive(scene: &Scene, answers: &[Answered]) -> usize {
    let hits_obstacle = |a: &Answered| {
        a.answer.colliding.iter().any(|&pair| {
            let pair = scene.pairs[pair.index()];
            scene.bodies[pair.first].robot.is_none() || scene.bodies[pair.second].robot.is_none()
        })
    };
    let mut candidates: Vec<usize> = (0..answers.len()).collect();
    for keep in [&hits_obstacle as &dyn Fn(&Answered) -> bool, &|a: &Answered| a.answer.verified] {
        let kept: Vec<usize> = candidates.iter().copied().filter(|&i| keep(&answers[i])).collect();
        if !kept.is_empty() {
            candidates = kept;
        }
    }
    candidates.sort_by(|&a, &b| answers[a].answer.max_displacement.total_cmp(&answers[b].answer.max_displacement));
    candidates[(candidates.len() - 1) * 4 / 5]
}

fn export(name: &str, folder: &Path, json: bool) -> anyhow::Result<()> {
    let Some(files) = builtin::files(name) else {
        bail!("there is no built-in scene {name}");
    };
    let scene = folder.join(&files[0].0);
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let _lock = OutputLock::take(&scene)?;
    let scene = scene.display().to_string();
    let files: Vec<_> = files.into_iter().map(|(path, content)| (folder.join(path), content)).collect();
    // A run that was killed may have left some of the files, and this one then writes all of them.
    let (there, missing): (Vec<_>, Vec<_>) = files.iter().partition(|(path, _)| path.exists());
    let in_the_way = |(path, content): &&&(PathBuf, Vec<u8>)| {
        missing.is_empty() || !fs::read(path).is_ok_and(|found| found == *content)
    };
    if let Some((path, _)) = there.iter().find(in_the_way) {
        bail!("{} exists; nothing was written", path.display());
    }
    for parent in files.iter().filter_map(|(path, _)| path.parent()) {
        fs::create_dir_all(parent).with_context(|| format!("cannot create {}", parent.display()))?;
    }
    io::write_together(&files)?;
    let mut out = Output::new(false);
    if json {
        let written: Vec<_> = files.iter().map(|(path, _)| path.display().to_string()).collect();
        out.json(&serde_json::json!({ "scene": scene, "files": written }))?;
    } else {
        out.line(format_args!("wrote {} files; the scene is {scene}", count(files.len())))?;
        out.line(format_args!("try: extricate info {scene}\n     extricate sample {scene} -n 5 --colliding | extricate query {scene} --input -\n     extricate learn {scene} -o {name}.model"))?;
    }
    out.finish()
}

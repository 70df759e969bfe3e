//! `extricate demo`: answers queries of a built-in scene and writes a page of them, then learns the
//! scene and answers them again. It needs no preparation.

mod picture;
pub mod table;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use extricate::files::{self, OutputLock};
use extricate::{Answer, Config, Effort, LearnOptions, QueryOptions, Scene, Solver, builtin};
use extricate_view::{Live, is_page};

use super::learn::with_progress::{Learned, learn_with_progress};
use super::query::ask;
use super::query::summary::{Figures, Summary};
use super::{draw_colliding, tell_warnings};
use crate::args::{positive, seconds, seed};
use crate::output::Output;
use crate::pages::{self, About, Shown};
use crate::progress::Progress;
use crate::report::count;
use table::{DemoReport, at_once_text};

/// Changes the seed, so that no query is a configuration that the learner drew.
const QUERY_SEED_MASK: u64 = 0x71_75_65_72_69_65_73;

/// Largest number of queries on the page.
const PAGE_QUERIES: usize = 8;
/// Exits per query on the page.
const PAGE_EXITS: usize = 3;

/// Arguments of `demo`.
#[derive(Args)]
pub struct DemoArgs {
    /// Built-in scene
    #[arg(long, value_name = "NAME", default_value = builtin::NAMES[0], value_parser = PossibleValuesParser::new(builtin::NAMES))]
    scene: String,
    /// Number of colliding configurations to query
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = positive, allow_negative_numbers = true)]
    queries: usize,
    /// Page to write, which shows some of the answers in a browser; an existing page is replaced
    #[arg(long, value_name = "PAGE.html", default_value = "extricate-demo.html")]
    out: PathBuf,
    /// Draw the page into this picture too, with Chromium or Chrome; an existing PNG is replaced
    #[arg(long, value_name = "FILE.png", conflicts_with = "export")]
    png: Option<PathBuf>,
    /// Only write the scene's files to this directory, for use with the other commands; existing
    /// files are never replaced
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Most seconds to spend on learning
    #[arg(long, value_name = "T", default_value_t = 5.0, value_parser = seconds, allow_negative_numbers = true)]
    seconds: f64,
}

/// An answer and its time \[s\].
type Answered = (Answer, f64);

pub fn run(args: &DemoArgs, json: bool) -> anyhow::Result<()> {
    if let Some(folder) = &args.export {
        return export(&args.scene, folder, json);
    }
    files::check_output(&args.out, "page of this program", is_page)?;
    let _lock = OutputLock::take(&args.out)?;
    let png = args.png.as_deref();
    let browser = png.map(|png| {
        files::check_output(png, "PNG picture", picture::is_png)?;
        picture::browser()
    });
    let browser = browser.transpose()?;
    let scene = builtin::scene(&args.scene)?;
    tell_warnings(&scene);
    let solver = Solver::new(scene.clone());
    let queries = draw_colliding(&solver, args.queries, args.seed ^ QUERY_SEED_MASK)?;
    let at_once = answer_all("answering at once", &solver, &queries)?;
    let figures_at_once = figures(&at_once);
    write_page(&solver, (&args.scene, &queries), most_instructive(&scene, &at_once), &args.out)?;
    if let (Some(browser), Some(png)) = (&browser, png) {
        picture::draw(browser, &args.out, png)?;
    }
    let page = args.out.display().to_string();
    let mut out = Output::new(false);
    if !json {
        // Print these answers before learning, so that the user need not wait for them.
        out.line(at_once_text(&figures_at_once, &scene, &page))?;
        out.flush()?;
    }
    let options = LearnOptions::default().seconds(args.seconds).seed(args.seed);
    let Learned { model, seconds: learning_seconds, .. } = learn_with_progress(scene, &options)?;
    let model = Arc::new(model);
    let learned = solver.with_model(Arc::clone(&model))?.options(QueryOptions::default().effort(Effort::Quick))?;
    let answers = answer_all("querying", &learned, &queries)?;
    let is_as_near = |((a, _), (b, _)): &(&Answered, &Answered)| b.depth <= 1.05 * a.depth;
    let as_near = at_once.iter().zip(&answers).filter(is_as_near).count();
    let report = DemoReport {
        scene: &args.scene,
        at_once: figures_at_once,
        as_near: as_near as f64 / answers.len().max(1) as f64,
        learned: model.statistics(),
        learning_seconds,
        queries: figures(&answers),
        page,
    };
    if json {
        out.json(&report)?
    } else {
        out.line(report.text(model.scene()))?
    }
    out.finish()
}

/// Writes the page of the query at `shown` and of those after it, each with the nearest exits of an
/// exhaustive search. The page is live if the library is built in.
fn write_page(solver: &Solver, (name, queries): (&str, &[Config]), shown: usize, page: &Path) -> anyhow::Result<()> {
    let options = QueryOptions::default().effort(Effort::Exhaustive).exits(PAGE_EXITS);
    let solver = solver.clone().options(options)?;
    let chosen = queries.iter().cycle().skip(shown).take(PAGE_QUERIES.min(queries.len()));
    let answered = chosen.flat_map(|q| {
        let answers = ask(&solver, None, vec![q.clone()], 1);
        answers.into_iter().map(|answer| Shown::Answer(q.clone(), answer))
    });
    let live = Live::built_in().map(|program| Live::new(program, &solver));
    let command = format!("extricate query --effort exhaustive --exits {PAGE_EXITS} --json");
    let about = About { title: name, source: &command, is_stream: false, visuals: Ok(Vec::new()), live: live.as_ref() };
    let html = pages::html(&solver, answered.collect(), &about)?;
    Ok(files::write_atomically(page, html.as_bytes())?)
}

fn figures(answers: &[Answered]) -> Figures {
    let mut summary = Summary::default();
    answers.iter().for_each(|(answer, seconds)| summary.add(answer, *seconds));
    summary.figures()
}

fn answer_all(doing: &'static str, solver: &Solver, queries: &[Config]) -> anyhow::Result<Vec<Answered>> {
    let mut progress = Progress::new(doing);
    let mut answers = Vec::with_capacity(queries.len());
    for (index, q) in queries.iter().enumerate() {
        for (answer, seconds) in ask(solver, None, vec![q.clone()], 1) {
            answers.push((answer.context("nothing free was found")?, seconds));
        }
        progress.update(Some(index as f64 / queries.len() as f64), || format!("{} answers", count(index)));
    }
    Ok(answers)
}

/// Returns the index of the answer to show first: verified, in collision with an obstacle if any
/// is, and with a displacement that is visible but not the largest (the 80th percentile).
fn most_instructive(scene: &Scene, answers: &[Answered]) -> usize {
    let is_obstacle = |body: usize| scene.bodies()[body].robot.is_none();
    let hits_obstacle = |(answer, _): &Answered| {
        let pairs = answer.colliding.iter().map(|pair| scene.pairs()[pair.index()]);
        pairs.into_iter().any(|pair| is_obstacle(pair.first) || is_obstacle(pair.second))
    };
    let mut candidates: Vec<usize> = (0..answers.len()).collect();
    for keep in [&hits_obstacle as &dyn Fn(&Answered) -> bool, &|(answer, _)| answer.verified] {
        let kept: Vec<usize> = candidates.iter().copied().filter(|&i| keep(&answers[i])).collect();
        if !kept.is_empty() {
            candidates = kept;
        }
    }
    candidates.sort_by(|&a, &b| answers[a].0.max_displacement.total_cmp(&answers[b].0.max_displacement));
    candidates[(candidates.len() - 1) * 4 / 5]
}

fn export(name: &str, folder: &Path, json: bool) -> anyhow::Result<()> {
    let Some(named) = builtin::files(name) else {
        bail!("there is no built-in scene {name}");
    };
    let scene = folder.join(&named[0].0);
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let _lock = OutputLock::take(&scene)?;
    let scene = scene.display().to_string();
    let all: Vec<_> = named.into_iter().map(|(path, content)| (folder.join(path), content)).collect();
    // A killed run may have left some of the files; this one then writes all of them.
    let (there, missing): (Vec<_>, Vec<_>) = all.iter().partition(|(path, _)| path.exists());
    let in_the_way = |(path, content): &&&(PathBuf, Vec<u8>)| {
        missing.is_empty() || !fs::read(path).is_ok_and(|found| found == *content)
    };
    if let Some((path, _)) = there.iter().find(in_the_way) {
        bail!("{} exists; nothing was written", path.display());
    }
    for parent in all.iter().filter_map(|(path, _)| path.parent()) {
        fs::create_dir_all(parent).with_context(|| format!("cannot create {}", parent.display()))?;
    }
    files::write_together(&all)?;
    let mut out = Output::new(false);
    if json {
        let written: Vec<_> = all.iter().map(|(path, _)| path.display().to_string()).collect();
        out.json(&serde_json::json!({ "scene": scene, "files": written }))?;
    } else {
        out.line(format_args!("wrote {} files; the scene is {scene}", count(all.len())))?;
        out.line(format_args!("try: extricate info {scene}\n     extricate sample {scene} -n 5 --colliding | extricate query {scene} --input -\n     extricate learn {scene} -o {name}.model"))?;
    }
    out.finish()
}

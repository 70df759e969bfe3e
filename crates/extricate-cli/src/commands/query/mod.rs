//! `extricate query`: finds the nearest free configuration for each of many.

pub mod constraints;
pub mod row;
pub mod summary;

use std::cell::OnceCell;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::bail;
use clap::Args;
use clap::builder::TypedValueParser;
use extricate::{Answer, Config, Effort, QueryOptions, Scene, Solver, Stream, StreamOptions};

use crate::args::{self, InputArgs, Limits, LoadArgs, choice, exits, seconds, share, threads, whole};
use crate::commands::{load_solver, with_advice};
use crate::input::BadLine;
use crate::output::Output;
use crate::progress::Progress;
use crate::report;
use constraints::ConstraintArgs;
use row::{QueryRow, header};
use summary::Summary;

/// Help text on the keys of `--json`.
const KEYS: &str = "With --json, each line is one object, in the order of the input: depth and lower_bound (in the scene's \
metric), gap (share of the depth that is not proved), unproved (the reason if nothing is proved, \"surfaces\", \"shallow\" \
or \"off\"; else null), witness, checks, max_displacement [m], colliding and touching (lists of [name, name]), outside (joints of the \
query beyond their limits), off (with --keep, at the query: numbers of links that are beyond their tolerances; those of --touch follow), kept (with \
--keep, at the witness: position [m] and rotation [rad] by which each link is off; with --touch, how far [m] each pair is beyond the \
clearance), clearance (least distance that the witness keeps [m], for pairs without a clearance of their \
own), verified, effort, contacts (at the witness: pair, distance [m], point_first, point_second, normal), gradient (of the \
depth), unique, cut_short (whether a limit ended the search), exits (with --exits: depth, witness, touching), segment (with \
--segment: colliding_until and free_from, fractions of the straight segment), free_radius (with --free-radius: in the \
metric, around the witness), nearest (with --continuous: depth of the nearest exit found), detour (with --continuous, if the \
witness goes back to it), seconds (time of the library call alone).";

/// Arguments of `query`.
#[derive(Args)]
#[command(after_help = KEYS)]
pub struct QueryArgs {
    /// Scene file (TOML) or URDF, which needs no learning; or a model file that `extricate learn`
    /// wrote, whose samples are additional starts
    #[arg(value_name = "SCENE|MODEL")]
    file: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    search: SearchArgs,
    /// End each query after about this many collision checks and distance evaluations, with the
    /// best answer so far. The search for a first free configuration is not limited
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, help_heading = "Budget")]
    max_checks: Option<usize>,
    /// End each query after about this many seconds, with the best answer so far. As with
    /// --max-checks, the search for a first free configuration is not limited
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Budget")]
    max_seconds: Option<f64>,
    /// Number of threads, 0 for one per core; the answers do not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true, default_value_t = 1, help_heading = "Budget")]
    threads: usize,
    /// Query in the world of this scene file. If the file names no robot, its obstacles, attached
    /// objects and pairs replace those of the scene or model; otherwise it must be a scene with the
    /// same joints. Stored samples of a model are verified anew when they are needed
    #[arg(long, visible_alias = "scene", value_name = "WORLD", help_heading = "World and constraints")]
    world: Option<PathBuf>,
    #[command(flatten)]
    constraints: ConstraintArgs,
    #[command(flatten)]
    stream: StreamArgs,
    /// Also print the witnesses, to the last digit, so that they are free as printed (--q and
    /// --json always print them)
    #[arg(long, help_heading = "Output")]
    witness: bool,
    /// Report which part of the straight segment from query to witness collides
    #[arg(long, help_heading = "Output")]
    segment: bool,
    /// With --effort nearest: report every colliding pair instead of one, and the contacts at the
    /// witness; the other efforts always report them
    #[arg(long, help_heading = "Output")]
    contacts: bool,
    #[command(flatten)]
    load: LoadArgs,
}

/// Options that set how far the search goes.
#[derive(Args)]
#[command(next_help_heading = "Search")]
struct SearchArgs {
    /// How hard to search
    #[arg(long, value_parser = effort(), default_value_t = Effort::Refined)]
    effort: Effort,
    /// Find up to K distinct exits, each a local minimum, nearest first; K must be 1 with --effort
    /// nearest
    #[arg(long, value_name = "K", value_parser = exits, allow_negative_numbers = true, default_value_t = 1)]
    exits: usize,
    /// Stop as soon as it is proved that no free configuration is nearer by more than this share of
    /// the depth. The default is 0.15 with --effort quick and refined, and 0.05 with proved, which
    /// searches until it is reached. With 0 the search does not stop early. Not allowed with
    /// several exits or --toward
    #[arg(long, value_name = "GAP", value_parser = share, allow_negative_numbers = true)]
    gap: Option<f64>,
    /// Run K descents instead of the number that the effort sets; fewer are faster and find the
    /// nearest exit less often. Not allowed with --effort nearest
    #[arg(long, value_name = "K", value_parser = args::starts, allow_negative_numbers = true)]
    starts: Option<usize>,
    /// How to treat a query beyond the joint limits, for example after a sensor error. By default
    /// it is answered: the depth is measured from the query as it is, and the witness is within the
    /// limits
    #[arg(long, value_enum, value_name = "LIMITS", default_value_t = Limits::Forgive)]
    limits: Limits,
}

/// Queries as frames of a motion.
#[derive(Args)]
#[command(next_help_heading = "Stream")]
struct StreamArgs {
    /// Treat the lines as frames of a motion: start each query from the last answer, which is
    /// faster if the frames are near each other
    #[arg(long, conflicts_with_all = ["threads", "exits"])]
    stream: bool,
    /// With --stream: keep an exit until another is nearer by more than this share of its depth
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true, default_value_t = 0.0, requires = "stream")]
    hysteresis: f64,
    /// With --stream: number of descents of a single query that each frame runs, besides those that
    /// cost no check. Successive frames run different ones; with more, a nearer exit is found
    /// sooner
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true, default_value_t = StreamOptions::default().starts_per_frame, requires = "stream")]
    starts_per_frame: usize,
    /// With --stream: the witness never jumps. From frame to frame it moves only along paths that
    /// are proved free, so it may stay behind an obstacle while another exit is nearer. It aims at
    /// --clearance, by default 0.5 mm more than the scene's
    #[arg(long, requires = "stream", conflicts_with = "hysteresis")]
    continuous: bool,
}

/// Parses an effort; `--help` describes each.
pub fn effort() -> impl TypedValueParser<Value = Effort> {
    let about = |effort| match effort {
        Effort::Nearest => {
            "The nearest stored boundary sample, or in many dimensions one nearly as near; verified when learned"
        }
        Effort::Quick => "Like refined, with fewer starts: about half the checks",
        Effort::Refined => "Several candidates, each refined by descents along the contact surface; verified now",
        Effort::Exhaustive => "Many starts and long refinement, for ground truth",
        Effort::Proved => {
            "Like refined, then branch and bound until --gap is proved or the budget is spent; give --max-seconds"
        }
        _ => "",
    };
    choice(Effort::ALL.iter().map(move |effort| (effort.name(), about(*effort))))
}

impl QueryArgs {
    /// Returns the options of the queries, except those that need the scene.
    pub fn options(&self) -> QueryOptions {
        let mut options = QueryOptions::default().effort(self.search.effort).exits(self.search.exits);
        (options.starts, options.gap) = (self.search.starts, self.search.gap);
        options.termination = args::termination(self.max_checks, self.max_seconds);
        (options.segment, options.contacts) = (self.segment, self.contacts);
        self.constraints.set(&mut options);
        options
    }

    fn stream(&self, solver: &Solver) -> extricate::Result<Option<Stream>> {
        let StreamArgs { stream, hysteresis, starts_per_frame, continuous } = self.stream;
        let options = StreamOptions::default().hysteresis(hysteresis).starts_per_frame(starts_per_frame);
        stream.then(|| solver.stream(options.continuous(continuous))).transpose()
    }
}

/// An answer, if anything free was found, and its time \[s\].
pub type Timed = (Option<Answer>, f64);

/// Answers queries in their order; with a stream, they are its next frames.
pub fn ask(solver: &Solver, stream: Option<&mut Stream>, queries: Vec<Config>, threads: usize) -> Vec<Timed> {
    let mut answers = Vec::with_capacity(queries.len());
    match stream {
        Some(stream) => {
            for q in &queries {
                let started = Instant::now();
                let answer = stream.query(q);
                answers.push((answer, started.elapsed().as_secs_f64()));
            }
        }
        None => {
            let threads = if queries.len() == 1 { 1 } else { threads };
            solver.batch_each(queries, threads, &mut |answered| {
                answers.push((answered.answer, answered.seconds));
                ControlFlow::Continue(())
            });
        }
    }
    answers
}

/// Longest warm-up of the solver; it takes no longer than loading the model did.
const MAX_WARM_UP: Duration = Duration::from_millis(30);

pub fn run(args: &QueryArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = args.input.open()?.with_limits(args.search.limits);
    let started = Instant::now();
    let solver = args.constraints.weighted(load_solver(&args.file, args.world.as_deref(), &args.load)?)?;
    solver.prepare();
    let loaded_in = started.elapsed();
    let mut options = args.options();
    args.constraints.set_in(solver.scene(), &mut options)?;
    let aim = options.clearance;
    let solver = solver.options(options)?;
    // Without a model, users want the first answer soon, so there is no warm-up.
    if solver.model().is_some() {
        solver.warm_up(MAX_WARM_UP.min(loaded_in));
    }
    let mut stream = args.stream(&solver)?;
    let scene = solver.scene();
    let told = OnceCell::new();
    let none_free = || told.get_or_init(|| with_advice(NONE_FREE, &solver)).as_str();
    // An answer may take seconds, so each is flushed: a later failure does not lose it. With
    // `nearest`, flushing a line would take longer than its answer.
    let flush_lines = configs.is_stream() || args.search.effort != Effort::Nearest;
    let mut report = Report::new(scene, flush_lines, json);
    report.aim = aim;
    report.tells_witness = args.witness || args.input.input.is_none();
    let mut progress = Progress::beside_rows("querying");
    let mut unanswered = 0;
    loop {
        let block = configs.next_block(scene, args.threads, &progress)?;
        if block.is_empty() {
            break;
        }
        let queries: Vec<Config> = block.iter().flatten().map(|(_, q)| q.clone()).collect();
        let mut answers = ask(&solver, stream.as_mut(), queries, args.threads).into_iter();
        for entry in block {
            match entry {
                Err(bad) => report.bad(&bad)?,
                Ok((line, _)) => match answers.next() {
                    Some((Some(answer), seconds)) => report.answer(line, &answer, seconds)?,
                    _ => {
                        unanswered += 1;
                        progress.aside(|| configs.report(&BadLine { line, error: NONE_FREE.into() }));
                        report.bad(&BadLine { line, error: none_free().into() })?;
                    }
                },
            }
        }
        progress.update(configs.fraction(), || report::counted(report.summary.queries(), "answer", "answers"));
    }
    report.finish()?;
    drop(progress);
    configs.conclude()?;
    if unanswered > 0 {
        let have = if unanswered == 1 { "query has" } else { "queries have" };
        bail!("{} {have} no answer: {}", report::count(unanswered), none_free());
    }
    Ok(())
}

/// Message for a query without an answer.
const NONE_FREE: &str = "no free configuration was found";

/// Share of the requested clearance that counts as all of it.
const KEPT_CLEARANCE_SHARE: f64 = 0.99;

/// Prints rows on standard output, then the summary.
struct Report<'a> {
    scene: &'a Scene,
    unit: &'static str,
    out: Output,
    json: bool,
    tells_witness: bool,
    /// Clearance that queries aim at \[m\].
    aim: Option<f64>,
    summary: Summary,
}

impl<'a> Report<'a> {
    fn new(scene: &'a Scene, flush_lines: bool, json: bool) -> Self {
        let (unit, out) = (report::metric_unit(scene), Output::new(flush_lines));
        Self { scene, unit, out, json, tells_witness: false, aim: None, summary: Summary::default() }
    }

    fn answer(&mut self, line: usize, answer: &Answer, seconds: f64) -> anyhow::Result<()> {
        if !self.json && self.summary.queries() == 0 {
            self.out.line(header(self.unit))?;
        }
        self.summary.add(answer, seconds);
        let row = QueryRow::new(answer, seconds, self.scene);
        if self.json {
            return self.out.json(&row);
        }
        self.out.line(row.text(line))?;
        // The proxy of a continuous stream keeps the requested clearance up to the error of linear
        // steps.
        if let Some(aim) = self.aim.filter(|aim| answer.clearance < KEPT_CLEARANCE_SHARE * aim) {
            let keeps = format!("keeps {} m: nothing was found that keeps {aim} m nearby", answer.clearance);
            self.out.line(format!("{:>6}  {keeps}", "but"))?;
        }
        if self.tells_witness { self.out.line(row.witness_text()) } else { Ok(()) }
    }

    fn bad(&mut self, bad: &BadLine) -> anyhow::Result<()> {
        if self.json { self.out.json(bad) } else { Ok(()) }
    }

    fn finish(mut self) -> anyhow::Result<()> {
        if !self.json && self.summary.queries() > 0 {
            if let Some(told) = report::what_a_unit_is(self.scene, "`weights` of the metric, or --weights,") {
                self.out.line(format_args!("\nin depths, {told}"))?;
            }
            // For a single query the figures would repeat its row.
            if self.summary.queries() > 1 {
                self.out.line("")?;
                self.out.line(report::two_columns(&self.summary.figures().rows(self.unit)))?;
            }
        }
        self.out.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::{Arg, ArgAction, CommandFactory};
    use extricate::QUERY_OPTIONS;

    /// Options of `query` that the library does not have.
    const OWN: [&str; 16] = [
        "continuous",
        "free",
        "help",
        "hysteresis",
        "input",
        "json",
        "limits",
        "load-limit",
        "packages",
        "q",
        "starts-per-frame",
        "stream",
        "threads",
        "weights",
        "witness",
        "world",
    ];

    fn read(line: &str) -> Result<QueryArgs, clap::Error> {
        match Cli::read(format!("extricate query scene.toml --q 0 {line}").split_whitespace())?.command {
            Command::Query(args) => Ok(args),
            _ => panic!("another command"),
        }
    }

    #[test]
    fn options_are_those_of_the_library() {
        let mut program = Cli::command();
        program.build();
        let command = program.find_subcommand("query").unwrap();
        let mut others: Vec<&str> = command.get_arguments().filter_map(Arg::get_long).collect();
        for option in QUERY_OPTIONS {
            let name = option.name.replace('_', "-");
            let argument = command.get_arguments().find(|argument| argument.get_long() == Some(&name));
            let argument = argument.unwrap_or_else(|| panic!("there is no --{name}"));
            assert!(argument.get_help().is_some(), "--{name}");
            let defaults: Vec<_> = argument.get_default_values().iter().map(|word| word.to_string_lossy()).collect();
            match option.default {
                "None" => assert!(defaults.is_empty(), "--{name}: {defaults:?}"),
                "False" => assert!(matches!(argument.get_action(), ArgAction::SetTrue), "--{name}"),
                word => assert_eq!(defaults, [word.trim_matches('\'')], "--{name}"),
            }
            others.retain(|other| *other != name);
        }
        others.sort_unstable();
        assert_eq!(others, OWN);
        assert_eq!(read("").ok().unwrap().options(), QueryOptions::default());
    }

    #[test]
    fn values_are_refused_with_what_the_library_expects() {
        let expected = |name: &str| QUERY_OPTIONS.iter().find(|option| option.name == name).unwrap().expected;
        for (name, value) in [
            ("exits", "0"),
            ("starts", "100001"),
            ("gap", "1"),
            ("clearance", "-1"),
            ("toward_share", "-1"),
            ("max_seconds", "0"),
        ] {
            let option = format!("--{}", name.replace('_', "-"));
            let message = read(&format!("--toward 0 {option} {value}")).err().unwrap().to_string();
            for part in [&option, value, &format!("expected {}", expected(name))] {
                assert!(message.contains(part), "{part} is not in {message}");
            }
        }
        let message = read("--effort lucky").err().unwrap().to_string();
        assert!(Effort::ALL.iter().all(|effort| message.contains(effort.name())), "{message}");
        let message = read("--exits 2 --gap 0.1").err().unwrap().to_string();
        assert!(message.contains("--exits: got 2, expected 1 with a gap to prove"), "{message}");
    }
}

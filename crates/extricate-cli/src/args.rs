//! The command line: the list of commands and the types of their values.

use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::styling::Styles;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use extricate::{ConfigSpace, LoadLimit, LoadLimits, LoadOptions, QueryOptions, Termination, Toward};

use crate::commands::{
    check, demo, distance, escape, grasp, import, info, learn, plan, query, repair, report, sample, shell, view,
};
use crate::input::Configs;

/// The globally nearest collision-free configuration of an articulated robot, verified and bounded.
///
/// A configuration is a list of coordinates, in the order that `extricate info SCENE` prints.
/// Angles are in rad, lengths in m; rotations are unit quaternions x, y, z, w.
#[derive(Parser)]
#[command(name = "extricate", version, arg_required_else_help = true, styles = Styles::plain())]
#[command(max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 the operation failed, 2 the command line is invalid.")]
pub struct Cli {
    /// Print JSON, one object per line, instead of text
    #[arg(long, global = true)]
    pub json: bool,
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Reads a command line, which begins with the name of the program.
    ///
    /// # Errors
    /// Fails if clap rejects the command line, or if the library refuses its query options.
    pub fn read(words: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Result<Self, clap::Error> {
        let cli = Self::from_arg_matches(&with_groups(Self::command()).try_get_matches_from(words)?)?;
        let checked = match &cli.command {
            Command::Query(args) => args.options().check().map_err(|error| refused("query", &error)),
            Command::View(args) => args.options().check().map_err(|error| refused("view", &error)),
            _ => Ok(()),
        };
        checked.map(|()| cli)
    }
}

/// Commands as `--help` lists them, grouped by purpose.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Ask", &["query", "distance", "check", "escape", "plan", "repair", "grasp"]),
    ("See", &["info", "view", "report", "demo"]),
    ("Learn", &["learn"]),
    ("Files", &["sample", "import", "completions", "man"]),
];
/// Width of the list of commands in columns; it does not follow the width of the terminal.
const HELP_COLUMNS: usize = 80;
/// Column at which the descriptions in the list of commands begin.
const ABOUT_COLUMN: usize = 15;

/// Makes the help of the program list the commands in groups.
fn with_groups(program: clap::Command) -> clap::Command {
    let mut listed = String::new();
    for (group, names) in GROUPS {
        listed += &format!("{group}:\n");
        for command in names.iter().filter_map(|name| program.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            listed += &entry(command.get_name(), &about);
        }
        listed += "\n";
    }
    let help = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{listed}`extricate COMMAND --help` explains a command.\n\n\
         Options:\n{{options}}{{after-help}}"
    );
    program.help_template(help)
}

/// Formats a name and its description in lines of [`HELP_COLUMNS`].
fn entry(name: &str, about: &str) -> String {
    let mut text = format!("{:<ABOUT_COLUMN$}", format!("  {name}"));
    let mut column = text.len();
    for word in about.split(' ') {
        if column + 1 + word.len() > HELP_COLUMNS {
            text += &format!("\n{:ABOUT_COLUMN$}", "");
            column = ABOUT_COLUMN;
        }
        let gap = if column == ABOUT_COLUMN { "" } else { " " };
        text += &format!("{gap}{word}");
        column += gap.len() + word.len();
    }
    text + "\n"
}

/// Returns the error for a query option that the library refuses. It spells the option as on the
/// command line and shows the usage of `command`.
fn refused(command: &str, error: &extricate::Error) -> clap::Error {
    let problem = match error {
        extricate::Error::Option { name, value, expected } => {
            format!("--{}: got {value}, expected {expected}", name.replace('_', "-"))
        }
        other => other.to_string(),
    };
    let mut program = Cli::command();
    program.build();
    let found = program.find_subcommand(command).cloned();
    found.unwrap_or(program).error(ErrorKind::ArgumentConflict, problem)
}

/// The commands, one variant each.
#[derive(Subcommand)]
pub enum Command {
    /// Learn a built-in scene, answer a thousand queries, print a table and write a page that shows
    /// some answers
    Demo(demo::DemoArgs),
    /// Convert a world of MoveIt (.scene, or PlanningScene as YAML or JSON) to a scene file
    Import(import::ImportArgs),
    /// Describe a scene (joints in order, pairs, warnings) or a model (its statistics)
    Info(info::InfoArgs),
    /// Report for each configuration whether it is free, its clearance and the pairs that collide
    Check(check::CheckArgs),
    /// Draw uniformly random configurations, as JSON lines that the other commands read
    Sample(sample::SampleArgs),
    /// Learn a scene once and write the result to a model file
    Learn(learn::LearnArgs),
    /// Find the free configuration nearest to each given one
    Query(query::QueryArgs),
    /// Measure how far configurations are from the boundary of the free ones, with a proved bound
    Distance(distance::DistanceArgs),
    /// Release a hand whose fingers penetrate the object that it holds, and keep its contacts
    Grasp(grasp::GraspArgs),
    /// Print a script that lets a shell complete the command line
    Completions(shell::CompletionsArgs),
    /// Write manual pages, one per command, to a folder
    Man(shell::ManArgs),
    /// Measure a model and write a page of the results, so that you can judge the model
    Report(report::ReportArgs),
    /// Show a scene, configurations and their answers on a page for a browser
    View(view::ViewArgs),
    /// Find a path out of collision for each configuration, on which no collision gets worse
    Escape(escape::EscapeArgs),
    /// Find a path between two configurations, even through narrow passages
    Plan(plan::PlanArgs),
    /// Turn a path that collides into a free one, as near to the old path as possible
    Repair(repair::RepairArgs),
}

/// Options that give the configurations.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct InputArgs {
    /// A configuration: its coordinates, separated by commas, such as 0,0.3,0,-1.8,0,2,0.8. The
    /// option may be repeated
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    pub q: Vec<String>,
    /// File of configurations, one per line: `{"q": [...]}`, a bare array, numbers separated by
    /// commas or blanks (a first line may name their joints), or positions by joint, `{"name":
    /// [...], "position": [...]}` or `{"q": {"joint": 0.5, ...}}`. `-` reads standard input. Empty
    /// lines and lines that begin with # are skipped. If a line cannot be used, the command reports
    /// it on standard error with its number, lines with the same fault only once. With --json it
    /// also prints `{"line": N, "error": "..."}` in place of the answer. It answers the other
    /// lines, and the exit status is 1
    #[arg(long, value_name = "FILE")]
    pub input: Option<PathBuf>,
}

impl InputArgs {
    /// Opens the file, or reads the configurations from the command line.
    ///
    /// # Errors
    /// Fails if the file cannot be opened.
    pub fn open(&self) -> anyhow::Result<Configs> {
        self.input.as_deref().map_or_else(|| Ok(Configs::of_words(&self.q)), Configs::open)
    }
}

/// How scenes are loaded.
#[derive(Args, Default)]
pub struct LoadArgs {
    /// Folder to search first for `package://NAME/...`: one that contains the folder NAME, or the
    /// package itself. The option may be repeated. The search continues in `packages` of the scene
    /// file, the folders that contain the URDF, and the folders of AMENT_PREFIX_PATH and
    /// ROS_PACKAGE_PATH
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    packages: Vec<PathBuf>,
    /// Change a limit on the content of files, such as `triangles=50000000`. The option may be
    /// repeated. docs/reference/limits.md lists the names, as does the error for an unknown name
    #[arg(long = "load-limit", value_name = "NAME=N", value_parser = load_limit, help_heading = "Files")]
    load_limits: Vec<(LoadLimit, usize)>,
}

impl LoadArgs {
    pub fn limits(&self) -> LoadLimits {
        self.load_limits.iter().fold(LoadLimits::default(), |limits, (limit, most)| limits.with(*limit, *most))
    }

    /// Returns the limits and the package folders as options of the library.
    pub fn options(&self) -> LoadOptions {
        LoadOptions::default().limits(self.limits()).packages(self.packages.clone())
    }
}

/// Parses `NAME=N`, the name and the value of a limit.
fn load_limit(text: &str) -> Result<(LoadLimit, usize), String> {
    let (name, most) = text.split_once('=').unwrap_or((text, ""));
    let limit = LoadLimit::ALL.into_iter().find(|limit| limit.name() == name);
    let limit = limit.ok_or_else(|| {
        let names: Vec<&str> = LoadLimit::ALL.into_iter().map(LoadLimit::name).collect();
        format!("expected one of {}, then = and a number", names.join(", "))
    })?;
    Ok((limit, number(most).ok_or_else(|| format!("expected a whole number after {name}="))?))
}

/// How a configuration beyond the joint limits is treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Limits {
    /// Accept it as a query; it is not free
    Forgive,
    /// Refuse the line that contains it
    Refuse,
}

/// Parses one of the library's choices; `--help` lists its words with their meanings.
pub fn choice<T>(words: impl Iterator<Item = (&'static str, &'static str)>) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err = extricate::Error> + Clone + Send + Sync + 'static,
{
    let values = words.map(|(word, about)| PossibleValue::new(word).help(about));
    PossibleValuesParser::new(values).try_map(|word| word.parse())
}

pub fn termination(max_checks: Option<usize>, max_seconds: Option<f64>) -> Termination {
    let mut termination = Termination::default();
    (termination.max_checks, termination.max_seconds) = (max_checks, max_seconds);
    termination
}

/// Returns a goal with this share. Its configuration is a placeholder until the scene is known.
pub fn goal_to_come(share: f64) -> Toward {
    let goal = ConfigSpace::default().config(&[]).expect("nothing is a configuration of nothing");
    Toward::new(goal, share)
}

/// Returns `value` unless the library refuses it for the option that `set` sets.
fn checked<T: Copy>(value: T, set: impl FnOnce(QueryOptions, T) -> QueryOptions) -> Result<T, String> {
    match set(QueryOptions::default(), value).check() {
        Err(extricate::Error::Option { expected, .. }) => Err(format!("expected {expected}")),
        _ => Ok(value),
    }
}

fn real(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "expected a number".into())
}

pub fn seconds(text: &str) -> Result<f64, String> {
    checked(real(text)?, |options, seconds| options.termination(Termination::after_seconds(seconds)))
}

/// Parses a share below 1.
pub fn share(text: &str) -> Result<f64, String> {
    checked(real(text)?, QueryOptions::gap)
}

/// Parses a share that may exceed 1.
pub fn share_or_more(text: &str) -> Result<f64, String> {
    checked(real(text)?, |options, share| options.toward(goal_to_come(share)))
}

pub fn length(text: &str) -> Result<f64, String> {
    checked(real(text)?, QueryOptions::clearance)
}

/// Parses a distance in metric units.
pub fn above_zero(text: &str) -> Result<f64, String> {
    let value = real(text)?;
    if value > 0.0 { Ok(value) } else { Err("expected a number above 0".into()) }
}

/// Parses a whole number, written with digits, or with an exponent as in `1e4` or `2.5e3`.
fn whole_number(text: &str) -> Option<u64> {
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let value: f64 = text.parse().ok().filter(|_| text.contains(['e', 'E']))?;
    // Beyond this bound every float is whole, whatever digits were meant.
    (value.fract() == 0.0 && (0.0..9e15).contains(&value)).then_some(value as u64)
}

fn number<T: TryFrom<u64>>(text: &str) -> Option<T> {
    whole_number(text).and_then(|value| value.try_into().ok())
}

pub fn positive(text: &str) -> Result<usize, String> {
    let value = number(text).filter(|value| *value > 0);
    value.ok_or_else(|| format!("expected a whole number from 1 to {}", usize::MAX))
}

/// Parses a whole number, which may be 0.
pub fn whole(text: &str) -> Result<usize, String> {
    number(text).ok_or_else(|| format!("expected a whole number from 0 to {}", usize::MAX))
}

pub fn seed(text: &str) -> Result<u64, String> {
    number(text).ok_or_else(|| format!("expected a whole number from 0 to {}", u64::MAX))
}

pub fn exits(text: &str) -> Result<usize, String> {
    checked(whole(text)?, QueryOptions::exits)
}

pub fn starts(text: &str) -> Result<usize, String> {
    checked(whole(text)?, QueryOptions::starts)
}

/// Largest number of threads; starting more takes longer than they save on any machine.
const MAX_THREADS: usize = 1024;

/// Parses a port; 0 means any free port.
pub fn port(text: &str) -> Result<u16, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u16::MAX))
}

pub fn threads(text: &str) -> Result<usize, String> {
    let value = number(text).filter(|value| *value <= MAX_THREADS);
    value.ok_or_else(|| format!("expected 0 (one per core) to {MAX_THREADS}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_is_in_one_group() {
        let mut program = with_groups(Cli::command());
        let plain = Cli::command();
        let mut known: Vec<&str> = plain.get_subcommands().map(clap::Command::get_name).collect();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        known.sort_unstable();
        grouped.sort_unstable();
        assert_eq!(known, grouped);
        let help = program.render_long_help().to_string();
        let shown: Vec<&str> =
            GROUPS.iter().map(|(group, _)| *group).filter(|group| help.contains(&format!("\n{group}:\n"))).collect();
        assert_eq!(shown, ["Ask", "See", "Learn", "Files"]);
    }

    #[test]
    fn every_command_of_the_manual_parses() {
        for line in [
            "demo",
            "demo --scene shelf-arm --queries 10 --out a.html --seed 3 --seconds 2.5 --json",
            "demo --export dir",
            "info scene.toml --pairs",
            "info scene.toml --load-limit triangles=50000000 --load-limit links=1",
            "learn scene.toml -o m.model --labels 1e4",
            "query m.model --input q.jsonl --max-checks 2.5e3 --exits 1e1",
            "info scene.toml --load-limit triangles=5e7",
            "info robot.urdf --packages ws/src --packages vendor",
            "import table.scene -o world.toml --robot robot.urdf",
            "check scene.toml --input -",
            "check m.model --q 0,0.3 --q -1,2",
            "sample scene.toml -n 5 --seed 1 --colliding",
            "learn scene.toml -o m.model --labels 1000 --seconds 5 --seed 2 --threads 2",
            "query m.model --input q.jsonl --effort exhaustive --json",
            "query m.model --input q.jsonl --exits 3 --starts 4 --max-checks 0 --max-seconds 1e-4 --segment --threads 0",
            "query m.model --input q.jsonl --effort nearest --exits 1",
            "query m.model --input q.jsonl --stream --hysteresis 0.1 --starts-per-frame 0",
            "query m.model --input q.jsonl --scene moved.toml",
            "query m.model --input q.jsonl --world world.toml --clearance 0.01 --locked a,b --free-radius",
            "query s.toml --q 1,2 --free a --weights a=4,b=0.5 --toward 0,0 --toward-share 0.5",
            "query scene.toml --q 0,0.3,-1 --q -1,2,3",
            "escape scene.toml --q 0,0.3,-1 --aim 0.01 --tolerance 0 --exits 3 --max-checks 100",
            "escape m.model --input - --world w.toml --seed 3",
            "plan scene.toml --from 0,0.3 --to -1,2 --roadmap r --max-seconds 3 --no-shortcut",
            "repair m.model --path p.jsonl --world w.toml --aim 0.02 --max-deviation 0.5",
            "query robot.urdf --input - --witness --limits refuse",
            "--json query m.model --input q.jsonl",
            "grasp hand.toml --input g.jsonl --object ball --keep pose --touch 0 --friction 0 --open 0,-1 --locked base",
            "grasp hand.model --input g.jsonl --objects meshes -o out.jsonl --resume --threads 2 --scene-weights",
            "report m.model -o report.html -n 50 --seed 2",
            "view robot.urdf",
            "view m.model --q 0,0.3 --q -1,2 --exits 4 --effort exhaustive -o page.html",
            "view scene.toml --input q.jsonl --answers a.jsonl --serve",
            "view scene.toml -n 20 --seed 3 --world world.toml --effort proved --serve 8000",
        ] {
            let words = std::iter::once("extricate").chain(line.split(' '));
            assert!(Cli::read(words).is_ok(), "{line}");
        }
    }

    #[test]
    fn counts_are_whole_numbers() {
        for (text, count) in [("7", 7), ("1e4", 10_000), ("2.5e3", 2500), ("1E+2", 100), ("0e0", 0)] {
            assert_eq!(whole(text), Ok(count), "{text}");
        }
        for text in ["1e-3", "1.5", "10.0", "1.23e1", "1e99", "-1e3", "e", "inf", "1e", ""] {
            assert!(whole(text).unwrap_err().starts_with("expected a whole number"), "{text}");
        }
        assert!(positive("0e3").is_err() && threads("2e3").is_err() && exits("1e1") == Ok(10));
    }

    #[test]
    fn senseless_values_are_usage_errors() {
        for line in [
            "",
            "learn scene.toml",
            "learn scene.toml -o m --seconds 0",
            "learn scene.toml -o m --seconds nan",
            "learn scene.toml -o m --labels 0",
            "learn scene.toml -o m --labels -1",
            "learn scene.toml -o m --seconds -1",
            "learn scene.toml -o m --threads -1",
            "learn scene.toml -o m --threads 100000",
            "sample scene.toml -n -1",
            "sample scene.toml --seed 1.5",
            "query m.model",
            "import table.scene",
            "check scene.toml --q 0 --segments",
            "query m.model --input q --q 0",
            "query m.model --input q --effort hard",
            "query m.model --input q --exits 0",
            "query m.model --input q --starts 0",
            "query m.model --input q --exits -1",
            "query m.model --input q --exits 1000000000000",
            "query m.model --input q --starts -1",
            "query m.model --input q --starts 1000000000000",
            "escape m.model --input q --exits 1000000000000",
            "query m.model --input q --max-checks -1",
            "query m.model --input q --max-seconds -1",
            "query m.model --input q --threads -1",
            "query m.model --input q --stream --hysteresis -0.1",
            "query m.model --input q --effort nearest --exits 2",
            "query m.model --input q --effort nearest --starts 2",
            "query m.model --input q --stream --hysteresis 1",
            "query m.model --input q --stream --starts-per-frame -1",
            "query m.model --input q --stream --starts-per-frame many",
            "query m.model --input q --starts-per-frame 2",
            "query m.model --input q --toward 0,0 --gap 0.1",
            "query m.model --input q --toward 0,0 --effort proved",
            "query m.model --input q --exits 2 --gap 0.1",
            "query m.model --input q --gap 1",
            "query m.model --input q --max-seconds 0",
            "report",
            "report m.model -n 0",
            "view",
            "view scene.toml --count 0",
            "view scene.toml --q 0 --input q.jsonl",
            "view scene.toml --answers a.jsonl",
            "view scene.toml --effort nearest --exits 2",
            "view scene.toml --serve 8000 -o page.html",
            "view scene.toml --serve 70000",
            "view scene.toml --wasm x.wasm",
            "view scene.toml --answers a.jsonl --objects meshes --live",
            "escape scene.toml --q 0 --exits 0",
            "escape scene.toml --q 0 --tolerance -1",
            "plan scene.toml --from 0",
            "demo --scene nowhere",
            "demo --queries -1",
            "info scene.toml --load-limit triangles",
            "info scene.toml --load-limit triangle=1",
            "info scene.toml --load-limit triangles=-1",
        ] {
            let words = std::iter::once("extricate").chain(line.split(' ').filter(|w| !w.is_empty()));
            let error = Cli::read(words).err().unwrap_or_else(|| panic!("accepted: {line}"));
            assert_eq!(error.exit_code(), 2, "{line}");
            let says_what_is_expected = |text: String| text.contains("expected") || !text.contains("invalid value");
            assert!(!error.to_string().contains("unexpected argument"), "{error}");
            assert!(
                says_what_is_expected(error.to_string()) || error.to_string().contains("possible values"),
                "{error}"
            );
        }
    }
}

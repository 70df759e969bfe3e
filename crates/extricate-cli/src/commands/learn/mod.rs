//! `extricate learn`: learns a scene and writes a model file.

pub mod with_progress;

use std::path::PathBuf;

use clap::Args;
use extricate::files::{self, OutputLock};
use extricate::{Density, EndedBy, LearnOptions, Scene, Statistics};
use serde::Serialize;

use super::{disable_line, load_scene, prepare, tell_warnings};
use crate::args::{LoadArgs, positive, seconds, seed, threads};
use crate::interrupt;
use crate::notice;
use crate::output::Output;
use crate::report::{self, count, duration, percent};
use with_progress::{Learned, learn_with_progress, memory_in_words, peak_memory};

/// Number of configurations in which pairs are tested for permanent collision. Few suffice, because
/// such a pair collides in the first one already.
const ALWAYS_COLLIDING_SAMPLES: u64 = 100;

/// Arguments of `learn`.
#[derive(Args)]
#[command(
    after_help = "Learning ends when the labels or the seconds are spent. With --labels and without --seconds, the model does \
                        not depend on the speed of the machine: the same scene, seed and labels give the same model, with any \
                        number of threads. Ctrl-C ends learning early and keeps the samples found so far; a second Ctrl-C ends \
                        the program at once."
)]
pub struct LearnArgs {
    /// Scene file (TOML), URDF, or a model file, whose scene is learned anew
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    /// Model file to write
    #[arg(short = 'o', long = "output", value_name = "MODEL")]
    output: PathBuf,
    /// Most exact collision checks to spend [default: 160000]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true, help_heading = "Budget")]
    labels: Option<usize>,
    /// Most seconds to spend [default: 5, or no limit with --labels]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Budget")]
    seconds: Option<f64>,
    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "S", value_parser = seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Number of threads, 0 for one per core; the model does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_negative_numbers = true, help_heading = "Budget")]
    threads: usize,
    /// Print all statistics, as `info` of the model does
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Report<'a> {
    model: String,
    interrupted: bool,
    seconds: f64,
    /// Peak memory of the process \[bytes\].
    memory: Option<u64>,
    statistics: &'a Statistics,
}

pub fn run(args: &LearnArgs, json: bool) -> anyhow::Result<()> {
    files::check_model_output(&args.output)?;
    files::check_not_read(&args.output, [args.scene.as_path()])?;
    let _lock = OutputLock::take(&args.output)?;
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    warn_of_pairs_always_colliding(&scene);
    let Learned { model, seconds, interrupted } = learn_with_progress(scene, &options(args))?;
    interrupt::uninterrupted(|| extricate::save_model(&model, &args.output))?;
    let unit = report::metric_unit(model.scene());
    let statistics = model.statistics();
    let mut out = Output::new(false);
    if json {
        let model = args.output.display().to_string();
        let memory = peak_memory();
        out.json(&Report { model, interrupted, seconds, memory, statistics })?;
    } else {
        out.line(verdict(statistics))?;
        if args.verbose {
            out.line(report::two_columns(&statistics_rows(statistics, unit)))?;
        }
        out.line(format_args!("learned in {}{}", duration(seconds), memory_in_words()))?;
        out.line(format_args!("wrote {}", args.output.display()))?;
    }
    out.finish()
}

/// Rates a model by the share of its answers that are within 5 % of those of a longer search.
pub fn word_for(within_5pct: f64) -> &'static str {
    match within_5pct {
        share if share >= 0.98 => "Good",
        share if share >= 0.9 => "Fair",
        _ => "Learn longer",
    }
}

/// Returns the first line of output after learning.
fn verdict(statistics: &Statistics) -> String {
    let labels = count(statistics.labels);
    let Some(excess) = statistics.excess else {
        return format!("Not measured: nothing that collides was held out; {labels} checks were spent");
    };
    format!(
        "{}: {} of held-out collisions are answered within 5 % of a longer search; {labels} checks were spent",
        word_for(excess.within_5pct),
        percent(excess.within_5pct),
    )
}

/// Describes a model's statistics for people.
pub fn statistics_rows(statistics: &Statistics, unit: &str) -> Vec<(&'static str, String)> {
    let ended = match statistics.ended_by {
        EndedBy::Seconds => " (ended by the time limit)",
        EndedBy::Interruption => " (interrupted)",
        _ => "",
    };
    vec![
        ("labels spent", format!("{} exact checks{ended}", count(statistics.labels))),
        ("seed", statistics.seed.to_string()),
        (
            "boundary samples",
            format!(
                "{}, all verified free; {} of them exits of solved configurations{}",
                count(statistics.boundary_samples),
                count(statistics.solved_samples),
                if statistics.stand_ins > 0 {
                    format!("; {} free configurations that stand in for more", count(statistics.stand_ins))
                } else {
                    String::new()
                }
            ),
        ),
        (
            "boundary gap",
            match statistics.boundary_gap {
                Some(gap) => format!("{gap:.3e} {unit} at most to a colliding configuration"),
                None => "no boundary found; free configurations stand in for its samples".into(),
            },
        ),
        ("support vectors", count(statistics.support_vectors)),
        ("colliding share", format!("{} of uniform configurations", percent(statistics.colliding_share))),
        ("held-out accuracy", held_out_accuracy(statistics)),
        ("sample density", sample_density(statistics, unit)),
        ("excess of queries", excess_of_queries(statistics)),
        ("gap of queries", gap_of_queries(statistics)),
        ("spent on measuring", format!("{} checks", count(statistics.measuring_checks))),
    ]
}

fn sample_density(statistics: &Statistics, unit: &str) -> String {
    let Some(Density { spacing_median, spacing_p95, reach_median, reach_p95 }) = statistics.density else {
        return "not measured".into();
    };
    format!(
        "{spacing_median:.4} {unit} to the next sample (95 %: {spacing_p95:.4}), {reach_median:.4} {unit} from held-out \
         collisions (95 %: {reach_p95:.4})"
    )
}

fn excess_of_queries(statistics: &Statistics) -> String {
    let Some(excess) = statistics.excess else { return "not measured".into() };
    format!(
        "median {:.2} %, 95th percentile {:.2} %; {} within 5 % of a longer search ({}), {} held-out collisions",
        100.0 * excess.median,
        100.0 * excess.p95,
        percent(excess.within_5pct),
        interval(excess.within_5pct_interval),
        excess.queries
    )
}

fn gap_of_queries(statistics: &Statistics) -> String {
    let Some(gap) = statistics.gap else { return "not measured".into() };
    format!(
        "{} of the depth not proved in the median, 95th percentile {}; {} held-out collisions",
        percent(gap.median),
        percent(gap.p95),
        gap.queries
    )
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("95 % interval {} to {}", percent(low), percent(high))
}

/// Describes the classifier's accuracy in words.
pub fn held_out_accuracy(statistics: &Statistics) -> String {
    let side = |name: &str, accuracy: Option<f64>, range: Option<[f64; 2]>| match (accuracy, range) {
        (Some(share), Some(range)) => format!("{} on {name} ({})", percent(share), interval(range)),
        _ => format!("- on {name}"),
    };
    if statistics.accuracy_free.is_none() && statistics.accuracy_colliding.is_none() {
        return "nothing was held out".into();
    }
    let free = side("free", statistics.accuracy_free, statistics.accuracy_free_interval);
    let colliding =
        side("colliding configurations", statistics.accuracy_colliding, statistics.accuracy_colliding_interval);
    format!("{free}, {colliding}")
}

fn options(args: &LearnArgs) -> LearnOptions {
    let default = LearnOptions::default();
    // Users who limit labels want the same model on every machine; a silent time limit would break
    // that.
    let seconds = if args.labels.is_some() { args.seconds } else { args.seconds.or(default.seconds) };
    let (labels, seed) = (args.labels.unwrap_or(default.labels), args.seed.unwrap_or(default.seed));
    let mut options = default.labels(labels).seed(seed).threads(args.threads);
    options.seconds = seconds;
    options
}

fn warn_of_pairs_always_colliding(scene: &Scene) {
    let checker = prepare(scene.clone());
    let pairs = checker.pairs_always_colliding(ALWAYS_COLLIDING_SAMPLES);
    if pairs.is_empty() {
        return;
    }
    let (count, verb) =
        if pairs.len() == 1 { ("1 pair", "collides") } else { (&*format!("{} pairs", pairs.len()), "collide") };
    notice::warning(format_args!(
        "{count} {verb} in every sampled configuration; where that is by design, add to the scene under [pairs]: {}",
        disable_line(&report::pair_names(scene, &pairs))
    ));
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use clap::CommandFactory;
    use extricate::Excess;
    use serde_json::json;

    /// Statistics with these fields; the others are small.
    pub fn statistics(fields: serde_json::Value) -> Statistics {
        let mut all = json!({
            "labels": 10, "seed": 1, "boundary_samples": 3, "solved_samples": 1, "stand_ins": 0, "support_vectors": 0,
            "colliding_share": 0.0, "accuracy_free": null, "accuracy_free_interval": null, "accuracy_colliding": null,
            "accuracy_colliding_interval": null, "boundary_gap": null, "density": null, "excess": null, "gap": null,
            "measuring_checks": 0, "ended_by": "seconds",
        });
        let given = fields.as_object().cloned().unwrap_or_default();
        all.as_object_mut().unwrap().extend(given);
        serde_json::from_value(all).unwrap()
    }

    fn args(labels: Option<usize>, seconds: Option<f64>) -> LearnArgs {
        LearnArgs {
            scene: "s".into(),
            output: "m".into(),
            labels,
            seconds,
            seed: None,
            threads: 0,
            verbose: false,
            load: LoadArgs::default(),
        }
    }

    #[test]
    fn labels_alone_set_no_time_limit() {
        assert_eq!(options(&args(Some(500), None)).seconds, None);
        assert_eq!(options(&args(Some(500), Some(3.0))).seconds, Some(3.0));
        assert_eq!(options(&args(None, None)).seconds, LearnOptions::default().seconds);
        assert_eq!(options(&args(None, None)).labels, LearnOptions::default().labels);
    }

    #[test]
    fn the_help_states_the_defaults() {
        let help = crate::args::Cli::command().find_subcommand_mut("learn").unwrap().render_help().to_string();
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        let default = LearnOptions::default();
        assert!(help.contains(&format!("[default: {}]", default.labels)), "{help}");
        assert!(help.contains(&format!("[default: {}, or no limit", default.seconds.unwrap())), "{help}");
        assert!(help.contains(&format!("numbers [default: {}]", default.seed)), "{help}");
    }

    #[test]
    fn statistics_claim_no_more_than_was_found() {
        let mut statistics = statistics(json!({ "stand_ins": 2, "ended_by": "labels" }));
        let text = |statistics: &Statistics| report::two_columns(&statistics_rows(statistics, "rad"));
        assert!(text(&statistics).contains("no boundary found") && text(&statistics).contains("nothing was held out"));
        assert_eq!(text(&statistics).matches("not measured").count(), 3);
        (statistics.boundary_gap, statistics.accuracy_free) = (Some(1e-3), Some(0.97));
        statistics.accuracy_free_interval = Some([0.9, 0.99]);
        statistics.excess = Excess::of(&[0.0; 64]);
        let text = text(&statistics);
        assert!(text.contains("1.000e-3 rad at most"), "{text}");
        assert!(text.contains("97 % on free (95 % interval 90 % to 99 %), - on"), "{text}");
        assert!(
            text.contains("100 % within 5 % of a longer search (95 % interval 94.3 % to 100 %), 64 held"),
            "{text}"
        );
    }
}

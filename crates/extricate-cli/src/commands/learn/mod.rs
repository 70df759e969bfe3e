//! `extricate learn`: a scene in, a model file out.

pub mod run;

use std::path::PathBuf;

use clap::Args;
use extricate::internals::collision::pairs_always_colliding;
use extricate::internals::io;
use extricate::internals::model::EndedBy;
use extricate::internals::model::evaluate::figures::Density;
use extricate::{LearnOptions, Learner, Scene, Statistics};
use serde::Serialize;

use super::{disable_line, load_scene, prepare, tell_warnings};
use crate::args::{LoadArgs, positive, seconds, seed, share, threads};
use crate::notice;
use crate::output::Output;
use crate::report::{self, count, duration, percent};
use run::{Keep, KeepArgs, Learned, kept_at, memory_in_words, peak_memory, run_with_progress, save};

/// Configurations tried for pairs that always collide; few, because such a pair collides in the
/// first one already.
const ALWAYS_COLLIDING_SAMPLES: u64 = 100;

/// Arguments of `learn`.
#[derive(Args)]
#[command(
    after_help = "Learning ends when the labels or the seconds are spent. Give --labels without --seconds for a model \
                        that does not depend on the speed of the machine: the same scene, seed and labels give the same \
                        model, whatever the number of threads. Ctrl-C ends learning early, keeps what was learned \
                        and leaves a checkpoint, from which --resume goes on to the same model; a second one ends at once."
)]
pub struct LearnArgs {
    /// Scene file (TOML), URDF, or a model file, whose scene is learned anew
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    /// Model file to write
    #[arg(short = 'o', long = "output", value_name = "MODEL")]
    output: PathBuf,
    /// Most exact collision checks to spend [default: 500000]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true, help_heading = "Budget")]
    labels: Option<usize>,
    /// Most seconds to spend [default: 90, or no limit with --labels]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Budget")]
    seconds: Option<f64>,
    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "S", value_parser = seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Threads; 0 for one per core. The model does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_negative_numbers = true, help_heading = "Budget")]
    threads: usize,
    /// Most memory for what is found, in MiB; learning ends there [default: 4096]
    #[arg(long, value_name = "MIB", value_parser = positive, allow_negative_numbers = true, help_heading = "Budget")]
    memory: Option<usize>,
    /// End where at least 95 % of 64 held-out colliding configurations are answered with at most
    /// this excess over a search about ten times as long, as 0.05
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = "Budget")]
    target_excess: Option<f64>,
    /// End where classifier and labels disagree on at most this share of held-out configurations,
    /// as 0.03; with both, where both hold
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = "Budget")]
    target_disagreement: Option<f64>,
    /// Print all statistics, as `info` of the model does
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    keep: KeepArgs,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Report<'a> {
    model: String,
    /// Only of a run that was interrupted.
    checkpoint: Option<String>,
    interrupted: bool,
    seconds: f64,
    /// Peak of the process in bytes.
    memory: Option<u64>,
    statistics: &'a Statistics,
}

/// Runs the command.
pub fn run(args: &LearnArgs, json: bool) -> anyhow::Result<()> {
    io::check_model_output(&args.output)?;
    let keep = args.keep.keep(&args.output, &[&args.scene])?;
    let learner = if args.keep.resume { resumed(args, &keep)? } else { begun(args, &keep)? };
    let unit = report::metric_unit(learner.scene());
    let learned = run_with_progress(learner, Some(&keep))?;
    save(&learned, &args.output, &keep)?;
    let Learned { model, seconds, interrupted } = learned;
    let statistics = model.statistics();
    let kept = interrupted.then(|| keep.path.display().to_string());
    let mut out = Output::new(false);
    if json {
        let model = args.output.display().to_string();
        let memory = peak_memory();
        out.json(&Report { model, checkpoint: kept, interrupted, seconds, memory, statistics })?;
    } else {
        out.line(verdict(statistics))?;
        if args.verbose {
            out.line(report::two_columns(&statistics_rows(statistics, unit)))?;
        }
        out.line(format_args!("learned in {}{}", duration(seconds), memory_in_words()))?;
        out.line(format_args!("wrote {}", args.output.display()))?;
        if interrupted {
            out.line(kept_at(&keep))?;
        }
    }
    out.finish()
}

/// A run from nothing.
fn begun(args: &LearnArgs, keep: &Keep) -> anyhow::Result<Learner> {
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    warn_of_pairs_always_colliding(&scene);
    keep.warn_of_another(io::checkpoint_summary(&keep.path));
    Ok(Learner::new(scene, &options(args))?)
}

/// The run that was kept.
fn resumed(args: &LearnArgs, keep: &Keep) -> anyhow::Result<Learner> {
    let begun = io::checkpoint_summary(&keep.path)?.options;
    let target = |target: Option<f64>| target.map_or("no target".into(), |t| t.to_string());
    keep.expect_as_begun([
        ("labels", args.labels.map(|n| n.to_string()), begun.labels.to_string()),
        ("seconds", args.seconds.map(|t| t.to_string()), begun.seconds.map_or("no limit".into(), |t| t.to_string())),
        ("seed", args.seed.map(|s| s.to_string()), begun.seed.to_string()),
        ("memory", args.memory.map(|m| m.to_string()), (begun.memory >> 20).to_string()),
        ("target-excess", args.target_excess.map(|t| t.to_string()), target(begun.target_excess)),
        ("target-disagreement", args.target_disagreement.map(|t| t.to_string()), target(begun.target_disagreement)),
    ])?;
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    Ok(io::load_checkpoint(&keep.path, scene, args.threads)?)
}

/// How good a model is if this share of its answers is within 5 % of those of a longer search.
pub fn word_for(within_5pct: f64) -> &'static str {
    match within_5pct {
        share if share >= 0.98 => "Good",
        share if share >= 0.9 => "Fair",
        _ => "Learn longer",
    }
}

/// The first line after learning.
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

/// What a model's statistics say, for people.
pub fn statistics_rows(statistics: &Statistics, unit: &str) -> Vec<(&'static str, String)> {
    let ended = match statistics.ended_by {
        EndedBy::Labels => "",
        EndedBy::Seconds => " (ended by the time limit)",
        EndedBy::Interruption => " (interrupted)",
        EndedBy::Memory => " (ended by the limit on memory)",
        EndedBy::Quality => " (ended by the quality that was asked for)",
    };
    let adapted = statistics.adapted.map_or_else(String::new, |from| {
        let times = if from.times == 1 { "once".into() } else { format!("{} times", from.times) };
        format!("; adapted {times}, learned with {}", count(from.learned_labels))
    });
    vec![
        ("labels spent", format!("{} exact checks{ended}{adapted}", count(statistics.labels))),
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
        (
            "starts of a query",
            format!(
                "{:.1} stored and {:.1} around it for each degree of freedom",
                statistics.starts_per_dof.stored, statistics.starts_per_dof.around
            ),
        ),
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

/// The classifier's accuracy in words.
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
    // Who counts labels wants a model that another machine learns too; a silent time limit would
    // break that.
    let seconds = if args.labels.is_some() { args.seconds } else { args.seconds.or(default.seconds) };
    LearnOptions {
        labels: args.labels.unwrap_or(default.labels),
        seconds,
        seed: args.seed.unwrap_or(default.seed),
        threads: args.threads,
        memory: args.memory.map_or(default.memory, |mebibytes| mebibytes.saturating_mul(1 << 20)),
        target_excess: args.target_excess,
        target_disagreement: args.target_disagreement,
    }
}

fn warn_of_pairs_always_colliding(scene: &Scene) {
    let checker = prepare(scene.clone());
    let pairs = pairs_always_colliding(&checker, ALWAYS_COLLIDING_SAMPLES);
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
mod tests {
    use super::*;
    use clap::CommandFactory;
    use extricate::internals::model::evaluate::figures::Excess;

    fn args(labels: Option<usize>, seconds: Option<f64>) -> LearnArgs {
        LearnArgs {
            scene: "s".into(),
            output: "m".into(),
            labels,
            seconds,
            seed: None,
            threads: 0,
            memory: None,
            target_excess: None,
            target_disagreement: None,
            verbose: false,
            keep: KeepArgs::default(),
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
        assert!(help.contains(&format!("ends there [default: {}]", default.memory >> 20)), "{help}");
    }

    #[test]
    fn statistics_claim_no_more_than_was_found() {
        let mut statistics = Statistics {
            labels: 10,
            seed: 1,
            boundary_samples: 3,
            solved_samples: 1,
            stand_ins: 2,
            support_vectors: 0,
            colliding_share: 0.0,
            accuracy_free: None,
            accuracy_free_interval: None,
            accuracy_colliding: None,
            accuracy_colliding_interval: None,
            boundary_gap: None,
            density: None,
            excess: None,
            gap: None,
            starts_per_dof: extricate::StartsPerDof { stored: 2.0, around: 0.5 },
            measuring_checks: 0,
            ended_by: EndedBy::Labels,
            adapted: None,
        };
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

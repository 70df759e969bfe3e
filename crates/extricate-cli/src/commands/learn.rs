//! `extricate learn`: a scene in, a model file out.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use extricate::model::EndedBy;
use extricate::{LearnOptions, LearnProgress, Model, Scene, Statistics, store};
use serde::Serialize;

use super::{disable_line, load_scene, pairs_always_colliding, prepare, tell_warnings};
use crate::args::{positive, seconds, seed, threads};
use crate::interrupt::{self, StopOnInterrupt};
use crate::notice;
use crate::output::Output;
use crate::progress::Progress;
use crate::report::{self, count, duration, percent};

/// Configurations tried for pairs that always collide; few, because such a pair collides in the first one already.
const ALWAYS_COLLIDING_SAMPLES: u64 = 100;

/// Arguments of `learn`.
#[derive(Args)]
#[command(
    after_help = "Learning ends when the labels or the seconds are spent. Give --labels without --seconds for a model \
                        that does not depend on the speed of the machine: the same scene, seed and labels give the same \
                        model, whatever the number of threads. Ctrl-C ends learning early and keeps what was learned; a \
                        second one ends at once."
)]
pub struct LearnArgs {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Model file to write
    #[arg(short = 'o', long = "output", value_name = "MODEL")]
    output: PathBuf,
    /// Most exact collision checks to spend [default: 600000]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    labels: Option<usize>,
    /// Most seconds to spend [default: 90, or no limit with --labels]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Threads; 0 for one per core. The model does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_negative_numbers = true)]
    threads: usize,
}

#[derive(Serialize)]
struct Report<'a> {
    model: String,
    interrupted: bool,
    seconds: f64,
    statistics: &'a Statistics,
}

/// Runs the command.
pub fn run(args: &LearnArgs, json: bool) -> anyhow::Result<()> {
    store::check_model_output(&args.output)?;
    let scene = load_scene(&args.scene)?;
    tell_warnings(&scene);
    warn_of_pairs_always_colliding(&scene);
    let Learned { model, seconds, interrupted } = learn_with_progress(scene, &options(args))?;
    interrupt::uninterrupted(|| store::save_model(&model, &args.output))?;
    let statistics = model.statistics();
    let mut out = Output::new(false);
    if json {
        out.json(&Report { model: args.output.display().to_string(), interrupted, seconds, statistics })?;
    } else {
        out.line(report::two_columns(&statistics_rows(statistics, report::metric_unit(model.scene()))))?;
        out.line(format_args!("learned in {}", duration(seconds)))?;
        out.line(format_args!("wrote {}", args.output.display()))?;
    }
    out.finish()
}

/// A model, and what its file does not hold because it differs from run to run.
pub struct Learned {
    /// The model.
    pub model: Model,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Whether the user ended it early.
    pub interrupted: bool,
}

/// Learns with a progress bar; Ctrl-C ends early and keeps what was learned.
pub fn learn_with_progress(scene: Scene, options: &LearnOptions) -> anyhow::Result<Learned> {
    let started = Instant::now();
    let stop = StopOnInterrupt::new();
    let mut progress = Progress::new("learning");
    let model = Model::learn(scene, options, &mut |state| {
        progress.update(Some(state.fraction), || in_words(state));
        if stop.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    drop(progress);
    let (model, interrupted) = (model?, stop.asked());
    if interrupted {
        let labels = count(model.statistics().labels);
        notice::warning(format_args!("stopped by the user; keeping the model learned so far ({labels} labels)"));
    }
    Ok(Learned { model, seconds: started.elapsed().as_secs_f64(), interrupted })
}

/// What a model's statistics say, for people.
pub fn statistics_rows(statistics: &Statistics, unit: &str) -> Vec<(&'static str, String)> {
    let ended = match statistics.ended_by {
        EndedBy::Labels => "",
        EndedBy::Seconds => " (ended by the time limit)",
        EndedBy::Interruption => " (interrupted)",
    };
    vec![
        ("labels spent", format!("{} exact checks{ended}", count(statistics.labels))),
        ("seed", statistics.seed.to_string()),
        ("boundary samples", format!("{}, all verified free", count(statistics.boundary_samples))),
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
    ]
}

/// The classifier's accuracy in words.
pub fn held_out_accuracy(statistics: &Statistics) -> String {
    let share = |accuracy: Option<f64>| accuracy.map_or("-".into(), percent);
    match (statistics.accuracy_free, statistics.accuracy_colliding) {
        (None, None) => "nothing was held out".into(),
        (free, colliding) => format!("{} on free, {} on colliding configurations", share(free), share(colliding)),
    }
}

fn options(args: &LearnArgs) -> LearnOptions {
    let default = LearnOptions::default();
    // Who counts labels wants a model that another machine learns too; a silent time limit would break that.
    let seconds = if args.labels.is_some() { args.seconds } else { args.seconds.or(default.seconds) };
    LearnOptions { labels: args.labels.unwrap_or(default.labels), seconds, seed: args.seed, threads: args.threads }
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

fn in_words(state: &LearnProgress) -> String {
    let accuracy = state.accuracy.map_or(String::new(), |a| format!(", accuracy {}", percent(a)));
    let (labels, samples) = (count(state.labels), count(state.boundary_samples));
    format!("{}: {labels} labels, {samples} boundary samples{accuracy}", state.stage)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn args(labels: Option<usize>, seconds: Option<f64>) -> LearnArgs {
        LearnArgs { scene: "s".into(), output: "m".into(), labels, seconds, seed: 1, threads: 0 }
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
        let default = LearnOptions::default();
        assert!(help.contains(&format!("[default: {}]", default.labels)), "{help}");
        assert!(help.contains(&format!("[default: {}, or no limit", default.seconds.unwrap())), "{help}");
    }

    #[test]
    fn statistics_claim_no_more_than_was_found() {
        let mut statistics = Statistics {
            labels: 10,
            seed: 1,
            boundary_samples: 3,
            support_vectors: 0,
            colliding_share: 0.0,
            accuracy_free: None,
            accuracy_colliding: None,
            boundary_gap: None,
            ended_by: EndedBy::Labels,
        };
        let text = |statistics: &Statistics| report::two_columns(&statistics_rows(statistics, "rad"));
        assert!(text(&statistics).contains("no boundary found") && text(&statistics).contains("nothing was held out"));
        (statistics.boundary_gap, statistics.accuracy_free) = (Some(1e-3), Some(0.97));
        assert!(text(&statistics).contains("1.000e-3 rad at most") && text(&statistics).contains("97 % on free, - on"));
    }

    #[test]
    fn progress_reads_well() {
        let mut state =
            LearnProgress { stage: "exploring", fraction: 0.1, labels: 1500, boundary_samples: 30, accuracy: None };
        assert_eq!(in_words(&state), "exploring: 1,500 labels, 30 boundary samples");
        state.accuracy = Some(0.953);
        assert!(in_words(&state).ends_with("accuracy 95.3 %"));
    }
}

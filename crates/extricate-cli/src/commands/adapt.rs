//! `extricate adapt`: a model of a changed scene from the model of the old one.

use std::path::PathBuf;

use clap::Args;
use extricate::internals::io;
use extricate::internals::model::adapt::{Adapter, labels_to_adapt};
use extricate::{LearnOptions, Model, Statistics};
use serde::Serialize;

use super::learn::run::{Keep, KeepArgs, Learned, kept_at, memory_in_words, peak_memory, run_with_progress, save};
use super::learn::statistics_rows;
use super::{load_model, load_scene, tell_warnings};
use crate::args::{LoadArgs, positive, seconds, seed, threads};
use crate::output::Output;
use crate::report::{self, duration};

/// Arguments of `adapt`.
#[derive(Args)]
#[command(
    after_help = "Obstacles and pairs may differ from the model's scene; robots, limits and metric may not. Stored samples that \
                        no change comes near are kept; the others are checked again, and the boundary is traced where the scene \
                        changed; where MODEL has exits, colliding configurations are solved for more. MODEL is not altered. \
                        Ctrl-C ends early, keeps what was found and leaves a checkpoint, from which --resume goes on to the \
                        same model; a second one ends at once."
)]
pub struct AdaptArgs {
    /// Model file that `extricate learn` wrote
    model: PathBuf,
    /// The changed scene (TOML), or a model file of it
    #[arg(value_name = "NEW-SCENE")]
    scene: PathBuf,
    /// Model file to write
    #[arg(short = 'o', long = "output", value_name = "MODEL2")]
    output: PathBuf,
    /// Most exact collision checks to spend [default: a fifth of what the model took]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    labels: Option<usize>,
    /// Most seconds to spend [default: no limit]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "S", value_parser = seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Threads; 0 for one per core. The model does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_negative_numbers = true)]
    threads: usize,
    /// Most memory for what is found, beside MODEL itself, in MiB; the run ends there [default:
    /// 4096]
    #[arg(long, value_name = "MIB", value_parser = positive, allow_negative_numbers = true)]
    memory: Option<usize>,
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
pub fn run(args: &AdaptArgs, json: bool) -> anyhow::Result<()> {
    io::check_model_output(&args.output)?;
    let keep = args.keep.keep(&args.output, &[&args.model, &args.scene])?;
    let old = load_model(&args.model)?;
    let adapter = if args.keep.resume { resumed(args, &old, &keep)? } else { begun(args, &old, &keep)? };
    let learned = run_with_progress(adapter, Some(&keep))?;
    save(&learned, &args.output, &keep)?;
    let Learned { model, seconds, interrupted } = learned;
    let statistics = model.statistics();
    let mut out = Output::new(false);
    if json {
        let checkpoint = interrupted.then(|| keep.path.display().to_string());
        let (model, memory) = (args.output.display().to_string(), peak_memory());
        out.json(&Report { model, checkpoint, interrupted, seconds, memory, statistics })?;
    } else {
        out.line(report::two_columns(&statistics_rows(statistics, report::metric_unit(model.scene()))))?;
        out.line(format_args!("adapted in {}{}", duration(seconds), memory_in_words()))?;
        out.line(format_args!("wrote {}", args.output.display()))?;
        if interrupted {
            out.line(kept_at(&keep))?;
        }
    }
    out.finish()
}

/// A run from its beginning.
fn begun<'a>(args: &AdaptArgs, old: &'a Model, keep: &Keep) -> anyhow::Result<Adapter<'a>> {
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    keep.warn_of_another(io::adapt_checkpoint_summary(&keep.path));
    let default = LearnOptions::default();
    let options = LearnOptions {
        labels: args.labels.unwrap_or_else(|| labels_to_adapt(old)),
        seconds: args.seconds,
        seed: args.seed.unwrap_or(default.seed),
        threads: args.threads,
        memory: args.memory.map_or(default.memory, |mib| mib.saturating_mul(1 << 20)),
        ..default
    };
    Ok(Adapter::new(old, scene, &options)?)
}

/// The run that was kept.
fn resumed<'a>(args: &AdaptArgs, old: &'a Model, keep: &Keep) -> anyhow::Result<Adapter<'a>> {
    let begun = io::adapt_checkpoint_summary(&keep.path)?.options;
    keep.expect_as_begun([
        ("labels", args.labels.map(|n| n.to_string()), begun.labels.to_string()),
        ("seconds", args.seconds.map(|t| t.to_string()), begun.seconds.map_or("no limit".into(), |t| t.to_string())),
        ("seed", args.seed.map(|s| s.to_string()), begun.seed.to_string()),
        ("memory", args.memory.map(|m| m.to_string()), (begun.memory >> 20).to_string()),
    ])?;
    let scene = load_scene(&args.scene, &args.load)?;
    tell_warnings(&scene);
    Ok(io::load_adapt_checkpoint(&keep.path, old, scene, args.threads)?)
}

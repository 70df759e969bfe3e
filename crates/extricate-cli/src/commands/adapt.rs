//! `extricate adapt`: a model of a changed scene from the model of the old one.

use std::path::PathBuf;

use clap::Args;
use extricate::model::adapt::labels_to_adapt;
use extricate::{LearnOptions, Statistics, store};
use serde::Serialize;

use super::learn::statistics_rows;
use super::learn_run::{Learned, adapt_with_progress};
use super::{load_model, load_scene, tell_warnings};
use crate::args::{positive, seconds, seed, threads};
use crate::interrupt;
use crate::output::Output;
use crate::report::{self, duration};

/// Arguments of `adapt`.
#[derive(Args)]
#[command(
    after_help = "Obstacles and pairs may differ from the model's scene; robots, limits and metric may not. Stored samples that \
                        no change comes near are kept; the others are checked again, and the boundary is traced where the scene \
                        changed; where MODEL has exits, colliding configurations are solved for more. MODEL is not altered."
)]
pub struct AdaptArgs {
    /// Model file that `extricate learn` wrote
    model: PathBuf,
    /// The changed scene (TOML)
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
pub fn run(args: &AdaptArgs, json: bool) -> anyhow::Result<()> {
    store::check_model_output(&args.output)?;
    let old = load_model(&args.model)?;
    let scene = load_scene(&args.scene)?;
    tell_warnings(&scene);
    let options = LearnOptions {
        labels: args.labels.unwrap_or_else(|| labels_to_adapt(&old)),
        seconds: args.seconds,
        seed: args.seed,
        threads: args.threads,
        ..LearnOptions::default()
    };
    let Learned { model, seconds, interrupted } = adapt_with_progress(&old, scene, &options)?;
    interrupt::uninterrupted(|| store::save_model(&model, &args.output))?;
    let statistics = model.statistics();
    let mut out = Output::new(false);
    if json {
        out.json(&Report { model: args.output.display().to_string(), interrupted, seconds, statistics })?;
    } else {
        out.line(report::two_columns(&statistics_rows(statistics, report::metric_unit(model.scene()))))?;
        out.line(format_args!("adapted in {}", duration(seconds)))?;
        out.line(format_args!("wrote {}", args.output.display()))?;
    }
    out.finish()
}

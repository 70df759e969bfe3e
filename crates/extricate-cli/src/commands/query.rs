//! `extricate query`: the nearest free configuration for each of many.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use extricate::{Effort, QueryOptions, QueryScratch};

use super::load_model;
use super::query_row::{QueryRow, Summary, header};
use crate::args::InputArgs;
use crate::input::Configs;
use crate::output::Output;
use crate::progress::Progress;
use crate::report;

/// Arguments of `query`.
#[derive(Args)]
#[command(
    after_help = "With --json, one object a line, in the order of the input: depth and lower_bound (in the scene's \
                        metric), witness, seconds (the library call alone), checks, max_displacement [m], colliding and \
                        touching (lists of [name, name]), verified, effort."
)]
pub struct QueryArgs {
    /// Model file that `extricate learn` wrote
    model: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    /// How hard to try
    #[arg(long, value_enum, default_value_t = EffortArg::Refined)]
    effort: EffortArg,
}

/// [`Effort`] as the command line spells it.
#[derive(Clone, Copy, ValueEnum)]
enum EffortArg {
    /// The nearest stored boundary sample, verified when learned
    Nearest,
    /// Several candidates, each slid along the contact surface; verified now
    Refined,
    /// Many starts and long refinement, for ground truth
    Exhaustive,
}

impl From<EffortArg> for Effort {
    fn from(effort: EffortArg) -> Self {
        match effort {
            EffortArg::Nearest => Effort::Nearest,
            EffortArg::Refined => Effort::Refined,
            EffortArg::Exhaustive => Effort::Exhaustive,
        }
    }
}

/// Runs the command.
pub fn run(args: &QueryArgs, json: bool) -> anyhow::Result<()> {
    let mut configs = Configs::open(&args.input.input)?;
    let model = load_model(&args.model)?;
    let scene = model.scene();
    let unit = report::metric_unit(scene);
    let options = QueryOptions { effort: args.effort.into() };
    let mut scratch = QueryScratch::default();
    let mut out = Output::new(configs.is_stream());
    let mut progress = Progress::beside_rows("querying");
    let mut summary = Summary::default();
    if !json {
        out.line(header(unit))?;
    }
    while let Some(entry) = configs.next(&scene.space)? {
        match entry {
            Ok((line, q)) => {
                let started = Instant::now();
                let answer = model.query(&q, &options, &mut scratch);
                let seconds = started.elapsed().as_secs_f64();
                let row = QueryRow::new(&answer, seconds, scene);
                if json {
                    out.json(&row)?
                } else {
                    out.line(row.text(line))?
                }
                summary.add(&answer, seconds);
            }
            Err(bad) => {
                progress.aside(|| configs.report(&bad));
                if json {
                    out.json(&bad)?;
                }
            }
        }
        progress.update(configs.fraction(), || format!("{} answers", report::count(summary.queries())));
    }
    if !json && summary.queries() > 0 {
        out.line("")?;
        out.line(report::two_columns(&summary.figures().rows(unit)))?;
    }
    out.finish()?;
    drop(progress);
    configs.conclude()
}

//! `extricate report`: measures a model anew and draws the results, so that users can judge it
//! before they trust it.
//!
//! `measure` queries the model, `plots` draws figures, and `page` joins them.

mod measure;
mod page;
mod plots;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use extricate::files;
use extricate_view::is_page;

use crate::args::{positive, seed};
use crate::commands::load_model;
use crate::output::Output;
use crate::pages::name_of;
use crate::report::percent;

/// Arguments of `report`.
#[derive(Args)]
pub struct ReportArgs {
    /// Model file
    model: PathBuf,
    /// Page to write; an existing one is replaced
    #[arg(short, long, value_name = "FILE.html", default_value = "extricate-report.html")]
    output: PathBuf,
    /// Number of random colliding configurations to query, each with several budgets
    #[arg(short = 'n', long = "count", value_name = "N", default_value_t = 200, value_parser = positive, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the random configurations
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
}

pub fn run(args: &ReportArgs, json: bool) -> anyhow::Result<()> {
    files::check_not_read(&args.output, [args.model.as_path()])?;
    files::check_output(&args.output, "page of this program", is_page)?;
    let model = Arc::new(load_model(&args.model)?);
    let measured = measure::measure(&model, args.count, args.seed)?;
    let html = page::html(&model, &name_of(&args.model), &measured);
    files::write_atomically(&args.output, html.as_bytes())?;
    let (mut out, page) = (Output::new(false), args.output.display().to_string());
    if json {
        out.json(&serde_json::json!({ "page": page, "measured": measured }))?;
    } else {
        let share = percent(measured.refined.within_5pct);
        out.line(format_args!(
            "{share} of {} random collisions within 5 % of the best found; wrote {page}, any browser shows it",
            measured.queries
        ))?;
    }
    out.finish()
}

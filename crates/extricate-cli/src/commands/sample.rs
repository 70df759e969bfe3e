//! `extricate sample`: draws uniformly random configurations, all or only colliding ones.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use extricate::{Label, Sampler, Solver};
use serde::Serialize;

use super::{load_scene, tell_warnings};
use crate::args::{LoadArgs, seed, whole};
use crate::output::Output;
use crate::progress::{Progress, busy};
use crate::report::count;

/// Arguments of `sample`.
#[derive(Args)]
#[command(
    after_help = "Prints one {\"q\": [...]} per line, with and without --json. The same scene, seed and version give the \
                        same lines; a larger N only adds lines."
)]
pub struct SampleArgs {
    /// Scene file (TOML), URDF or model file
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    /// Number of configurations to draw
    #[arg(short = 'n', long = "count", value_name = "N", default_value_t = 100, value_parser = whole, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Draw only colliding configurations
    #[arg(long)]
    colliding: bool,
    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Serialize)]
struct Line<'a> {
    q: &'a [f64],
}

pub fn run(args: &SampleArgs) -> anyhow::Result<()> {
    let solver = Solver::new(load_scene(&args.scene, &args.load)?);
    tell_warnings(solver.scene());
    if args.colliding {
        busy("preparing the collision checker", || solver.prepare());
    }
    let mut sampler = Sampler::new(&solver, args.colliding.then_some(Label::Colliding), args.seed);
    let mut out = Output::new(false);
    let mut progress = Progress::beside_rows("sampling");
    for index in 0..args.count {
        let drawn = sampler.draw(1, &mut |tried, found| {
            progress.update(Some(index as f64 / args.count as f64), || match args.colliding {
                true => format!("{} colliding of {} tried", count(found), count(tried)),
                false => format!("{} configurations", count(index)),
            });
            ControlFlow::Continue(())
        })?;
        out.json(&Line { q: &drawn[0] })?;
    }
    out.finish()
}

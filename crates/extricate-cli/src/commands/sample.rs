//! `extricate sample`: uniformly random configurations, all or only colliding ones.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;
use extricate::internals::cspace::sampling::uniform;
use extricate::{CheckScratch, Checker, Label};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

use super::{load_scene, prepare, tell_warnings};
use crate::args::{LoadArgs, seed, whole};
use crate::output::Output;
use crate::progress::Progress;
use crate::report;

/// Tries in a row without a colliding configuration after which there is taken to be none worth
/// drawing.
const MOST_TRIES: usize = 1_000_000;

/// Arguments of `sample`.
#[derive(Args)]
#[command(
    after_help = "Prints one {\"q\": [...]} a line, with and without --json. The same scene, seed and version give the \
                        same lines, and a larger N only adds to them."
)]
pub struct SampleArgs {
    /// Scene file (TOML), URDF or model file
    #[arg(value_name = "SCENE|MODEL")]
    scene: PathBuf,
    /// How many to draw
    #[arg(short = 'n', long = "count", value_name = "N", default_value_t = 100, value_parser = whole, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Only colliding configurations
    #[arg(long)]
    colliding: bool,
    #[command(flatten)]
    load: LoadArgs,
}

/// Draws colliding configurations, uniformly, by rejection.
pub struct CollidingSampler<'a> {
    checker: &'a Checker,
    scratch: CheckScratch,
    rng: ChaCha8Rng,
    tries: usize,
    found: usize,
}

#[derive(Serialize)]
struct Line<'a> {
    q: &'a [f64],
}

impl<'a> CollidingSampler<'a> {
    /// The sequence of `seed`.
    pub fn new(checker: &'a Checker, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { checker, scratch: CheckScratch::default(), rng, tries: 0, found: 0 }
    }

    /// Draws the next one into `q` (length `nq`); `on_try` hears how many tries were made so far,
    /// and how many succeeded.
    ///
    /// # Errors
    /// Where a million tries in a row found nothing.
    pub fn next(&mut self, q: &mut [f64], mut on_try: impl FnMut(usize, usize)) -> anyhow::Result<()> {
        for _ in 0..MOST_TRIES {
            uniform(&self.checker.scene().space, &mut self.rng, q);
            self.tries += 1;
            on_try(self.tries, self.found);
            if self.checker.label(q, &mut self.scratch) == Label::Colliding {
                self.found += 1;
                return Ok(());
            }
        }
        let found = self.found;
        bail!(
            "no colliding configuration among {MOST_TRIES} uniform ones ({found} found before): the scene is nearly free"
        );
    }
}

/// Runs the command.
pub fn run(args: &SampleArgs) -> anyhow::Result<()> {
    let scene = Arc::new(load_scene(&args.scene, &args.load)?);
    tell_warnings(&scene);
    let mut out = Output::new(false);
    let mut q = vec![0.0; scene.space.nq()];
    let mut progress = Progress::beside_rows("sampling");
    let share = |index: usize| Some(index as f64 / args.count as f64);
    if args.colliding {
        let checker = prepare(scene);
        let mut sampler = CollidingSampler::new(&checker, args.seed);
        for index in 0..args.count {
            sampler.next(&mut q, |tries, found| {
                progress.update(share(index), || {
                    format!("{} colliding of {} tried", report::count(found), report::count(tries))
                });
            })?;
            out.json(&Line { q: &q })?;
        }
    } else {
        let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
        for index in 0..args.count {
            uniform(&scene.space, &mut rng, &mut q);
            progress.update(share(index), || format!("{} configurations", report::count(index)));
            out.json(&Line { q: &q })?;
        }
    }
    out.finish()?;
    Ok(())
}

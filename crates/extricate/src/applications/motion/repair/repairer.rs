//! What a path is repaired with, and what all steps ask of it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::old_path::{OldPath, Point};
use super::options::RepairOptions;
use crate::applications::motion::prover::Prover;
use crate::cspace::Config;
use crate::query::{Context, Deadline, QueryOptions, QueryScratch, Stream, StreamOptions, Termination};

/// Share by which another exit has to be nearer for the stream to leave the last one: a path that
/// jumps from exit to exit has gaps.
const HYSTERESIS: f64 = 0.5;

/// What a path is repaired with.
pub struct Repairer<'a> {
    pub context: &'a Context<'a>,
    pub options: &'a RepairOptions,
    pub old: OldPath<'a>,
    pub prover: Prover<'a>,
    pub stream: Stream,
    pub query: QueryScratch,
    pub rng: ChaCha8Rng,
    /// Stretches that pushing did not close.
    pub gaps: usize,
}

impl<'a> Repairer<'a> {
    /// Nothing is done yet.
    pub fn new(context: &'a Context<'a>, points: &'a [Config], options: &'a RepairOptions) -> Self {
        let limit = Deadline::of(&options.termination);
        let query = QueryOptions { clearance: Some(options.aim_over(context)), ..QueryOptions::default() };
        let stream = StreamOptions { query, hysteresis: HYSTERESIS, ..StreamOptions::default() };
        Self {
            context,
            options,
            old: OldPath::new(context.metric, points),
            prover: Prover::new(context.checker, options.resolution, limit),
            stream: Stream::new(stream),
            query: QueryScratch::default(),
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            gaps: 0,
        }
    }

    /// How far a new point is from the old one that it stands for, in metric units.
    pub fn deviation(&self, (place, q): &Point) -> f64 {
        self.context.metric.distance(&self.old.at(*place), q)
    }

    /// What queries may still spend.
    pub fn left(&self) -> Termination {
        self.prover.left()
    }
}

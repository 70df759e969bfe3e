//! State of a repair, and measures that all its steps use.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::old_path::{OldPath, Point};
use super::options::RepairOptions;
use crate::applications::motion::prover::Prover;
use crate::applications::stream::{Follower, StreamOptions};
use crate::cspace::Config;
use crate::query::{Context, Deadline, QueryOptions, QueryScratch, Termination};

/// Share by which another exit has to be nearer for the stream to leave the last one: a path that
/// jumps from exit to exit has gaps.
const HYSTERESIS: f64 = 0.5;

pub struct Repairer<'a> {
    pub context: &'a Context<'a>,
    pub options: &'a RepairOptions,
    pub old: OldPath<'a>,
    pub prover: Prover<'a>,
    pub stream: Follower,
    pub query: QueryScratch,
    pub rng: ChaCha8Rng,
    /// Number of edges between pushed points that were not proved.
    pub gaps: usize,
    /// Number of pairs that touch, summed over the rows.
    pub touched: usize,
    /// Number of these that touch in the result.
    pub kept: usize,
}

impl<'a> Repairer<'a> {
    pub fn new(context: &'a Context<'a>, points: &'a [Config], options: &'a RepairOptions) -> Self {
        let limit = Deadline::of(&options.termination);
        let query = QueryOptions { clearance: Some(options.aim_over(context)), ..QueryOptions::default() };
        let stream = StreamOptions { hysteresis: HYSTERESIS, ..StreamOptions::default() };
        Self {
            context,
            options,
            old: OldPath::new(context.metric, points),
            prover: Prover::new(context.checker, options.resolution, limit).holding(context.kept),
            stream: Follower::new(stream, query),
            query: QueryScratch::default(),
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            gaps: 0,
            touched: 0,
            kept: 0,
        }
    }

    /// Returns the free configuration to which the stream leads from `q`.
    pub fn next_beside(&mut self, q: &Config) -> Option<Vec<f64>> {
        self.stream.limit(self.left());
        let answer = self.stream.query(self.context, q);
        self.prover.checks += self.stream.checks();
        answer.map(|answer| answer.witness.into())
    }

    /// Returns the distance of a new point from the old one that it stands for, in metric units.
    pub fn deviation(&self, (place, q): &Point) -> f64 {
        self.context.metric.distance(&self.old.at(*place), q)
    }

    /// Returns the largest distance of a path from the old one, at its points and at the rows that
    /// its edges stand for. If the metric is a norm, it is nowhere larger: both are straight in
    /// between.
    pub fn farthest(&self, points: &[Point]) -> f64 {
        let at_points = points.iter().map(|point| self.deviation(point)).fold(0.0, f64::max);
        let edges = points.iter().zip(points.iter().skip(1));
        edges.map(|(before, after)| self.farthest_on(before, after, &[])).fold(at_points, f64::max)
    }

    /// Returns the largest distance of an edge from the old path, at the rows that it stands for
    /// and at other places.
    pub fn farthest_on(&self, before: &Point, after: &Point, places: &[f64]) -> f64 {
        let rows = self.old.rows_between(before.0, after.0).map(|row| row as f64);
        let at = |place: f64| self.deviation(&self.between(before, after, place));
        rows.chain(places.iter().copied()).map(at).fold(0.0, f64::max)
    }

    /// Returns the point of an edge that stands for a place.
    pub fn between(&self, before: &Point, after: &Point, place: f64) -> Point {
        let share = (place - before.0) / (after.0 - before.0).max(1e-12);
        let mut q = before.1.clone();
        self.context.checker.scene().space.interpolate(&before.1, &after.1, share, &mut q);
        (place, q)
    }

    /// Returns the rest of the budget, for queries.
    pub fn left(&self) -> Termination {
        self.prover.left()
    }
}

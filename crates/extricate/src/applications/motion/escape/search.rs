//! State of the search for an escape, and calls that all its steps use.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::options::{AIM_MARGIN_M, EscapeOptions};
use super::relaxed::Relaxed;
use crate::applications::motion::prover::Prover;
use crate::applications::motion::shortcut::shortcut;
use crate::cspace::{Config, Label};
use crate::metric::Anchor;
use crate::query::constraints::push_nearby;
use crate::query::{Answer, Context, Deadline, QueryOptions, QueryScratch, Termination, Toward, query};

/// Exits count as about as near as the nearest one if they are farther by at most this share.
const TOWARD_SHARE: f64 = 0.25;

pub struct Search<'a> {
    pub context: &'a Context<'a>,
    pub q: &'a Config,
    pub options: &'a EscapeOptions,
    pub relaxed: &'a Relaxed,
    /// Proves edges in the set of `relaxed`.
    pub prover: Prover<'a>,
    pub query: QueryScratch,
    /// Whether a query found any exit.
    pub has_exit: bool,
}

impl Search<'_> {
    /// Returns exits, nearest first, that keep `clearance` \[m\], or as much of it as is kept
    /// nearby.
    pub fn query(&mut self, count: usize, clearance: f64) -> Option<Answer> {
        let options = QueryOptions {
            exits: count,
            clearance: Some(clearance),
            toward: self.options.toward.clone().map(|goal| Toward::new(goal, TOWARD_SHARE)),
            termination: self.left(),
            ..QueryOptions::default()
        };
        let answer = query(self.context, self.q, &options, &mut self.query);
        self.prover.checks += self.query.checks();
        self.has_exit |= answer.is_some();
        answer
    }

    /// If the end of the path does not keep the aimed clearance, appends a configuration nearby
    /// that keeps as much of it as is found, provided that the edge there is proved.
    pub fn raised(&mut self, mut path: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let (context, aim) = (self.context, self.aim());
        let Some(exit) = path.last().cloned() else { return path };
        self.prover.checks += 1;
        if context.checker.with_clearance(aim).label(&exit, self.prover.scratch()) == Label::Free {
            return path;
        }
        let mut anchor = Anchor::default();
        context.metric.anchor(self.q, &mut anchor);
        self.query.evaluator.begin(Deadline::of(&self.left()));
        let pushed = push_nearby(context, &anchor, &exit, (aim, false), &mut self.query);
        self.prover.checks += self.query.checks();
        let end = pushed.map(|(_, end)| end).filter(|end| *end != exit);
        if let Some(way) = end.and_then(|end| self.prover.join(&exit, &end)) {
            let bend = path.len() - 1;
            path.extend(way);
            if self.prover.proves(&path[bend - 1], &path[bend + 1]) {
                path.remove(bend);
            }
        }
        path
    }

    /// Returns the edge to the first exit to which it is proved, or that bends to keep links.
    pub fn straight(&mut self, exits: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let mut way = vec![self.q.to_vec()];
        let prover = &mut self.prover;
        let join = |exit: &Vec<f64>| if prover.is_spent() { None } else { prover.join(self.q, exit) };
        way.extend(exits.iter().find_map(join)?);
        Some(way)
    }

    pub fn shorter(&mut self, mut points: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
        shortcut(&mut self.prover, self.context.metric, &mut points, &mut rng);
        points
    }

    /// Returns the clearance that the end of the path is to keep \[m\].
    pub fn aim(&self) -> f64 {
        self.options.aim.unwrap_or(self.context.clearance + AIM_MARGIN_M).max(self.context.clearance)
    }

    /// Returns the rest of the budget, for queries.
    pub fn left(&self) -> Termination {
        self.prover.left()
    }
}

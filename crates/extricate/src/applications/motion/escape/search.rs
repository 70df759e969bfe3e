//! What an escape is looked for with, and what all steps ask of it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::options::{AIM, EscapeOptions};
use super::relaxed::Relaxed;
use crate::applications::motion::prover::Prover;
use crate::applications::motion::shortcut::shortcut;
use crate::cspace::Config;
use crate::query::{Answer, Context, QueryOptions, QueryScratch, Termination, query};

/// What an escape is looked for with.
pub struct Search<'a> {
    pub context: &'a Context<'a>,
    pub q: &'a Config,
    pub options: &'a EscapeOptions,
    pub relaxed: &'a Relaxed,
    /// In the set of `relaxed`.
    pub prover: Prover<'a>,
    pub query: QueryScratch,
}

impl Search<'_> {
    /// Exits, nearest first, that keep the clearance that is aimed at, or the scene's.
    pub fn query(&mut self, count: usize) -> Option<Answer> {
        let options = QueryOptions {
            exits: count,
            clearance: Some(self.aim()),
            termination: self.left(),
            ..QueryOptions::default()
        };
        let answer = query(self.context, self.q, &options, &mut self.query)?;
        self.prover.checks += answer.checks;
        Some(answer)
    }

    /// The first of some configurations that a proved edge leads to.
    pub fn straight(&mut self, exits: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let found = exits.iter().find(|exit| !self.prover.is_spent() && self.prover.proves(self.q, exit))?;
        Some(vec![self.q.to_vec(), found.clone()])
    }

    /// The path with fewer points.
    pub fn shorter(&mut self, mut points: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
        shortcut(&mut self.prover, &mut points, &mut rng);
        points
    }

    /// Clearance \[m\] that the end of the path is to keep.
    pub fn aim(&self) -> f64 {
        self.options.aim.unwrap_or(self.context.clearance + AIM).max(self.context.clearance)
    }

    /// What queries may still spend.
    pub fn left(&self) -> Termination {
        self.prover.left()
    }
}

//! Plan: a proved path between two free configurations, also through narrow passages.
//!
//! It tries the straight edge, then RRT-Connect, which solves most open scenes in some hundred
//! checks. While that fails, a roadmap grows beside it ([`super::roadmap`]), with four checks for
//! each check of the trees. Every round has twice the checks of the last.

mod options;

pub use options::{Plan, PlanMethod, PlanOptions};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::path;
use super::prover::Prover;
use super::roadmap::{Grower, Roadmap, RoadmapContext, grow};
use super::rrt_connect::RrtConnect;
use super::shortcut::shortcut;
use crate::cspace::Config;
use crate::cspace::sampling::uniform;
use crate::error::{Error, Result};
use crate::query::{Context, Deadline};
use crate::solver::Solver;

/// Checks of the trees in the first round: open scenes need a hundredth, pegs in tight holes all.
const FIRST_ROUND_CHECKS: usize = 30_000;
/// Checks of the roadmap for each check of the trees: what trees find at all, they find early.
const ROADMAP_CHECKS_PER_TREE_CHECK: usize = 4;
/// Maximum checks of one batch of the roadmap: only the next batch knows what it found.
const MAX_BATCH_CHECKS: usize = 20_000;
/// Longest edge of a tree, as a share of the metric's diameter. A half takes twice the checks in
/// open scenes (`bench/applications open`).
const MAX_EDGE_SHARE: f64 = 0.2;

impl Solver {
    /// Returns a path between two free configurations, with every edge proved free.
    ///
    /// # Guarantee
    /// Every configuration of the path is proved free. If none is found, [`Plan::points`] is empty,
    /// which proves nothing. The same solver, ends and options give the same path whatever the
    /// number of threads, unless a limit in seconds ends it.
    ///
    /// # Errors
    /// [`Error::Config`] if an end is not free, named `from` or `to`; [`Error::Option`] for an
    /// option that makes no sense.
    pub fn plan(&self, from: &Config, to: &Config, options: &PlanOptions) -> Result<Plan> {
        let mut roadmap = Roadmap::new(&self.scene().space, options.seed);
        self.plan_in(&mut roadmap, false, [from, to], options)
    }

    /// As [`Solver::plan`], with a roadmap of earlier calls, which it extends: queries of one scene
    /// that share it become cheaper. A roadmap made for another scene with the same coordinates
    /// helps if the two are alike; the guarantee is the same.
    ///
    /// # Errors
    /// As [`Solver::plan`]; [`Error::Input`] if the roadmap has other coordinates.
    pub fn plan_with(&self, from: &Config, to: &Config, options: &PlanOptions, roadmap: &mut Roadmap) -> Result<Plan> {
        self.plan_in(roadmap, true, [from, to], options)
    }

    fn plan_in(&self, roadmap: &mut Roadmap, keeps: bool, ends: [&Config; 2], options: &PlanOptions) -> Result<Plan> {
        options.check()?;
        let scene = self.scene();
        roadmap.check(&scene.space).map_err(|problem| Error::input("roadmap", "contents", problem))?;
        let limit = Deadline::of(&options.termination);
        let mut prover = Prover::new(self.checker(), options.resolution, limit.clone());
        for (name, end) in ["from", "to"].into_iter().zip(ends) {
            if !prover.holds(end) {
                return Err(not_free(&self.context(), name, end));
            }
        }
        let pool = options.pool()?;
        let planner = Planner { context: &self.context(), ends, keeps, options, prover, limit };
        Ok(pool.install(|| planner.plan(roadmap)))
    }
}

impl Solver {
    /// Extends a roadmap, for plans to come, by spending about `checks` checks.
    ///
    /// # Errors
    /// [`Error::Option`] and [`Error::Input`] as [`Solver::plan_with`].
    pub fn grow_roadmap(&self, roadmap: &mut Roadmap, checks: usize, options: &PlanOptions) -> Result<()> {
        options.check()?;
        roadmap.check(&self.scene().space).map_err(|problem| Error::input("roadmap", "contents", problem))?;
        let limit = Deadline::of(&options.termination);
        options.pool()?.install(|| {
            let context = RoadmapContext::new(&self.context(), options.resolution);
            let mut grower = Grower::new(context, roadmap, &limit, checks);
            while !grower.is_spent() {
                let left = grower.left;
                grow(&mut grower, left.min(MAX_BATCH_CHECKS));
            }
        });
        Ok(())
    }
}

fn not_free(context: &Context, name: &str, end: &Config) -> Error {
    let scene = context.checker.scene();
    if let Some(at) = scene.space.outside(end).next() {
        let expected = "a value within its limits".into();
        return Error::Config { element: format!("{name}: coordinate {at}"), value: end[at].to_string(), expected };
    }
    let pair = context.checker.colliding_pair(end, &mut Default::default());
    let value = pair.map_or("a collision".into(), |pair| {
        let [a, b] = scene.pair_names(pair);
        format!("a collision of {a} and {b}")
    });
    Error::Config { element: name.into(), value, expected: "a free configuration; `escape` leads to one".into() }
}

struct Planner<'a> {
    context: &'a Context<'a>,
    ends: [&'a Config; 2],
    /// Whether the roadmap serves later plans too.
    keeps: bool,
    options: &'a PlanOptions,
    prover: Prover<'a>,
    limit: Deadline,
}

impl Planner<'_> {
    fn plan(mut self, roadmap: &mut Roadmap) -> Plan {
        let before = roadmap.checks();
        let found = self.find(roadmap);
        let (grown, nodes) = (roadmap.checks() - before, roadmap.len());
        let Some((mut points, method)) = found else { return Plan::none(self.prover.checks + grown, nodes) };
        if self.options.shortcut {
            let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
            self.prover.limited(self.left(grown));
            shortcut(&mut self.prover, &mut points, &mut rng);
        }
        let length = path::length(self.context.metric, &points.concat(), self.ends[0].len());
        Plan { points, method: Some(method), length, checks: self.prover.checks + grown, nodes }
    }

    fn find(&mut self, roadmap: &mut Roadmap) -> Option<(Vec<Vec<f64>>, PlanMethod)> {
        let [from, to] = self.ends.map(|end| end.to_vec());
        if self.prover.proves(&from, &to) {
            return Some((vec![from, to], PlanMethod::Straight));
        }
        let context = RoadmapContext::new(self.context, self.options.resolution);
        let mut grower = Grower::new(context, roadmap, &self.limit, self.left(0));
        let (before, mut nodes) = (grower.roadmap.checks(), None);
        if !grower.roadmap.is_empty() {
            let [a, b] = [grower.add(&from), grower.add(&to)];
            nodes = Some([a, b]);
            if let Some(path) = grower.solve(a, b) {
                return Some((path, PlanMethod::Roadmap));
            }
        }
        let (metric, space) = (self.context.metric, &self.context.checker.scene().space);
        let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
        let mut trees = RrtConnect::new(
            metric,
            [std::slice::from_ref(&from), std::slice::from_ref(&to)],
            MAX_EDGE_SHARE * metric.diameter(),
        )
        .sliding();
        let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| uniform(space, rng, out);
        let mut round = FIRST_ROUND_CHECKS;
        loop {
            let limited = self.prover.limited(self.left(grower.roadmap.checks() - before).min(round));
            let path = trees.grow(&mut self.prover, &mut sample, &mut rng);
            self.prover.unlimit(limited);
            if let Some(path) = path {
                if self.keeps {
                    grower.keep(&path);
                }
                return Some((path, PlanMethod::Trees));
            }
            grower.left = self.left(grower.roadmap.checks() - before);
            let [a, b] = *nodes.get_or_insert_with(|| [grower.add(&from), grower.add(&to)]);
            let begun = grower.roadmap.checks();
            while grower.roadmap.checks() - begun < ROADMAP_CHECKS_PER_TREE_CHECK * round {
                if grower.is_spent() {
                    return None;
                }
                let left = grower.left;
                grow(&mut grower, left.min(round).min(MAX_BATCH_CHECKS));
                if let Some(path) = grower.solve(a, b) {
                    return Some((path, PlanMethod::Roadmap));
                }
            }
            round *= 2;
        }
    }

    /// Returns the checks that may still be spent if growing the roadmap took `grown`.
    fn left(&self, grown: usize) -> usize {
        self.limit.checks.map_or(usize::MAX, |most| most.saturating_sub(self.prover.checks + grown))
    }
}

#[cfg(test)]
mod tests;

//! Plan: a proved path between two free configurations, also through narrow passages.
//!
//! 1. *Escape*: lead colliding ends out of collision ([`super::escape`]).
//! 2. *Straight*: try the edge between the free ends.
//! 3. *Trees*: grow RRT-Connect by straight edges, which solves most open scenes in some hundred
//!    checks, then by slides along contacts, which find into tight holes.
//! 4. *Roadmap*: grow a roadmap ([`super::roadmap`]). Repeat steps 3 and 4 with twice the checks.
//! 5. *Shorten* the free path, then the escapes together with it.
//!
//! If links are kept, only the straight trees grow, by edges that keep them (`Prover::advance`).

mod options;

pub use options::{Plan, PlanMethod, PlanOptions};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::escape::{Escape, EscapeOptions, escape, shortened_onward};
use super::path;
use super::prover::Prover;
use super::push_off::push_off;
use super::roadmap::{Grower, Roadmap, RoadmapContext, grow};
use super::rrt_connect::{MAX_EDGE_SHARE, RrtConnect};
use super::shortcut::shortcut;
use crate::cspace::Config;
use crate::cspace::sampling::uniform;
use crate::error::{Error, Result};
use crate::query::keep::LinkConstraint;
use crate::query::{Context, Deadline};
use crate::solver::Solver;

/// Checks of the straight trees in the first round: enough for nearly all open scenes.
const FIRST_ROUND_CHECKS: usize = 3_000;
/// Checks of the sliding trees for each check of the straight ones: pegs in tight holes need them
/// all, in one go.
const SLIDING_CHECKS_FACTOR: usize = 10;
/// Checks of the roadmap for each check of the straight trees: what trees find at all, they find
/// early.
const ROADMAP_CHECKS_FACTOR: usize = 40;
/// Maximum checks of one batch of the roadmap: only the next batch knows what it found.
const MAX_BATCH_CHECKS: usize = 20_000;

impl Solver {
    /// Returns a path between two configurations, with every edge proved. An end that collides is
    /// led out of collision first, as [`Solver::escape`] does, toward the other end.
    ///
    /// # Guarantee
    /// Every configuration of the path from [`Plan::free_from`] to [`Plan::free_to`] is proved
    /// free. The parts before and after are escapes: no pair gets deeper than it is at the end of
    /// the path, by more than the tolerance. Links of [`PlanOptions::keep`] keep their places all
    /// along the path. If no path is found, [`Plan::points`] is empty, which proves nothing. The
    /// same solver, ends and options give the same path whatever the number of threads, unless a
    /// limit in seconds ends it.
    ///
    /// # Errors
    /// [`Error::Config`] if an end lies beyond a limit, or a link that is to be kept is off there;
    /// the message names the end. [`Error::Option`] for an option that makes no sense.
    pub fn plan(&self, from: &Config, to: &Config, options: &PlanOptions) -> Result<Plan> {
        let mut roadmap = Roadmap::new(&self.scene().space, options.seed);
        self.plan_in(&mut roadmap, false, [from, to], options)
    }

    /// As [`Solver::plan`], with a roadmap of earlier calls, which it extends: queries of one scene
    /// that share it become cheaper. A roadmap made for another scene with the same coordinates
    /// helps if the two are alike; the guarantee is the same. Plans that keep links neither use it
    /// nor extend it.
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
        let kept = LinkConstraint::kept_at(scene, &options.keep, &[("start", ends[0]), ("goal", ends[1])])?;
        let prover = Prover::new(self.checker(), options.resolution, limit.clone()).holding(&kept);
        for (name, end) in ["from", "to"].into_iter().zip(ends) {
            if let Some(at) = scene.space.outside(end).next() {
                return Err(Error::Config {
                    element: format!("{name}: coordinate {at}"),
                    value: end[at].to_string(),
                    expected: "a value within its limits".into(),
                });
            }
        }
        let pool = options.pool()?;
        let planner = Planner { context: &self.context().keeping(&kept), ends, keeps, options, prover, limit };
        Ok(pool.install(|| planner.plan(roadmap)))
    }
}

impl Solver {
    /// Extends a roadmap, for plans to come, by spending about `checks` checks.
    ///
    /// # Errors
    /// [`Error::Option`] and [`Error::Input`] as [`Solver::plan_with`]; the first also for kept
    /// links, which no roadmap keeps.
    pub fn grow_roadmap(&self, roadmap: &mut Roadmap, checks: usize, options: &PlanOptions) -> Result<()> {
        options.check()?;
        if !options.keep.is_empty() {
            let expected = "none: roadmaps do not keep links".into();
            return Err(Error::Option { name: "keep", value: "kept links".into(), expected });
        }
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
        let mut escapes = [None, None];
        let mut free_ends = self.ends.map(|end| end.to_vec());
        for side in 0..2 {
            if self.prover.holds(self.ends[side]) {
                continue;
            }
            let found = escape(self.context, self.ends[side], &self.escape_options(side));
            self.prover.checks += found.checks;
            let exit = found.points.last().cloned();
            escapes[side] = Some(found);
            match exit {
                Some(exit) => free_ends[side] = exit,
                None => return Plan::none(escapes, self.prover.checks, roadmap.len()),
            }
        }
        let before = roadmap.checks();
        let found = self.find(roadmap, free_ends);
        let (grown, nodes) = (roadmap.checks() - before, roadmap.len());
        let Some((mut points, method)) = found else {
            return Plan::none(escapes, self.prover.checks + grown, nodes);
        };
        self.prover.limited(self.left(grown));
        if self.options.shortcut {
            let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
            shortcut(&mut self.prover, self.context.metric, &mut points, &mut rng);
        }
        if let Some(clearance) = self.options.clearance.filter(|clearance| *clearance > self.context.clearance) {
            push_off(&mut self.prover, self.context, &mut points, clearance);
        }
        // Each turn takes the path from an end, and leaves it reversed.
        let mut free = [0, 0];
        for side in 0..2 {
            if let Some(found) = escapes[side].take() {
                let free_points = points.len() - free[0];
                let found = self.joined(side, found, (&mut points, free_points));
                free[side] = found.free_from;
                escapes[side] = Some(found);
            }
            points.reverse();
        }
        let length = path::length(self.context.metric, &points.concat(), self.ends[0].len());
        let [free_from, free_to] = [free[0], points.len() - 1 - free[1]];
        let checks = self.prover.checks + grown;
        let [start_escape, goal_escape] = escapes;
        Plan { points, free_from, free_to, start_escape, goal_escape, method: Some(method), length, checks, nodes }
    }

    fn escape_options(&self, side: usize) -> EscapeOptions {
        let PlanOptions { tolerance, resolution, seed, .. } = *self.options;
        EscapeOptions::default()
            .tolerance(tolerance)
            .resolution(resolution)
            .seed(seed)
            .toward(self.ends[1 - side].clone())
            .termination(self.prover.left())
    }

    /// Puts an escape before the path that begins at its end, and is free at its first
    /// `free_points`. Returns the escape, which may have become shorter.
    fn joined(&mut self, side: usize, found: Escape, (points, free_points): (&mut Vec<Vec<f64>>, usize)) -> Escape {
        let mut end = 0;
        let mut escape = found;
        if self.options.shortcut {
            let before = escape.checks;
            let (q, options, onward) = (self.ends[side], self.escape_options(side), &points[..free_points]);
            (escape, end) = shortened_onward(self.context, q, &options, escape, onward);
            self.prover.checks += escape.checks - before;
        }
        points.splice(..=end, escape.points.iter().cloned());
        escape
    }

    fn find(&mut self, roadmap: &mut Roadmap, [from, to]: [Vec<f64>; 2]) -> Option<(Vec<Vec<f64>>, PlanMethod)> {
        if let Some(way) = self.prover.join(&from, &to) {
            return Some((std::iter::once(from).chain(way).collect(), PlanMethod::Straight));
        }
        let (metric, space) = (self.context.metric, &self.context.checker.scene().space);
        let mut rng = ChaCha8Rng::seed_from_u64(self.options.seed);
        let roots = [std::slice::from_ref(&from), std::slice::from_ref(&to)];
        let trees = || RrtConnect::new(metric, roots, MAX_EDGE_SHARE * metric.diameter());
        let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| uniform(space, rng, out);
        // Slides leave the places of kept links, and so do the nodes of roadmaps.
        if !self.context.kept.is_empty() {
            let path = trees().grow(&mut self.prover, &mut sample, &mut rng)?;
            return Some((path, PlanMethod::Trees));
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
        // Nodes of slides lie densely along contacts, where straight edges lead nowhere, so that
        // each kind has trees of its own.
        let mut planners = [(trees(), 1), (trees().sliding(), SLIDING_CHECKS_FACTOR)];
        let mut round = FIRST_ROUND_CHECKS;
        loop {
            for (trees, factor) in &mut planners {
                let left = self.left(grower.roadmap.checks() - before);
                let limited = self.prover.limited(left.min(*factor * round));
                let path = trees.grow(&mut self.prover, &mut sample, &mut rng);
                self.prover.unlimit(limited);
                if let Some(path) = path {
                    if self.keeps {
                        grower.keep(&path);
                    }
                    return Some((path, PlanMethod::Trees));
                }
            }
            grower.left = self.left(grower.roadmap.checks() - before);
            let [a, b] = *nodes.get_or_insert_with(|| [grower.add(&from), grower.add(&to)]);
            let begun = grower.roadmap.checks();
            while grower.roadmap.checks() - begun < ROADMAP_CHECKS_FACTOR * round {
                if grower.is_spent() {
                    return None;
                }
                let left = grower.left;
                grow(&mut grower, left.min(SLIDING_CHECKS_FACTOR * round).min(MAX_BATCH_CHECKS));
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

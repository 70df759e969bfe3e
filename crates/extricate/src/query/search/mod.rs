//! The search for the nearest exit: what it has come to know, and descents, each of which has to
//! beat the incumbent. Which are made, one after the other, is in `run`.

pub mod coordinates;
pub mod evaluate;
pub mod exits;
pub mod lead;
pub mod local_metric;
pub mod parts;
pub mod polish;
pub mod prove;
pub mod prune;
pub mod run;
pub mod scratch;
pub mod termination;

use super::answer::Answer;
use super::bound::proof::Proof;
use super::context::Context;
use super::descent::{DescentOptions, DescentScratch, Outcome, Start, descend};
use super::options::Toward;
use super::plan::Plan;
use super::starts::directions::tree::Directions;
use super::starts::{Ask, PartOf, Starts};
use crate::cspace::Label;
use crate::metric::Anchor;
use crate::samples::BoundaryScratch;
use crate::scene::PairId;
use evaluate::Evaluator;
use exits::Exits;
use local_metric::LocalMetric;
use prune::{Ends, Pruning};

/// The best answer so far.
#[derive(Debug, Clone, Default)]
pub struct Incumbent {
    /// Distance from the query, in metric units.
    pub depth: f64,
    /// The configuration.
    pub config: Vec<f64>,
    /// Whether the exact checker called it free during this query.
    pub verified: bool,
}

/// What a search has come to know, and memory for it.
#[derive(Default)]
pub struct Known {
    /// The query.
    pub anchor: Anchor,
    /// The metric around it.
    pub local: LocalMetric,
    /// Where colliding bodies part.
    pub directions: Directions,
    /// Where descents start.
    pub starts: Starts,
    /// Pairs that collide where a query beyond the limits is moved onto them.
    pub colliding_within: Vec<PairId>,
    /// The best answer so far.
    pub incumbent: Incumbent,
    /// A sample to fall back on where that turns out to collide.
    pub fallback: Incumbent,
    /// Distinct exits: those wanted, or, where one is, the best few, to tell whether it is alone.
    pub exits: Exits,
    /// How many of them are wanted.
    pub wanted: usize,
    /// Where descents ended.
    pub ends: Ends,
    /// Starts that were tried, those that cost no check among them.
    pub tried: usize,
    /// Of the starts of one kind.
    pub round: Round,
    /// Of the search, or of each part.
    pub ranks: Vec<Ranks>,
    /// What [`Known::unseen`] is of, where parts were searched instead.
    pub unseen_in_parts: Option<f64>,
    /// A configuration that is known to be free: a search begins with it, if it finds nothing
    /// nearer at first. If it is empty, a search whose descents find nothing does not look for
    /// anything free.
    pub resort: Option<Vec<f64>>,
    /// A configuration that a descent is to start from.
    pub composed: Vec<f64>,
    /// How far it is from the query.
    pub step: Vec<f64>,
    /// What is proved meanwhile.
    pub proof: Proof,
}

/// Starts of one kind, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Round {
    tried: usize,
    /// The last that made the incumbent nearer.
    last_success: usize,
    /// Of every success, how many were tried by then and how deep it was.
    successes: Vec<(usize, f64)>,
}

impl Round {
    /// Begins anew.
    pub fn begin(&mut self) {
        (self.tried, self.last_success) = (0, 0);
        self.successes.clear();
    }

    fn note(&mut self, before: f64, after: f64) {
        self.tried += 1;
        if after < before {
            self.successes.push((self.tried, after));
        }
        if after < NEARER * before {
            self.last_success = self.tried;
        }
    }

    /// Whether `least` were tried, and as many since the last success as until then. How late the
    /// start is that finds the nearest exit has a long tail: where one in so many has just
    /// succeeded, as many more may well do so again.
    pub fn is_over(&self, least: usize, patience: usize) -> bool {
        self.tried >= least.max(patience * self.last_success)
    }

    /// The first that came within 5 % of `depth`; 0 where that was known before.
    pub fn rank_of(&self, depth: f64) -> usize {
        self.successes.iter().find(|(_, found)| *found <= NEAR * depth).map_or(0, |(number, _)| *number)
    }
}

/// A success makes the incumbent nearer than this share of what it was.
const NEARER: f64 = 0.99;
/// An exit within this of the nearest one counts as it.
const NEAR: f64 = 1.05;

/// How late the starts were that found the nearest exit of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranks {
    /// Degrees of freedom that it searched over.
    pub degrees: usize,
    /// Of the stored samples, as far as they found it.
    pub stored: usize,
    /// Of the starts around the query; 0 where a stored sample found it.
    pub around: usize,
}

/// Which starts are tried in a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turn {
    /// The one that is tried first; then that of the next frame.
    pub next: usize,
    /// How many may cost checks.
    pub starts_per_frame: usize,
}

/// Exits that are remembered where one is wanted.
pub const REMEMBERED: usize = 4;

/// One search: what it stands on, what it is to do, what it works with.
pub struct Search<'a> {
    pub context: &'a Context<'a>,
    pub plan: Plan,
    pub known: &'a mut Known,
    pub evaluator: &'a mut Evaluator,
    pub descent: &'a mut DescentScratch,
    pub boundary: &'a mut BoundaryScratch,
    /// Whether descents are believed for what they see of the pieces around meshes, until the last
    /// one.
    pub believes: bool,
    /// Set in a stream: which of the starts are tried.
    pub turn: Option<Turn>,
    /// Set in a search over some of the joints: which, and where the others stay.
    pub part: Option<PartOf<'a>>,
}

impl Known {
    /// Begins a search for `wanted` exits from the anchor.
    pub fn begin(&mut self, context: &Context, wanted: usize) {
        let space = &context.checker.scene().space;
        self.local.set(context, &self.anchor);
        self.starts.reset();
        self.directions.reset();
        self.wanted = wanted;
        self.exits.reset(if wanted > 1 { wanted } else { REMEMBERED }, space.nq());
        self.ends.reset(space.nq());
        self.tried = 0;
        self.ranks.clear();
        self.unseen_in_parts = None;
    }

    /// The pairs that have to part.
    pub fn colliding_of<'a>(&'a self, answer: &'a Answer) -> &'a [PairId] {
        if answer.outside.is_empty() { &answer.colliding } else { &self.colliding_within }
    }

    /// Notes the incumbent as what to fall back on.
    pub fn note_fallback(&mut self) {
        let Self { incumbent, fallback, .. } = self;
        (fallback.depth, fallback.verified) = (incumbent.depth, incumbent.verified);
        fallback.config.clone_from(&incumbent.config);
    }

    /// What is not nearer than this is of no use.
    pub fn ceiling(&self) -> f64 {
        if self.wanted > 1 { self.exits.ceiling() } else { self.incumbent.depth }
    }

    /// Makes the exit the incumbent that is nearest to the goal, of those that are near enough.
    pub fn choose_toward(&mut self, context: &Context, toward: &Toward) {
        let most = self.incumbent.depth * (1.0 + toward.share);
        let near = self.exits.iter().filter(|(depth, _)| *depth <= most);
        let from_goal = |config: &[f64]| context.metric.distance(config, &toward.goal);
        let best = near.map(|(depth, config)| (from_goal(config), depth, config)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, depth, config)) = best
            && distance < from_goal(&self.incumbent.config)
        {
            let config = config.to_vec();
            self.take(depth, &config, true);
        }
    }

    /// Makes a configuration the incumbent.
    pub fn take(&mut self, depth: f64, config: &[f64], verified: bool) {
        (self.incumbent.depth, self.incumbent.verified) = (depth, verified);
        self.incumbent.config.clear();
        self.incumbent.config.extend_from_slice(config);
    }

    /// Estimated share of starts that would lead to an exit that no descent has met.
    ///
    /// # Source
    /// C. G. E. Boender and A. H. G. Rinnooy Kan, "Bayesian stopping rules for multistart global
    /// optimization methods", Mathematical Programming 37, 1987, doi:10.1007/BF02591684: of n
    /// uniform starts that led to w distinct ends, w (w + 1) / (n (n - 1)). Starts here are the
    /// nearest samples, not uniform, and those that were given up count as led to what is known.
    pub fn unseen(&self) -> f64 {
        if let Some(unseen) = self.unseen_in_parts {
            return unseen;
        }
        let (w, n) = (self.ends.len() as f64, self.tried as f64);
        if n < 2.0 { 1.0 } else { (w * (w + 1.0) / (n * (n - 1.0))).min(1.0) }
    }
}

impl Search<'_> {
    /// Whether what is proved leaves no more than the gap that was requested.
    pub fn is_proved(&mut self) -> bool {
        let Known { proof, anchor, incumbent, .. } = &mut *self.known;
        incumbent.verified && proof.is_enough(self.context, anchor, incumbent.depth, &mut self.evaluator.check)
    }

    /// Makes the configuration that is known beforehand the incumbent, if it is free and nearer.
    pub fn take_resort(&mut self) {
        let Some(config) = self.known.resort.clone().filter(|config| !config.is_empty()) else { return };
        let depth = self.evaluator.distance(self.context, &self.known.anchor, &config);
        if depth < self.known.incumbent.depth && self.evaluator.label(self.context, &config) == Label::Free {
            self.known.take(depth, &config, true);
        }
    }

    /// The stored sample of a rank, if there are so many.
    pub fn start(&mut self, rank: usize) -> Option<u32> {
        let Known { starts, anchor, local, .. } = &mut *self.known;
        let ask = Ask { context: self.context, plan: &self.plan, anchor, part: self.part };
        starts.get(rank, &ask, local, self.boundary)
    }

    /// Whether a stored sample is too far for a descent to be worth its checks.
    pub fn is_far(&mut self, id: u32) -> bool {
        let farthest = self.plan.farthest_start * self.known.ceiling();
        let config = self.compose(id);
        let distance = self.evaluator.distance(self.context, &self.known.anchor, &config);
        self.known.composed = config;
        distance > farthest
    }

    /// A stored sample, or its coordinates of the part with the others where they stay; in memory
    /// of `known` that has to be given back.
    fn compose(&mut self, id: u32) -> Vec<f64> {
        let mut composed = std::mem::take(&mut self.known.composed);
        let sample = self.context.samples().config(id);
        match self.part {
            Some(part) => part.compose(sample, &mut composed),
            None => sample.clone_into(&mut composed),
        }
        composed
    }

    /// A descent from a stored sample.
    pub fn try_sample(&mut self, id: u32) {
        let config = self.compose(id);
        let start = match self.part {
            Some(part) => Start::known(self.context, id, Some(part.holding)),
            None => Start::of(self.context, id),
        };
        self.try_start(Start { config: &config, ..start });
        self.known.composed = config;
    }

    /// A descent that has to beat the incumbent; how deep it came, where it did.
    pub fn try_start(&mut self, start: Start) -> Option<f64> {
        let ceiling = self.known.ceiling();
        self.known.tried += 1;
        let (before, incumbent) = (self.evaluator.checks, self.known.incumbent.depth);
        let (found, outcome) = self.descend(start, ceiling, self.plan.descent);
        if outcome == Outcome::Ended && self.evaluator.checks > before {
            self.known.ends.push(&self.descent.end);
        }
        if let Some(depth) = found {
            self.keep(depth);
        }
        let Known { round, incumbent: now, .. } = &mut *self.known;
        round.note(incumbent, now.depth);
        found
    }

    /// A descent that has to beat `ceiling`; what it finds is in `descent.best`.
    pub fn descend(&mut self, start: Start, ceiling: f64, options: DescentOptions) -> (Option<f64>, Outcome) {
        let pruning = Pruning { incumbent: ceiling, factor: self.plan.prune_factor, ends: &self.known.ends };
        descend(self.context, &self.known.anchor, start, pruning, &options, self.descent, self.evaluator)
    }

    /// The same, whatever others led to.
    pub fn descend_alone(&mut self, start: Start, ceiling: f64, options: DescentOptions) -> (Option<f64>, Outcome) {
        let none = Ends::default();
        let pruning = Pruning { incumbent: ceiling, factor: self.plan.prune_factor, ends: &none };
        descend(self.context, &self.known.anchor, start, pruning, &options, self.descent, self.evaluator)
    }

    /// Makes what a descent found the incumbent if it is nearer. Along meshes it is believed until
    /// the last descent, which looks at the meshes themselves.
    pub fn keep(&mut self, depth: f64) {
        let space = &self.context.checker.scene().space;
        let Known { exits, local, incumbent, wanted, .. } = &mut *self.known;
        exits.offer(space, local, depth, &self.descent.best);
        if *wanted > 1 {
            self.evaluator.reserved = exits.len();
        }
        let is_nearer = depth < incumbent.depth || (!incumbent.verified && depth <= incumbent.depth);
        let believes = self.believes;
        if is_nearer && (believes || self.evaluator.label(self.context, &self.descent.best) == Label::Free) {
            self.known.take(depth, &self.descent.best, !believes);
        }
    }
}

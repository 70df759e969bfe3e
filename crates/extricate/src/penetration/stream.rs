//! Queries that come one after the other from nearly the same place, as from a simulation or a haptic device.

use super::answer::Answer;
use super::exits::are_alike;
use super::hope::Hope;
use super::options::{Effort, QueryOptions};
use super::plan::{HOPE, Plan};
use super::refine::{RefineOptions, Start};
use super::search::QueryScratch;
use super::{Ground, search_all};
use crate::collision::ContactSearch;
use crate::cspace::{Config, Label};

/// Options of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamOptions {
    /// Of each query; a stream gives one way out a frame, so `exits` is not looked at.
    pub query: QueryOptions,
    /// The way out of the last frame is kept until another one is nearer by more than this share of its depth, in `[0, 1)`: 0
    /// always takes the nearest, 0.1 keeps directions from flipping between two ways out that are about as near.
    pub hysteresis: f64,
    /// How many of the boundary samples that a single query would start from are looked at each frame, in turn; those that what is known of them
    /// rules out cost nothing and do not count.
    pub looks: usize,
}

impl Default for StreamOptions {
    /// No hysteresis, four looks.
    fn default() -> Self {
        Self { query: QueryOptions::default(), hysteresis: 0.0, looks: 4 }
    }
}

/// What is carried from one query to the next, and memory. It belongs to no model: asked of another one, it begins anew.
#[derive(Default)]
pub struct Stream {
    options: StreamOptions,
    scratch: QueryScratch,
    /// Ways out of the last frame, row major: the one that was given, then the nearest others.
    tracked: Vec<f64>,
    nq: usize,
    /// The next boundary sample to look at.
    next: usize,
}

/// From a way out of the last frame, for few steps.
const FOLLOW: RefineOptions = RefineOptions {
    iterations: 15,
    margin: 0.05,
    reach: 0.1,
    search: ContactSearch::Exact,
    radius: 0.3,
    tolerance: 1e-5,
    hope: Hope::OF_A_PROBE,
};

impl Stream {
    /// A stream that has seen nothing.
    pub fn new(options: StreamOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// Forgets the frames so far: the next one is answered as a query on its own.
    pub fn restart(&mut self) {
        self.tracked.clear();
        (self.next, self.scratch.lead.next) = (0, 0);
    }

    /// The answer for the next frame; `None` only where samples are stale and nothing free was found.
    ///
    /// # Guarantee
    /// That of [`super::query`]. While the query stands still, every start of a refined query is looked at within as many frames
    /// as `looks` goes into their number.
    pub(crate) fn query(&mut self, ground: &Ground, q: &Config) -> Option<Answer> {
        let options = QueryOptions { exits: 0, ..self.options.query.clone() };
        if self.nq != q.len() {
            self.restart();
            self.nq = q.len();
        }
        let mut answer = self.scratch.begin(ground, q, &options);
        if answer.colliding.is_empty() {
            return Some(answer);
        }
        let plan = Plan::of(&options, ground, &answer.colliding);
        if !self.scratch.first_witness(ground, &plan, &mut answer) {
            return None;
        }
        match options.effort {
            Effort::Nearest => {}
            Effort::Refined if !self.tracked.is_empty() && plan.in_turn.is_some() => {
                self.follow_in_turn(ground, &plan, &options, &mut answer);
            }
            Effort::Refined if !self.tracked.is_empty() => self.follow(ground, &plan, &mut answer),
            _ => search_all(ground, &plan, &options, &mut self.scratch, &mut answer),
        }
        self.keep(ground, &answer);
        self.scratch.describe(ground, &options, &mut answer);
        Some(answer)
    }

    /// Searches as a single query does, but from the way out of the last frame first, and then from as many others as may be looked at: what it leads
    /// to has most of them given up by their planes.
    fn follow_in_turn(&mut self, ground: &Ground, plan: &Plan, options: &QueryOptions, answer: &mut Answer) {
        let lead = &mut self.scratch.lead;
        lead.config.extend_from_slice(&self.tracked[..self.nq]);
        lead.looks = self.options.looks;
        search_all(ground, plan, options, &mut self.scratch, answer);
        let lead = &self.scratch.lead;
        let current = lead.depth.is_finite().then(|| (lead.depth, lead.config.clone()));
        self.keep_to(ground, plan, current, answer);
    }

    /// Slides the ways out of the last frame along, and looks at some other starts.
    fn follow(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        let Self { scratch, tracked, nq, next, options } = self;
        scratch.look_around(ground);
        answer.verified = answer.verified || scratch.refine.label(ground, &answer.witness) == Label::Free;
        // With raw meshes, the way out that was given is followed along them; the others are known by the pieces around them.
        let others = if ground.checker.all_convex() { ContactSearch::Exact } else { ContactSearch::Coarse };
        let mut current: Option<(f64, Vec<f64>)> = None;
        for (i, start) in tracked.chunks_exact(*nq).enumerate() {
            let (ceiling, follow) = if i == 0 {
                (f64::INFINITY, RefineOptions { reach: plan.polish.reach, ..FOLLOW })
            } else {
                (HOPE * answer.depth, RefineOptions { search: others, ..FOLLOW })
            };
            let found = scratch.refine_from(ground, &follow, Start::at(start), ceiling, answer);
            if let Some(depth) = found {
                scratch.remember(ground, depth);
            }
            if i == 0 {
                current = found.map(|depth| (depth, scratch.slid.clone()));
            }
        }
        scratch.choose(ground, plan);
        scratch.forget_probes();
        for _ in 0..options.looks.min(scratch.chosen.len()) {
            let id = scratch.chosen[*next % scratch.chosen.len()];
            let ceiling = answer.depth;
            scratch.probe(ground, &plan.probe, Start::of(ground, id), ceiling, answer);
            *next += 1;
        }
        if *next >= scratch.chosen.len() {
            *next = 0;
            let ceiling = answer.depth;
            scratch.probe_scattered(ground, plan, ceiling, ceiling, answer);
        }
        scratch.carry_on(ground, plan, answer);
        self.keep_to(ground, plan, current, answer);
    }

    /// Keeps to the way out of the last frame, unless another is nearer by more than the hysteresis.
    fn keep_to(&mut self, ground: &Ground, plan: &Plan, current: Option<(f64, Vec<f64>)>, answer: &mut Answer) {
        let Self { scratch, options, .. } = self;
        let space = &ground.checker.scene().space;
        if let Some((depth, witness)) = current
            && answer.depth < depth
            && answer.depth >= (1.0 - options.hysteresis) * depth
            && !are_alike(space, &mut scratch.local, (depth, &witness), (answer.depth, &answer.witness))
        {
            let mut kept = Answer { depth: f64::INFINITY, verified: false, ..answer.clone() };
            scratch.refine_from(ground, &plan.polish, Start::at(&witness), f64::INFINITY, &mut kept);
            if kept.verified && answer.depth >= (1.0 - options.hysteresis) * kept.depth {
                scratch.exits.offer(space, &mut scratch.local, answer.depth, &answer.witness);
                *answer = kept;
            }
        }
    }

    /// Notes the ways out for the next frame.
    fn keep(&mut self, ground: &Ground, answer: &Answer) {
        let Self { scratch, tracked, .. } = self;
        let space = &ground.checker.scene().space;
        tracked.clear();
        if !answer.verified {
            return;
        }
        tracked.extend_from_slice(&answer.witness);
        for (depth, config) in scratch.exits.iter() {
            if !are_alike(space, &mut scratch.local, (depth, config), (answer.depth, &answer.witness)) {
                tracked.extend_from_slice(config);
            }
        }
    }
}

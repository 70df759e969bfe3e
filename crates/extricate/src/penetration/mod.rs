//! The query: from a colliding configuration to the nearest free one, verified and bounded.
//!
//! Candidates make it global (the nearest boundary samples, spread out), refinement makes it tight, the exact checker makes it
//! true, the certificate says how much better any answer could be.

pub mod certificate;
mod dense;
mod local_metric;
pub mod qp;
pub mod refine;
pub mod scatter;
mod wander;

use serde::Serialize;

use crate::boundary::{BoundaryScratch, SampleSet};
use crate::collision::{Checker, ContactSearch, ConvexOverlap};
use crate::cspace::{Config, Label};
use crate::kinematics::forward;
use crate::math::Pose;
use crate::metric::motion_bound::MotionScratch;
use crate::metric::{Anchor, Metric};
use crate::scene::MetricSpec;
use certificate::InteriorBalls;
use local_metric::LocalMetric;
use refine::{RefineOptions, RefineScratch, slide};
use scatter::{ScatterOptions, ScatterScratch, scatter};
use wander::{WanderScratch, wander};

/// How hard a query tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// The nearest stored boundary sample; free as of learning.
    Nearest,
    /// Diverse candidates, pulled in, slid along the contact surface, verified.
    #[default]
    Refined,
    /// Many starts and long refinement.
    Exhaustive,
}

/// Options of a query.
#[derive(Debug, Clone, Default)]
pub struct QueryOptions {
    /// How hard to try.
    pub effort: Effort,
}

/// The nearest free configuration found, and what is known about it.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// Distance from the query to the witness, in the scene's metric; 0 where the query is free.
    pub depth: f64,
    /// Proved: no free configuration is nearer than this.
    pub lower_bound: f64,
    /// A free configuration at distance `depth`.
    pub witness: Vec<f64>,
    /// What was asked for.
    pub effort: Effort,
    /// Collision checks and distance evaluations spent.
    pub checks: usize,
    /// Largest displacement \[m\] of any point of the moving geometry between the query and the witness.
    pub max_displacement: f64,
    /// Indices of the scene's pairs that collide at the query.
    pub colliding: Vec<usize>,
    /// Indices of the scene's pairs that touch (within [`TOUCHING`] beyond the clearance) at the witness.
    pub touching: Vec<usize>,
    /// Whether the exact checker called the witness free during this query; otherwise it did when the model was learned.
    pub verified: bool,
}

/// A pair touches where it is nearer than the clearance plus this \[m\].
pub const TOUCHING: f64 = 1e-4;

/// What a query stands on; borrowed from a model.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The exact checker.
    pub checker: &'a Checker,
    /// The scene's metric.
    pub metric: &'a Metric,
    /// Verified boundary samples; at least one.
    pub boundary: &'a SampleSet,
    /// For the lower bound.
    pub balls: &'a InteriorBalls,
    /// Least distance \[m\] of a free pair.
    pub clearance: f64,
    /// A typical length of the configuration space in metric units.
    pub scale: f64,
}

/// Memory that queries reuse; one per thread.
#[derive(Default)]
pub struct QueryScratch {
    refine: RefineScratch,
    boundary: BoundaryScratch,
    motion: MotionScratch,
    overlaps: Vec<ConvexOverlap>,
    scatter: ScatterScratch,
    local: LocalMetric,
    wander: WanderScratch,
    anchor: Anchor,
    poses: Vec<Pose>,
    pool: Vec<(u32, f64)>,
    chosen: Vec<u32>,
    slid: Vec<f64>,
    /// What the probed descents are expected to reach, and which they are.
    promising: Vec<(f64, usize)>,
    /// Where they stand, row major.
    ends: Vec<f64>,
}

/// How many candidates an effort takes and how far it refines each.
struct Plan {
    /// Nearest samples looked at.
    pool: usize,
    /// Of them refined, most different first.
    starts: usize,
    /// A candidate is too like a chosen one within this share of its own distance from the query.
    spread: f64,
    /// Whether a descent starts from the query itself, which contacts of deep overlaps make slow.
    from_query: bool,
    /// Starts around the query.
    scatter: ScatterOptions,
    /// Random steps from the best result.
    wander: usize,
    refine: RefineOptions,
    /// Whether to look around the query a second time, inside what is then known.
    scatter_again: bool,
    /// Iterations of every descent.
    first: usize,
    /// Descents carried on.
    kept: usize,
}

/// The last descent, from the best result so far.
const POLISH: RefineOptions =
    RefineOptions { iterations: 60, margin: 0.05, search: ContactSearch::Exact, radius: 0.05, tolerance: 1e-7 };

/// A probed descent is carried on if it is expected to end below this times the best depth so far.
const HOPE: f64 = 1.15;

impl Plan {
    fn of(effort: Effort, ground: &Ground) -> Self {
        // Descents along exact contacts, toward the query in its own coordinates, end where they seem to.
        let smooth = ground.checker.contacts_are_complete() && ground.metric.kind() == MetricSpec::Joint;
        let degrees = ground.checker.scene().space.nv();
        let refine =
            RefineOptions { iterations: 40, margin: 0.05, search: ContactSearch::Quick, radius: 0.5, tolerance: 1e-4 };
        match effort {
            Effort::Nearest => Self {
                pool: 1,
                starts: 0,
                spread: 0.0,
                from_query: false,
                scatter: ScatterOptions { directions: 0, wanted: 0 },
                scatter_again: false,
                wander: 0,
                refine,
                first: 0,
                kept: 0,
            },
            // Where linearised descents mislead, more of them, from more kinds of starts, are carried on.
            Effort::Refined if !smooth => Self {
                pool: 192,
                starts: 16,
                spread: 0.35,
                from_query: true,
                scatter: ScatterOptions { directions: 32, wanted: 3 },
                scatter_again: true,
                first: 5,
                kept: 12,
                wander: 64,
                refine,
            },
            Effort::Refined => Self {
                pool: 192,
                starts: 16,
                spread: 0.4,
                from_query: false,
                scatter: ScatterOptions { directions: degrees.div_ceil(2), wanted: 3 },
                scatter_again: false,
                first: 3,
                kept: 3,
                wander: 0,
                refine,
            },
            Effort::Exhaustive => {
                let refine = RefineOptions {
                    iterations: 60,
                    margin: 0.12,
                    search: ContactSearch::Exact,
                    radius: 0.5,
                    tolerance: 1e-6,
                };
                Self {
                    pool: 1024,
                    starts: 96,
                    spread: 0.15,
                    from_query: true,
                    scatter: ScatterOptions { directions: 200, wanted: 24 },
                    scatter_again: true,
                    wander: 400,
                    refine,
                    first: 3,
                    kept: 64,
                }
            }
        }
    }
}

/// The nearest free configuration to `q` that the effort finds.
///
/// # Guarantee
/// `lower_bound <= depth`, and `lower_bound` is proved. The witness is free: by the exact checker during this call where
/// `verified` is set, otherwise when the model was learned.
pub fn query(ground: &Ground, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Answer {
    scratch.refine.checks = 1;
    scratch.refine.check.forget_contacts();
    let mut colliding = Vec::new();
    ground.checker.colliding_pairs(q, &mut scratch.refine.check, &mut colliding);
    if colliding.is_empty() {
        return free_answer(q, options.effort);
    }
    ground.metric.anchor(q, &mut scratch.anchor);
    let plan = Plan::of(options.effort, ground);
    scratch.choose(ground, &plan);
    let mut answer = Answer { colliding, ..free_answer(q, options.effort) };
    (answer.depth, answer.verified) = (scratch.pool[0].1, false);
    answer.witness.copy_from_slice(ground.boundary.config(scratch.pool[0].0));
    if options.effort == Effort::Exhaustive {
        // First all that a refined query does, so that more effort never ends farther away.
        let refined = Plan::of(Effort::Refined, ground);
        scratch.choose(ground, &refined);
        scratch.refine_all(ground, &refined, &mut answer);
        scratch.choose(ground, &plan);
    }
    if plan.starts > 0 {
        scratch.refine_all(ground, &plan, &mut answer);
    }
    scratch.describe(ground, &mut answer);
    answer
}

fn free_answer(q: &Config, effort: Effort) -> Answer {
    Answer {
        depth: 0.0,
        lower_bound: 0.0,
        witness: q.to_vec(),
        effort,
        checks: 1,
        max_displacement: 0.0,
        colliding: Vec::new(),
        touching: Vec::new(),
        verified: true,
    }
}

impl QueryScratch {
    /// Fills `pool` with the nearest samples, and `chosen` with those of them that are not too like each other.
    fn choose(&mut self, ground: &Ground, plan: &Plan) {
        ground.boundary.nearest(ground.metric, &self.anchor, plan.pool, &mut self.boundary, &mut self.pool);
        self.chosen.clear();
        if plan.starts == 0 {
            return;
        }
        forward(ground.checker.scene(), &self.anchor.q, &mut self.poses);
        self.local.set(ground, &self.anchor, &self.poses);
        let space = &ground.checker.scene().space;
        for &(id, _) in &self.pool {
            if self.chosen.len() == plan.starts {
                break;
            }
            let candidate = ground.boundary.config(id);
            let local = &mut self.local;
            let reach = plan.spread * local.distance(space, &self.anchor.q, candidate);
            if self.chosen.iter().all(|c| local.distance(space, ground.boundary.config(*c), candidate) > reach) {
                self.chosen.push(id);
            }
        }
    }

    /// Refines from the chosen samples and from the query itself; keeps the best verified result in `answer`.
    fn refine_all(&mut self, ground: &Ground, plan: &Plan, answer: &mut Answer) {
        answer.verified = self.refine.label(ground, &answer.witness) == Label::Free;
        let first = RefineOptions { iterations: plan.first, ..plan.refine };
        self.ends.clear();
        self.promising.clear();
        let query = self.anchor.q.clone();
        if plan.from_query {
            self.probe(ground, &first, &query, answer);
        }
        self.probe_scattered(ground, plan, &first, answer);
        let chosen = std::mem::take(&mut self.chosen);
        for &id in &chosen {
            self.probe(ground, &first, ground.boundary.config(id), answer);
        }
        self.chosen = chosen;
        if plan.scatter_again {
            self.probe_scattered(ground, plan, &first, answer);
        }
        // The most promising are carried on.
        self.promising.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.promising.truncate(plan.kept);
        let (promising, ends) = (std::mem::take(&mut self.promising), std::mem::take(&mut self.ends));
        let nq = query.len();
        for (expected, at) in &promising {
            if *expected > HOPE * answer.depth {
                break;
            }
            self.refine_from(ground, &plan.refine, &ends[at * nq..(at + 1) * nq], answer);
        }
        (self.promising, self.ends) = (promising, ends);
        // The descents so far were cut short; the best one is carried to its end.
        let best = answer.witness.clone();
        self.refine_from(ground, &POLISH, &best, answer);
        if answer.verified && plan.wander > 0 {
            let Self { anchor, local, wander: wandering, refine, .. } = self;
            let best = (&mut answer.witness[..], answer.depth);
            answer.depth = wander(ground, anchor, best, plan.wander, local, wandering, refine);
            let best = answer.witness.clone();
            self.refine_from(ground, &POLISH, &best, answer);
        }
    }

    /// The first steps of a descent; where it stands then and what it is expected to reach are noted.
    fn probe(&mut self, ground: &Ground, options: &RefineOptions, start: &[f64], answer: &mut Answer) {
        self.refine_from(ground, options, start, answer);
        self.promising.push((self.refine.expected, self.promising.len()));
        self.ends.extend_from_slice(self.refine.end());
    }

    /// Refines from free configurations around the query, nearer than the answer.
    fn probe_scattered(&mut self, ground: &Ground, plan: &Plan, options: &RefineOptions, answer: &mut Answer) {
        let Self { anchor, local, scatter: scattered, refine, .. } = self;
        scatter(ground, anchor, answer.depth, &plan.scatter, local, scattered, refine);
        let scattered = std::mem::take(&mut self.scatter.starts);
        for start in scattered.chunks_exact(self.anchor.q.len()) {
            self.probe(ground, options, start, answer);
        }
        self.scatter.starts = scattered;
    }

    /// Refines from `start`; a better result replaces the answer's witness if the exact checker calls it free.
    fn refine_from(&mut self, ground: &Ground, options: &RefineOptions, start: &[f64], answer: &mut Answer) {
        let found = slide(ground, &self.anchor, start, answer.depth, options, &mut self.slid, &mut self.refine);
        let Some(depth) = found else {
            return;
        };
        if (depth < answer.depth || !answer.verified) && self.refine.label(ground, &self.slid) == Label::Free {
            answer.depth = depth;
            answer.witness.copy_from_slice(&self.slid);
            answer.verified = true;
        }
    }

    /// Adds what is said about a witness once it is chosen.
    fn describe(&mut self, ground: &Ground, answer: &mut Answer) {
        let Self { refine, anchor, poses, motion, overlaps, .. } = self;
        answer.max_displacement = ground.metric.max_displacement_from(anchor, &answer.witness, &mut refine.metric);
        let margin = ground.clearance + TOUCHING;
        answer.touching = refine.touching(ground, &answer.witness, margin);
        forward(ground.checker.scene(), &anchor.q, poses);
        overlaps.clear();
        ground.checker.convex_overlaps(&anchor.q, &answer.colliding, &mut refine.check, overlaps);
        let bound = certificate::lower_bound(
            ground,
            poses,
            &answer.colliding,
            overlaps,
            answer.depth,
            motion,
            &mut refine.check,
        );
        answer.lower_bound = bound.min(answer.depth);
        answer.checks = refine.checks;
    }
}

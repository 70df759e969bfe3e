//! How many candidates a query takes, and how far it refines each.

use super::Ground;
use super::hope::Hope;
use super::options::{Effort, QueryOptions};
use super::refine::RefineOptions;
use super::scatter::ScatterOptions;
use super::width::Width;
use crate::boundary::Care;
use crate::collision::ContactSearch;
use crate::scene::MetricSpec;

/// What a query does, step by step.
pub struct Plan {
    /// Of the nearest exits, refined.
    pub exits: usize,
    /// Of the nearest samples, refined besides.
    pub starts: usize,
    /// A candidate is too like a chosen one within this share of its own distance from the query.
    pub spread: f64,
    /// Whether a descent starts from the query itself, which contacts of deep overlaps make slow.
    pub from_query: bool,
    /// Starts around the query.
    pub scatter: ScatterOptions,
    /// Random steps from the best result.
    pub wander: usize,
    /// Of the descents that are carried on.
    pub refine: RefineOptions,
    /// Whether to look around the query a second time, inside what is then known.
    pub scatter_again: bool,
    /// Of the first steps of every descent.
    pub probe: RefineOptions,
    /// Of the last descent, from the best result.
    pub polish: RefineOptions,
    /// Of the descents that are probed, those carried on.
    pub kept: usize,
    /// What each descent from a sample has to promise, where it is carried to its end before the next one starts; not where several exits are
    /// wanted.
    pub in_turn: Option<Hope>,
    /// Whether exits and samples are tried in the order of distance; else exits come first.
    pub nearest_first: bool,
    /// Of the search for the nearest samples.
    pub care: Care,
    /// Whether descents toward the query in its own coordinates, along contacts of convex shapes or pieces, end where they seem to.
    pub is_smooth: bool,
}

/// Contacts are looked for as far as this \[m\], and known of exits.
pub(super) const MARGIN: f64 = 0.05;
/// And within this share of the farthest motion.
const REACH: f64 = 0.1;

/// The last descent along smooth contacts: to the digits that anyone would look at.
const POLISH: RefineOptions = RefineOptions {
    iterations: 60,
    margin: MARGIN,
    reach: REACH,
    search: ContactSearch::Exact,
    radius: 0.05,
    tolerance: 1e-5,
    hope: Hope::OF_A_PROBE,
};
/// With meshes, from a way out that clears the pieces around them: exact contacts of pairs farther apart than those stand out would take most of the
/// time of a query, and between corners nothing converges to the last digit.
pub(super) const POLISH_MESHES: RefineOptions = RefineOptions { reach: 0.01, tolerance: 1e-3, ..POLISH };
/// Where the metric bends, one answer in twenty stopped between 1e-3 and 1e-2 short with that; with this one in forty does, for a twentieth more time.
const POLISH_MESHES_BENT: RefineOptions = RefineOptions { tolerance: 3e-4, ..POLISH_MESHES };

/// A probed descent is carried on if it is expected to end below this times the best depth so far.
pub const HOPE: f64 = 1.15;

/// Exits that a refined query starts from where descents are not in turn.
const EXITS: usize = 20;
/// Boundary samples that it starts from where there are no exits.
const STARTS: usize = 16;
/// So many exits have to be known for one to be started from: with few, the nearest are far.
const KNOWN_AN_EXIT: usize = 8;
/// The same where the metric bends.
const KNOWN_A_BENT_EXIT: usize = 32;
/// Exits that are known where queries in turn start from them alone. With fewer, samples are started from as if there were none: of 300 to 1,500 exits
/// alone, `shelf-arm` misses twice as many ways out.
pub const RELIED_ON: usize = 1600;
/// The same of queries that look for further exits: a few more misses are worth three times as many exits.
pub const RELIED_ON_TO_SOLVE: usize = 64;
/// Exits that are known where queries in turn start from them alone under the object norm; a run that cannot pay for so many solves sparingly, or not at all.
pub const FEW_EXITS: usize = 8 * KNOWN_A_BENT_EXIT;
/// With fewer exits than these, samples make up for them.
pub const MANY_EXITS: usize = 16_384;
/// One for so many degrees of freedom where there are nearly as many exits.
const DEGREES_A_START: usize = 4;
/// Random steps from the best result where the metric bends what is straight to descents: flat on a face, they stop short of its edge.
const WANDER: usize = 64;
/// Where the metric bends, planes tell less of where exits lead, and more of them are started from.
const MORE_BENT_EXITS_A_DEGREE: usize = 4;
/// With fewer where the metric bends, the query itself and labels all around it do.
const MANY_BENT_EXITS: usize = MANY_EXITS / 4;
/// Directions of them where little is known and starts are probed.
const SCATTERED: usize = 32;
/// Probed descents that are carried on there.
const KEPT: usize = 12;
/// One direction of labels around the query for so many degrees of freedom.
const DEGREES_A_DIRECTION: usize = 2;
/// Up to so many times as many.
const MOST_FOR_EXITS: usize = 8;
/// Nearest samples that are looked at for one that is started from; more where several ways out are compared, which are to differ more.
const POOL_A_START: usize = 6;
const POOL_A_START_OF_MANY: usize = 12;
/// More of them for each further exit that is wanted: each must be found, not only the nearest.
const STARTS_AN_EXIT: usize = 8;
/// Most starts because of exits.
const MOST_STARTS: usize = 96;
/// Most exits that descents in turn start from: those that lead nowhere cost no check.
const MOST_EXITS: usize = 256;

impl Plan {
    /// What the options ask for, of a query at which these pairs collide.
    pub fn of(options: &QueryOptions, ground: &Ground, colliding: &[usize]) -> Self {
        let mut plan = Self::of_effort(options.effort, ground);
        if options.effort == Effort::Nearest {
            // Of stale samples the nearest may all collide, and any of the others be the answer.
            plan.care = if ground.is_stale() { Care::Exact } else { Care::Glance };
            return plan;
        }
        let more = STARTS_AN_EXIT * options.exits.saturating_sub(1).min(MOST_STARTS);
        plan.starts = plan.starts.max((STARTS + more).min(MOST_STARTS));
        plan.exits = plan.exits.max((EXITS + more / 2).min(MOST_STARTS / 2));
        let known = ground.boundary.exits() / if plan.is_smooth { KNOWN_AN_EXIT } else { KNOWN_A_BENT_EXIT };
        // Where several ways out are wanted under a metric that bends, all starts are compared.
        let in_turn = ground.takes_turns() && (plan.is_smooth || options.exits <= 1);
        if options.effort == Effort::Refined && in_turn {
            plan.take_turns(ground, known, more / 2);
        }
        plan.exits = plan.exits.min(known);
        if let Some(change) = ground.change {
            plan.make_up_for(colliding.iter().any(|pair| change.is_new(*pair)), ground);
        }
        if let Some(starts) = options.starts.map(|starts| starts.max(1)) {
            // In proportion, so that few starts mean a short query.
            let usual = plan.exits + plan.starts;
            let share = |n: usize| (n * starts).div_ceil(usual).min(n);
            plan.scatter.directions = share(plan.scatter.directions);
            plan.scatter.wanted = share(plan.scatter.wanted);
            plan.wander = share(plan.wander);
            plan.kept = plan.kept.min(starts);
            (plan.from_query, plan.scatter_again) =
                (plan.from_query && starts > 1, plan.scatter_again && starts >= usual);
            plan.exits = (plan.exits * starts).div_ceil(usual).min(known);
            plan.starts = starts - plan.exits;
        }
        if plan.in_turn.is_some() {
            plan.care = Care::Quick;
        }
        plan
    }

    /// Descents in turn: from as many exits as the width says, `known` at most, from as many samples as make up for those that are missing, and from
    /// `more`.
    fn take_turns(&mut self, ground: &Ground, known: usize, more: usize) {
        let width = ground.width;
        self.kept = 2;
        self.in_turn = Some(match width {
            _ if !self.is_smooth => Hope::IN_TURN_BENT,
            Width::Widest => Hope::IN_TURN_WIDEST,
            _ => Hope::IN_TURN,
        });
        if !ground.relies_on_exits() {
            // The nearest of few exits is often farther than the nearest sample.
            self.nearest_first = true;
            self.starts = (self.starts * width.samples()).min(MOST_STARTS);
            return;
        }
        let degrees = ground.checker.scene().space.nv();
        let least = degrees.div_ceil(DEGREES_A_START);
        let missing = (least * MANY_EXITS).div_ceil(ground.boundary.exits());
        let make_up = missing.min(STARTS).min(MOST_FOR_EXITS * least);
        let along_hulls = ground.checker.all_convex();
        self.exits =
            (width.exits(degrees, along_hulls, self.is_smooth) + (2 * more).min(MOST_STARTS / 2)).min(MOST_EXITS);
        // Samples stand in for exits that are too few for the width, except in queries that only look for further exits.
        let stand_ins = if ground.is_lean { 0 } else { self.exits.saturating_sub(known) };
        self.starts = (if missing > least { make_up } else { 0 } + more + stand_ins).min(MOST_STARTS);
        self.scatter_again = false;
        if self.is_smooth || ground.is_lean {
            // Where a way out is short, so is that to the nearest exit: labels around the query find nothing more, as the joints go.
            self.scatter.directions = 0;
            (self.from_query, self.wander) = (false, 0);
            return;
        }
        self.exits = (self.exits + MORE_BENT_EXITS_A_DEGREE * degrees).min(MOST_EXITS);
        if ground.boundary.exits() >= MANY_BENT_EXITS {
            self.scatter.directions = degrees.div_ceil(DEGREES_A_DIRECTION);
            self.from_query = false;
        }
    }

    /// Where something changed: of what is new, as far as it has come to where the query is, no boundary was sampled. Elsewhere exits lead as near as
    /// they did, but where the metric bends and planes tell less of that, one query in fifty misses then.
    fn make_up_for(&mut self, is_beside_new: bool, ground: &Ground) {
        if self.in_turn.is_none() {
            self.scatter.directions = self.scatter.directions.max(SCATTERED);
            (self.from_query, self.scatter_again, self.kept) = (true, true, self.kept.max(KEPT));
        } else if is_beside_new || !self.is_smooth {
            let directions = ground.checker.scene().space.nv().div_ceil(DEGREES_A_DIRECTION);
            self.scatter.directions = self.scatter.directions.max(directions);
            (self.from_query, self.kept) = (true, self.kept.max(KEPT));
            self.starts = (self.starts + STARTS).min(MOST_STARTS.max(self.starts));
        }
    }

    /// Whether the nearest exit is what the query begins with, so that one search finds it and the starts; else the nearest sample is.
    pub fn begins_at_exits(&self) -> bool {
        self.in_turn.is_some() && self.starts == 0 && self.exits > 0
    }

    /// Nearest samples looked at.
    pub fn pool(&self) -> usize {
        let a_start = if self.in_turn.is_some() { POOL_A_START } else { POOL_A_START_OF_MANY };
        if self.starts + self.exits == 0 { 1 } else { a_start * self.starts.max(1) }
    }

    fn of_effort(effort: Effort, ground: &Ground) -> Self {
        let is_smooth = ground.metric.kind() == MetricSpec::Joint;
        let all_convex = ground.checker.all_convex();
        let degrees = ground.checker.scene().space.nv();
        let refine = RefineOptions {
            iterations: 40,
            margin: MARGIN,
            reach: REACH,
            search: ContactSearch::Coarse,
            radius: 0.5,
            tolerance: 1e-4,
            hope: Hope::OF_A_PROBE,
        };
        let polish = match (all_convex, is_smooth) {
            (true, _) => POLISH,
            (false, true) => POLISH_MESHES,
            (false, false) => POLISH_MESHES_BENT,
        };
        let probe = |iterations| RefineOptions { iterations, ..refine };
        match effort {
            Effort::Nearest => Self {
                exits: 0,
                starts: 0,
                spread: 0.0,
                from_query: false,
                scatter: ScatterOptions { directions: 0, wanted: 0 },
                scatter_again: false,
                wander: 0,
                refine,
                probe: probe(0),
                polish,
                kept: 0,
                is_smooth,
                in_turn: None,
                nearest_first: false,
                care: Care::Exact,
            },
            // Where linearised descents mislead, more of them, from more kinds of starts, are carried on.
            Effort::Refined if !is_smooth => Self {
                exits: EXITS,
                starts: STARTS,
                spread: 0.35,
                // Another metric than that of the coordinates bends what is straight to the descents.
                from_query: ground.metric.kind() != MetricSpec::Joint,
                scatter: ScatterOptions { directions: SCATTERED, wanted: 3 },
                scatter_again: ground.metric.kind() != MetricSpec::Joint,
                probe: probe(5),
                polish,
                kept: KEPT,
                is_smooth,
                in_turn: None,
                nearest_first: false,
                care: Care::Exact,
                wander: WANDER,
                refine,
            },
            Effort::Refined => Self {
                exits: EXITS,
                starts: STARTS,
                spread: 0.4,
                from_query: false,
                scatter: ScatterOptions { directions: degrees.div_ceil(DEGREES_A_DIRECTION), wanted: 3 },
                scatter_again: false,
                probe: probe(3),
                polish,
                kept: 3,
                is_smooth,
                in_turn: None,
                nearest_first: false,
                care: Care::Exact,
                wander: 0,
                refine,
            },
            Effort::Exhaustive => {
                let refine = RefineOptions {
                    iterations: 60,
                    margin: 0.12,
                    reach: REACH,
                    search: if all_convex { ContactSearch::Exact } else { ContactSearch::Coarse },
                    radius: 0.5,
                    tolerance: 1e-6,
                    hope: Hope::OF_A_PROBE,
                };
                Self {
                    exits: 32,
                    starts: 96,
                    spread: 0.15,
                    from_query: true,
                    scatter: ScatterOptions { directions: 200, wanted: 24 },
                    scatter_again: true,
                    wander: 400,
                    refine,
                    probe: RefineOptions { iterations: 3, ..refine },
                    polish: if all_convex { RefineOptions { tolerance: 1e-7, ..POLISH } } else { POLISH_MESHES },
                    kept: 64,
                    is_smooth,
                    in_turn: None,
                    nearest_first: false,
                    care: Care::Exact,
                }
            }
        }
    }
}

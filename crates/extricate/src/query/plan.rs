//! How far a query of an effort searches.

use super::context::{Context, StartsPerDof};
use super::descent::DescentOptions;
use super::options::{Effort, QueryOptions};
use crate::collision::ContactSearch;
use crate::samples::Probes;
use crate::scene::MetricKind;

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Most displacements along separating directions that are looked at, none longer than this
    /// factor times what is known.
    pub most_directions: usize,
    pub direction_factor: f64,
    /// Pairs that choose a direction, one after the other.
    pub most_choices: usize,
    /// Stored samples that are started from, and the most, for as long as they find something
    /// nearer.
    pub starts: usize,
    pub most_starts: usize,
    /// The same of starts around the query.
    pub around: usize,
    pub most_around: usize,
    /// See [`super::search::Round::is_over`].
    pub patience: usize,
    per_dof: StartsPerDof,
    /// Whether these are the starts of a part too, however few joints it has.
    is_fixed: bool,
    /// More of each kind, because of further exits that are wanted.
    more: usize,
    /// See [`super::search::prune::Pruning::factor`].
    pub prune_factor: f64,
    /// Stored samples farther than this times the incumbent are not started from.
    pub farthest_start: f64,
    /// A start is too like a chosen one within this share of its own distance from the query.
    pub spread: f64,
    /// Of the search for the nearest samples.
    pub care: Probes,
    /// Of every descent.
    pub descent: DescentOptions,
    /// Of the last one, from the best result.
    pub polish: DescentOptions,
}

/// Contacts are looked for as far as this \[m\], and known of solved samples.
pub const MARGIN: f64 = 0.05;
/// And within this share of the farthest motion.
const REACH: f64 = 0.1;

/// Most displacements along separating directions that are looked at: few queries have as many.
const MOST_DIRECTIONS: usize = 32;
/// See [`Plan::direction_factor`] and [`Plan::most_choices`]: displacements are of first order.
/// Where samples follow, which know what longer displacements and third choices would find, fewer
/// do.
const DIRECTIONS: (f64, usize) = (1.2, 2);
const UNLEARNED_DIRECTIONS: (f64, usize) = (1.5, 3);
/// The same of an exhaustive query.
const EXHAUSTIVE_DIRECTIONS: usize = 128;
const EXHAUSTIVE_DIRECTION_FACTOR: f64 = 3.0;
/// Fewest stored samples that descents start from.
const LEAST_STARTS: usize = 4;
/// More starts of each kind for every further exit that is wanted: each must be found, not only the
/// nearest.
const STARTS_AN_EXIT: usize = 4;
/// Of a refined query; see [`Plan::prune_factor`]. Planes mislead where exits lead around edges:
/// with 1.5 one query in a hundred more misses, for a sixth fewer checks.
const PRUNE_FACTOR: f64 = 2.0;
/// See [`Plan::farthest_start`].
const FARTHEST_START: f64 = 10.0;
/// See [`Plan::spread`].
const SPREAD: f64 = 0.4;
/// The same of an exhaustive query.
const EXHAUSTIVE_PRUNE_FACTOR: f64 = 4.0;
const EXHAUSTIVE_SPREAD: f64 = 0.15;
/// A kind of start is gone on with for this times the starts until its last success.
const PATIENCE: usize = 2;
/// Starts that are measured to tell how many a scene takes.
const MEASURED_STARTS: usize = 32;
/// The same of starts around the query, before any has succeeded.
const MEASURED_AROUND: usize = 8;
/// Most starts of each kind.
const MOST_STARTS: usize = 128;
/// Stored starts of an exhaustive query, and around it: among 1,000 small boxes half as many miss
/// one exit in fifty more.
const EXHAUSTIVE_STARTS: (usize, usize) = (256, 512);

/// The last descent along smooth contacts: to the digits that anyone would look at.
const POLISH: DescentOptions = DescentOptions {
    iterations: 60,
    margin: MARGIN,
    reach: REACH,
    search: ContactSearch::Exact,
    radius: 0.05,
    tolerance: 1e-5,
};
/// With meshes, from an exit that clears the pieces around them: exact contacts of pairs farther
/// apart than those stand out would take most of the time of a query, and between corners nothing
/// converges to the last digit.
pub const POLISH_MESHES: DescentOptions = DescentOptions { reach: 0.01, tolerance: 1e-3, ..POLISH };
/// Where the metric bends, one answer in twenty stopped between 1e-3 and 1e-2 short with that; with
/// this one in forty does, for a twentieth more time.
const POLISH_MESHES_BENT: DescentOptions = DescentOptions { tolerance: 3e-4, ..POLISH_MESHES };

/// Starts of a query where nothing was learned: with half as many one query in 400 more misses,
/// with twice as many one in 500 fewer, for a third fewer and two thirds more checks.
pub const UNLEARNED: StartsPerDof = StartsPerDof { stored: 0.0, around: 1.0 };

impl Plan {
    /// What the options ask for, of a search over all joints.
    pub fn of(options: &QueryOptions, context: &Context) -> Self {
        let is_flat = context.metric.kind() == MetricKind::Joint;
        let all_convex = context.checker.all_convex();
        let polish = match (all_convex, is_flat) {
            (true, _) => POLISH,
            (false, true) => POLISH_MESHES,
            (false, false) => POLISH_MESHES_BENT,
        };
        let is_learned = !context.samples().is_empty();
        let (direction_factor, most_choices) = if is_learned { DIRECTIONS } else { UNLEARNED_DIRECTIONS };
        let more = STARTS_AN_EXIT * options.wanted().saturating_sub(1).min(MOST_STARTS / STARTS_AN_EXIT);
        let plan = Self {
            most_directions: MOST_DIRECTIONS,
            direction_factor,
            most_choices,
            per_dof: context.learned.starts,
            more,
            starts: 0,
            most_starts: MOST_STARTS.max(more),
            around: 0,
            most_around: MOST_STARTS.max(more),
            patience: PATIENCE,
            is_fixed: false,
            prune_factor: PRUNE_FACTOR,
            farthest_start: FARTHEST_START,
            spread: SPREAD,
            care: Probes::Quick,
            descent: DescentOptions {
                iterations: 40,
                margin: MARGIN,
                reach: REACH,
                search: ContactSearch::Proposal,
                radius: 0.45,
                tolerance: 1e-4,
            },
            polish,
        }
        .over(context.checker.scene().space.nv());
        match (options.effort, options.wanted_starts()) {
            // Of stale samples the nearest may all collide, and any of the others be the answer.
            (Effort::Nearest, _) if context.scene_changed() => Self { starts: 0, care: Probes::Exact, ..plan },
            (Effort::Nearest, _) => Self { starts: 0, care: Probes::Glance, ..plan },
            (_, Some(count)) => {
                let (stored, around) = (count.clamp(1, plan.starts.max(1)), count.saturating_sub(plan.starts));
                // The first of them is the query itself.
                let plan = Self { most_directions: plan.most_directions.min(count + 1), ..plan };
                Self { starts: stored, most_starts: stored, around, most_around: around, is_fixed: true, ..plan }
            }
            (Effort::Refined | Effort::Exhaustive | Effort::Proved, None) => plan,
        }
    }

    /// The same of a search over so many degrees of freedom.
    pub fn over(self, degrees: usize) -> Self {
        if self.is_fixed {
            return self;
        }
        let scaled = |per_dof: f64| (per_dof * degrees as f64).round() as usize;
        let starts = (scaled(self.per_dof.stored).max(LEAST_STARTS) + self.more).min(self.most_starts);
        let around = (scaled(self.per_dof.around) + self.more).min(self.most_around);
        Self { starts, around, ..self }
    }

    /// What tells how many starts a scene takes: many, and in the order of a query.
    pub fn to_calibrate(self) -> Self {
        Self { starts: MEASURED_STARTS, around: MEASURED_AROUND, patience: 2 * PATIENCE, is_fixed: true, ..self }
    }

    /// The same, as far as an exhaustive query goes.
    pub fn exhaustive(self, context: &Context, options: &QueryOptions) -> Self {
        let (starts, around) = options.wanted_starts().map_or(EXHAUSTIVE_STARTS, |n| (n.div_ceil(2), n / 2));
        let all_convex = context.checker.all_convex();
        let descent = DescentOptions {
            iterations: 60,
            margin: 0.12,
            search: if all_convex { ContactSearch::Exact } else { ContactSearch::Proposal },
            tolerance: 1e-6,
            ..self.descent
        };
        let degrees = context.checker.scene().space.nv() as f64;
        Self {
            per_dof: StartsPerDof { stored: starts as f64 / degrees, around: around as f64 / degrees },
            more: 0,
            most_directions: EXHAUSTIVE_DIRECTIONS,
            direction_factor: EXHAUSTIVE_DIRECTION_FACTOR,
            most_choices: UNLEARNED_DIRECTIONS.1,
            starts,
            most_starts: starts,
            around,
            most_around: around,
            is_fixed: false,
            prune_factor: EXHAUSTIVE_PRUNE_FACTOR,
            farthest_start: f64::INFINITY,
            spread: EXHAUSTIVE_SPREAD,
            care: Probes::Exact,
            descent,
            polish: if all_convex { DescentOptions { tolerance: 1e-7, ..POLISH } } else { POLISH_MESHES },
            ..self
        }
    }
}

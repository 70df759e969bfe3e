//! How far the search of an effort goes.

use super::context::Context;
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
    /// Stored samples that are started from.
    pub stored: usize,
    /// A stored sample is too like a chosen one within this share of its own distance from the
    /// query.
    pub spread: f64,
    /// How carefully the nearest stored samples are searched for.
    pub care: Probes,
    /// Starts around the query, and the most, for as long as they find something nearer.
    pub around: usize,
    pub most_around: usize,
    around_per_dof: f64,
    /// More starts around the query, because of further exits that are wanted.
    more: usize,
    /// Whether the first exit ends the search.
    pub takes_first: bool,
    /// See [`super::descent::prune::Pruning::factor`].
    pub prune_factor: f64,
    /// For every descent.
    pub descent: DescentOptions,
    /// For the last one, from the nearest exit.
    pub polish: DescentOptions,
}

/// Contacts are looked for as far as this \[m\], and known of solved samples.
pub const MARGIN: f64 = 0.05;
/// And within this share of the farthest motion.
const REACH: f64 = 0.1;
/// Starts around the query for each degree of freedom: with one and a half times as many one query
/// in 700 fewer misses, for a quarter more checks.
const AROUND_PER_DOF: f64 = 1.0;
/// A scene of fewer degrees of freedom has as many starts as one of these: for a planar arm among
/// shelves and a box in a room half of the misses go, for a third more checks there.
const FEWEST_DEGREES: usize = 6;
/// The same of a quick query.
const QUICK_AROUND_PER_DOF: f64 = 0.1;
/// Most starts around the query.
const MOST_AROUND: usize = 128;
/// More starts for every further exit that is wanted: each must be found, not only the nearest.
const STARTS_AN_EXIT: usize = 4;
/// Stored samples and starts around the query of an exhaustive query: among 1,000 small boxes half
/// as many miss one exit in fifty more.
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

impl Plan {
    /// What the options ask for, of a search over all joints.
    pub fn of(options: &QueryOptions, context: &Context) -> Self {
        let is_flat = context.metric.kind() == MetricKind::Joint;
        let polish = match (context.checker.all_convex(), is_flat) {
            (true, _) => POLISH,
            (false, true) => POLISH_MESHES,
            (false, false) => POLISH_MESHES_BENT,
        };
        let around_per_dof = if options.effort == Effort::Quick { QUICK_AROUND_PER_DOF } else { AROUND_PER_DOF };
        let more = STARTS_AN_EXIT * options.wanted().saturating_sub(1).min(MOST_AROUND / STARTS_AN_EXIT);
        let plan = Self {
            most_directions: 32,
            direction_factor: 1.5,
            most_choices: 3,
            stored: 4,
            spread: 0.4,
            care: Probes::Quick,
            around: 0,
            most_around: MOST_AROUND.max(more),
            around_per_dof,
            more,
            takes_first: options.effort == Effort::Nearest,
            prune_factor: 2.0,
            descent: DescentOptions {
                iterations: 40,
                margin: MARGIN,
                reach: REACH,
                search: ContactSearch::Proposal,
                radius: 0.45,
                tolerance: 1e-4,
            },
            polish,
        };
        let plan = plan.over(context.checker.scene().space.nv().max(FEWEST_DEGREES));
        match options.starts {
            // The first direction is the query itself.
            Some(count) => {
                let (most_directions, around) =
                    (plan.most_directions.min(count + 1), count.saturating_sub(plan.stored));
                Self { most_directions, most_around: around, ..plan.with_around(around, context) }
            }
            None => plan,
        }
    }

    /// The same of a search over so many degrees of freedom.
    pub fn over(self, degrees: usize) -> Self {
        let scaled = (self.around_per_dof * degrees as f64).round() as usize + self.more;
        Self { around: scaled.min(self.most_around), ..self }
    }

    /// The same with so many starts around the query in all joints, and as large a share in some.
    fn with_around(self, around: usize, context: &Context) -> Self {
        let around_per_dof = around as f64 / context.checker.scene().space.nv() as f64;
        Self { around, around_per_dof, more: 0, ..self }
    }

    /// The same, as far as an exhaustive query goes.
    pub fn exhaustive(self, context: &Context, options: &QueryOptions) -> Self {
        let (stored, around) = options.starts.map_or(EXHAUSTIVE_STARTS, |n| (n.div_ceil(2), n / 2));
        let all_convex = context.checker.all_convex();
        let descent = DescentOptions {
            iterations: 60,
            margin: 0.12,
            search: if all_convex { ContactSearch::Exact } else { ContactSearch::Proposal },
            tolerance: 1e-6,
            ..self.descent
        };
        Self {
            most_directions: 128,
            direction_factor: 3.0,
            stored,
            spread: 0.15,
            care: Probes::Exact,
            most_around: around,
            prune_factor: 4.0,
            descent,
            polish: if all_convex { DescentOptions { tolerance: 1e-7, ..POLISH } } else { POLISH_MESHES },
            ..self.with_around(around, context)
        }
    }
}

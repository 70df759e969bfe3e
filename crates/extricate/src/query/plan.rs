//! Plans of searches: how far the search of an effort goes.

use super::context::Context;
use super::descent::DescentOptions;
use super::options::{Effort, QueryOptions};
use crate::collision::ContactSearch;
use crate::samples::Probes;
use crate::scene::MetricKind;

/// Limits of a search.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Most displacements along separating directions that are visited, none longer than
    /// `direction_factor` times the nearest depth.
    pub most_directions: usize,
    pub direction_factor: f64,
    /// Most pairs that choose a direction, one after another.
    pub most_choices: usize,
    /// Number of stored samples that descents start from.
    pub stored: usize,
    /// A stored sample repeats a chosen one within this share of its own distance from the query.
    pub spread: f64,
    pub care: Probes,
    /// Configurations that are drawn and moved to where links are kept.
    pub kept_draws: usize,
    /// Starts around the query, and the most after successes and starts that got stuck.
    pub around: usize,
    pub most_around: usize,
    around_per_dof: f64,
    /// Starts around the query that are added for further wanted exits.
    more: usize,
    /// Whether the first exit ends the search; it is then not polished.
    pub takes_first: bool,
    /// Multiple of the depth that prunes, see [`super::descent::prune::Pruning::factor`].
    pub prune_factor: f64,
    pub descent: DescentOptions,
    /// Options of the last descent, from the nearest exit.
    pub polish: DescentOptions,
}

/// Contacts are searched for up to this distance beyond the clearance \[m\], and stored that far
/// with solved samples.
pub const MARGIN: f64 = 0.05;
/// Contacts farther than this share of the farthest motion are not searched for either.
const REACH_SHARE: f64 = 0.1;
/// Starts around the query for each degree of freedom. With 1.5, one query in 700 fewer misses, for
/// a quarter more checks.
const AROUND_PER_DOF: f64 = 1.0;
/// Scenes with fewer degrees of freedom get as many starts as with this many. For a planar arm
/// among shelves and a box in a room, half of the misses go, for a third more checks there.
const MIN_DEGREES: usize = 6;
/// Starts around a quick query for each degree of freedom.
const QUICK_AROUND_PER_DOF: f64 = 0.1;
/// Configurations that are drawn to keep links: with half as many, an arm whose tool stays finds a
/// solution in 144 of 150 queries in place of 148. The second number is that of an exhaustive
/// query.
const KEPT_DRAWS: usize = 100;
const EXHAUSTIVE_KEPT_DRAWS: usize = 1000;
/// Most starts around the query, unless it is exhaustive or its options set their number.
const MAX_AROUND: usize = 128;
/// Starts that are added for every further wanted exit: each must be found, not only the nearest.
const STARTS_PER_EXIT: usize = 4;
/// Stored samples and starts around the query of an exhaustive query. Among 1,000 small boxes, one
/// exit in fifty more is missed with half as many.
const EXHAUSTIVE_STARTS: (usize, usize) = (256, 512);

/// The last descent along smooth contacts, to all digits that matter to a reader.
const POLISH: DescentOptions = DescentOptions {
    iterations: 60,
    margin: MARGIN,
    reach: REACH_SHARE,
    search: ContactSearch::Exact,
    radius: 0.05,
    tolerance: 1e-5,
};
/// The last descent with meshes, from an exit that clears the pieces around them. Exact contacts of
/// pairs farther apart than pieces stand out would take most of the time of a query. Between
/// corners nothing converges to the last digit.
pub const POLISH_MESHES: DescentOptions = DescentOptions { reach: 0.01, tolerance: 1e-3, ..POLISH };
/// The last descent with meshes under the metrics of bodies. With a tolerance of 1e-3, one answer
/// in twenty stopped 1e-3 to 1e-2 short; now one in forty does, for a twentieth more time.
const POLISH_MESHES_BENT: DescentOptions = DescentOptions { tolerance: 3e-4, ..POLISH_MESHES };

impl Plan {
    /// Returns the plan of a search over all joints with these options.
    pub fn of(options: &QueryOptions, context: &Context) -> Self {
        let is_flat = context.metric.kind() == MetricKind::Joint;
        let polish = match (context.checker.all_convex(), is_flat) {
            (true, _) => POLISH,
            (false, true) => POLISH_MESHES,
            (false, false) => POLISH_MESHES_BENT,
        };
        let around_per_dof = if options.effort == Effort::Quick { QUICK_AROUND_PER_DOF } else { AROUND_PER_DOF };
        let more = STARTS_PER_EXIT * options.wanted().saturating_sub(1).min(MAX_AROUND / STARTS_PER_EXIT);
        let plan = Self {
            most_directions: 32,
            direction_factor: 1.5,
            most_choices: 3,
            stored: 4,
            spread: 0.4,
            care: Probes::Quick,
            kept_draws: KEPT_DRAWS,
            around: 0,
            most_around: MAX_AROUND.max(more),
            around_per_dof,
            more,
            takes_first: options.effort == Effort::Nearest,
            prune_factor: 2.0,
            descent: DescentOptions {
                iterations: 40,
                margin: MARGIN,
                reach: REACH_SHARE,
                search: ContactSearch::Proposal,
                radius: 0.45,
                tolerance: 1e-4,
            },
            polish,
        };
        let plan = plan.over(context.checker.scene().space.nv().max(MIN_DEGREES));
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

    /// Scales the plan to a search over so many degrees of freedom.
    pub fn over(self, degrees: usize) -> Self {
        let scaled = (self.around_per_dof * degrees as f64).round() as usize + self.more;
        Self { around: scaled.min(self.most_around), ..self }
    }

    /// Sets the number of starts around the query in all joints; fewer joints get a like share.
    fn with_around(self, around: usize, context: &Context) -> Self {
        let around_per_dof = around as f64 / context.checker.scene().space.nv() as f64;
        Self { around, around_per_dof, more: 0, ..self }
    }

    /// Extends the plan to that of an exhaustive query.
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
            kept_draws: EXHAUSTIVE_KEPT_DRAWS,
            most_around: around,
            prune_factor: 4.0,
            descent,
            polish: if all_convex { DescentOptions { tolerance: 1e-7, ..POLISH } } else { POLISH_MESHES },
            ..self.with_around(around, context)
        }
    }
}

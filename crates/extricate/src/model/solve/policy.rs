//! How a run solves, which depends on what it may spend.

use crate::scene::MetricKind;

/// Share of the budget after which the boundary is not traced further, and colliding configurations
/// are solved.
pub const TRACED_BY: f64 = 0.3;
/// Checks that a query is not begun without: with fewer it is not carried to its end.
pub const LEAST_CHECKS: usize = 200;
/// Exits that queries rely on from then on.
const FEW_EXITS: usize = 256;
/// Labels from which on it pays to solve sparingly. Exploring and training leave half of them,
/// which buy a hundred exits.
const LEAST_LABELS: usize = 10_000;

/// How a run solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solving {
    /// The nearest exit of every configuration, as a query finds it.
    Thorough,
    /// From few starts, and every other exit that is met is an exit too. Of few exits more are
    /// worth more than nearer ones; of many they are not: with 160,000 labels `shelf-arm` would
    /// miss twice as many exits.
    Sparing,
}

impl Solving {
    /// How a run of so many labels solves; `None` where the labels are better spent on the
    /// boundary. Where the metric bends, queries rely on exits only once there are [`FEW_EXITS`],
    /// which such runs do not come to.
    pub fn of(labels: usize, metric: MetricKind) -> Option<Self> {
        if (1.0 - TRACED_BY) * labels as f64 >= (FEW_EXITS * LEAST_CHECKS) as f64 {
            return Some(Self::Thorough);
        }
        (metric == MetricKind::Joint && labels >= LEAST_LABELS).then_some(Self::Sparing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_budgets_solve_sparingly_where_queries_start_from_few_exits() {
        use MetricKind::{Joint, MaxDisplacement, ObjectNorm};
        for (labels, metric, solving) in [
            (9_999, Joint, None),
            (10_000, Joint, Some(Solving::Sparing)),
            (73_144, Joint, Some(Solving::Thorough)),
            (73_000, ObjectNorm, None),
            (73_144, MaxDisplacement, Some(Solving::Thorough)),
        ] {
            assert_eq!(Solving::of(labels, metric), solving, "{labels} {metric:?}");
        }
    }
}

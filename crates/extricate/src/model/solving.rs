//! How a run solves, which depends on what it may spend.

use super::learner::TRACED_BY;
use super::solve::LEAST_CHECKS;
const FEW_EXITS: usize = 256;
use crate::scene::MetricSpec;

/// Labels from which on it pays to solve sparingly. Exploring and training leave half of them, which buy a hundred exits.
const LEAST_LABELS: usize = 10_000;

/// How a run solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solving {
    /// The nearest way out of every configuration, as a query finds it.
    Thorough,
    /// From few starts, and every other way out that is met is an exit too. Of few exits more are worth more than nearer ones; of many they are not:
    /// with 160,000 labels `shelf-arm` would miss twice as many ways out.
    Sparing,
}

impl Solving {
    /// How a run of so many labels solves; `None` where the labels are better spent on the boundary. Where the metric bends, queries rely on exits
    /// only once there are [`FEW_EXITS`], which such runs do not come to.
    pub fn of(labels: usize, metric: MetricSpec) -> Option<Self> {
        if (1.0 - TRACED_BY) * labels as f64 >= (FEW_EXITS * LEAST_CHECKS) as f64 {
            return Some(Self::Thorough);
        }
        (metric == MetricSpec::Joint && labels >= LEAST_LABELS).then_some(Self::Sparing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_budgets_solve_sparingly_where_queries_start_from_few_exits() {
        use MetricSpec::{Joint, MaxDisplacement, ObjectNorm};
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

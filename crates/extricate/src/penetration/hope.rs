//! How much a descent has to promise to be carried on.

use super::width::Width;

/// A descent is given up where it is expected to end farther than this times its ceiling.
#[derive(Debug, Clone, Copy)]
pub struct Hope {
    /// By the planes that are known of its start; they may be far off where they lead along an edge.
    known: f64,
    /// After one or two steps.
    early: f64,
    /// Later.
    late: f64,
    /// What is expected as near to the ceiling as this, as a share of it, is on its way to where the ceiling is from.
    alike: f64,
}

impl Hope {
    /// Of a descent that is compared with others before any is carried to its end.
    pub const OF_A_PROBE: Self = Self { known: 1.5, early: 1.1, late: 1.02, alike: 0.0 };
    /// Of one in turn: it has to beat what was carried to its end.
    pub const IN_TURN: Self = Self { known: 1.5, early: 1.02, late: 1.0, alike: 0.002 };
    /// Of one in turn, where starts are farther from where they lead.
    pub const IN_TURN_FROM_AFAR: Self = Self { early: 1.1, late: 1.02, ..Self::IN_TURN };

    /// The same, where queries search as widely as `width`: planes mislead where obstacles have edges that ways out lead around.
    pub const fn at(self, width: Width) -> Self {
        match width {
            Width::Narrow => self,
            Width::Usual => Self { known: 3.0, ..self },
            Width::Wide | Width::Widest => Self { known: 3.0, early: 2.0, late: 1.02, ..self },
        }
    }

    /// What holds in an iteration, of which the first is 0; `by_planes` where all that is known are the planes of the start.
    pub fn after(&self, iteration: usize, by_planes: bool) -> f64 {
        match iteration {
            _ if by_planes => self.known,
            0..3 => self.early,
            _ => self.late,
        }
    }

    /// Whether what is expected after a look is likely the way out that is known.
    pub fn is_alike(&self, expected: f64, ceiling: f64) -> bool {
        (expected - ceiling).abs() < self.alike * ceiling
    }
}

//! How much a descent has to promise to be carried on.

/// A descent is given up where it is expected to end farther than this times its ceiling.
#[derive(Debug, Clone, Copy)]
pub struct Hope {
    /// By the planes that are known of its start; they may be far off where they lead along an edge.
    known: f64,
    /// After one or two steps from an exit.
    early: f64,
    /// The same from elsewhere.
    early_from_afar: f64,
    /// Later.
    late: f64,
    /// What is expected as near to the ceiling as this, as a share of it, is on its way to where the ceiling is from.
    alike: f64,
    /// Of the foot of the query on the planes that are known of its start, with no trust region around it.
    foot: f64,
}

impl Hope {
    /// Of a descent that is compared with others before any is carried to its end.
    pub const OF_A_PROBE: Self =
        Self { known: 1.5, early: 1.1, early_from_afar: 1.1, late: 1.02, alike: 0.0, foot: f64::INFINITY };
    /// Of one in turn: it has to beat what was carried to its end. Planes mislead where obstacles have edges that ways out lead around, and so do the
    /// first steps, so that it is the foot on them that tells which exits lead nowhere.
    pub const IN_TURN: Self =
        Self { known: f64::INFINITY, early: 2.0, early_from_afar: 1.1, late: 1.02, alike: 0.002, foot: 1.2 };

    /// What holds in an iteration, of which the first is 0, of a descent from an exit with known planes or not; `by_planes` where they are all that is known.
    pub fn after(&self, iteration: usize, is_exit: bool, by_planes: bool) -> f64 {
        match iteration {
            _ if by_planes => self.known,
            0..3 if is_exit => self.early,
            0..3 => self.early_from_afar,
            _ => self.late,
        }
    }

    /// How far the foot may be, as a multiple of the ceiling; `None` where it is not asked for.
    pub fn of_foot(&self) -> Option<f64> {
        Some(self.foot).filter(|foot| foot.is_finite())
    }

    /// Whether what is expected after a look is likely the way out that is known.
    pub fn is_alike(&self, expected: f64, ceiling: f64) -> bool {
        (expected - ceiling).abs() < self.alike * ceiling
    }
}

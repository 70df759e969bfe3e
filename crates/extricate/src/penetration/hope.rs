//! How much a descent has to promise to be carried on.

/// A descent is given up where it is expected to end farther than this times its ceiling.
#[derive(Debug, Clone, Copy)]
pub struct Hope {
    /// By the planes that are known of its start.
    by_planes: ByPlanes,
    /// After one or two steps from an exit.
    early: f64,
    /// The same from elsewhere.
    early_from_afar: f64,
    /// Later.
    late: f64,
    /// What is expected as near to the ceiling as this, as a share of it, is on its way to where the ceiling is from.
    alike: f64,
}

/// How known planes are followed; they may be far off where they lead along an edge.
#[derive(Debug, Clone, Copy)]
enum ByPlanes {
    /// Within the trust region of the first step.
    AStep(f64),
    /// To the foot of the query on them.
    ToTheFoot(f64),
}

impl Hope {
    /// Of a descent that is compared with others before any is carried to its end.
    pub const OF_A_PROBE: Self =
        Self { by_planes: ByPlanes::AStep(1.5), early: 1.1, early_from_afar: 1.1, late: 1.02, alike: 0.0 };
    /// Of one in turn: it has to beat what was carried to its end. Planes mislead where obstacles have edges that ways out lead around, and so do the
    /// first steps, so that it is the foot on them that tells which exits lead nowhere.
    pub const IN_TURN: Self =
        Self { by_planes: ByPlanes::ToTheFoot(1.2), early: 2.0, early_from_afar: 1.1, late: 1.02, alike: 0.002 };

    /// The same for the widest queries: of two arms one query in a hundred finds its nearest way out from an exit whose foot is 1.2 to 3.6 times as far.
    pub const IN_TURN_WIDEST: Self = Self { by_planes: ByPlanes::ToTheFoot(3.6), ..Self::IN_TURN };

    /// The same under a metric that bends what is straight to the descents: there planes tell less of what is far.
    pub const IN_TURN_BENT: Self = Self { by_planes: ByPlanes::ToTheFoot(2.0), ..Self::IN_TURN };

    /// What holds in an iteration, of which the first is 0, of a descent from an exit with known planes or not; `has_planes_alone` where nothing
    /// else is known yet.
    pub fn after(&self, iteration: usize, is_exit: bool, has_planes_alone: bool) -> f64 {
        match (iteration, self.by_planes) {
            (_, ByPlanes::AStep(hope)) if has_planes_alone => hope,
            (_, ByPlanes::ToTheFoot(_)) if has_planes_alone => f64::INFINITY,
            (0..3, _) if is_exit => self.early,
            (0..3, _) => self.early_from_afar,
            _ => self.late,
        }
    }

    /// How far the foot may be, as a multiple of the ceiling; `None` where it is not asked for.
    pub fn of_foot(&self) -> Option<f64> {
        match self.by_planes {
            ByPlanes::AStep(_) => None,
            ByPlanes::ToTheFoot(hope) => Some(hope),
        }
    }

    /// Whether it is carried to its end before the next one starts.
    pub fn is_in_turn(&self) -> bool {
        self.of_foot().is_some()
    }

    /// Whether what is expected after a look is likely the way out that is known.
    pub fn is_alike(&self, expected: f64, ceiling: f64) -> bool {
        (expected - ceiling).abs() < self.alike * ceiling
    }
}

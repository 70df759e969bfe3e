//! What a query stands on.

use super::inner_balls::InnerBalls;
use crate::collision::Checker;
use crate::metric::Metric;
use crate::samples::SampleSet;
use crate::scene::PairId;

/// What a query stands on, borrowed from what is prepared of a scene, and from a model if there
/// is one.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The exact checker.
    pub checker: &'a Checker,
    /// The scene's metric.
    pub metric: &'a Metric,
    /// For the lower bound.
    pub balls: &'a InnerBalls,
    /// What a model has stored.
    pub stored: Option<Stored<'a>>,
    /// Least distance \[m\] of a free pair.
    pub clearance: f64,
    /// A typical length of the configuration space in metric units.
    pub scale: f64,
    /// Of every tangent coordinate, whether it stays where the query has it; empty where none does.
    pub locked: &'a [bool],
    /// Pairs that are to stay in touch.
    pub held: Held<'a>,
}

/// Checked pairs that are to stay as near as they touch, and not only apart.
#[derive(Debug, Clone, Copy, Default)]
pub struct Held<'a> {
    /// Which.
    pub pairs: &'a [PairId],
    /// The most that their nearest contact may be apart \[m\], above the clearance.
    pub most: f64,
}

/// Boundary samples that were stored: descents start from some of them.
#[derive(Clone, Copy)]
pub struct Stored<'a> {
    /// Each was free in the scene that was learned.
    pub samples: &'a SampleSet,
    /// Whether the contact planes of samples hold for each checked pair; `None` if all do and every
    /// sample is free here. An empty list says that none do.
    pub holding: Option<&'a [bool]>,
}

impl Stored<'_> {
    /// Whether the contact planes of samples hold for a pair.
    pub fn holds(&self, pair: PairId) -> bool {
        self.holding.is_none_or(|holding| holding.get(pair.index()) == Some(&true))
    }
}

impl<'a> Context<'a> {
    /// The one way to make it.
    pub fn new(checker: &'a Checker, metric: &'a Metric, balls: &'a InnerBalls, stored: Option<Stored<'a>>) -> Self {
        let (clearance, scale) = (checker.base_clearance(), metric.diameter());
        Self { checker, metric, balls, stored, clearance, scale, locked: &[], held: Held::default() }
    }

    /// The same, with samples that may collide and whose planes do not hold.
    pub fn elsewhere(self) -> Self {
        let stored = self.stored.map(|stored| Stored { holding: Some(&[]), ..stored });
        Self { stored, ..self }
    }

    /// Whether a tangent coordinate stays where the query has it.
    pub fn is_locked(&self, v: usize) -> bool {
        self.locked.get(v).is_some_and(|is_locked| *is_locked)
    }

    /// Brings the coordinates that stay to where `rest` has them.
    pub fn hold(&self, rest: &[f64], config: &mut [f64]) {
        if self.locked.is_empty() {
            return;
        }
        for factor in self.checker.scene().space.factors().iter().filter(|factor| self.locked[factor.v]) {
            config[factor.coordinates()].copy_from_slice(&rest[factor.coordinates()]);
        }
    }
}

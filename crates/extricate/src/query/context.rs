//! The shared data that a query reads: checker, metric, balls, stored samples and constraints.

use super::inner_balls::InnerBalls;
use super::keep::LinkConstraint;
use crate::collision::Checker;
use crate::metric::Metric;
use crate::samples::SampleSet;
use crate::scene::PairId;

/// Shared data of a query, borrowed from a prepared scene, and from a model if there is one.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Exact checker of the scene.
    pub checker: &'a Checker,
    /// Metric of the scene.
    pub metric: &'a Metric,
    /// Balls inside bodies, for the lower bound.
    pub balls: &'a InnerBalls,
    /// Stored samples of a model.
    pub stored: Option<Stored<'a>>,
    /// Least distance \[m\] of a free pair.
    pub clearance: f64,
    /// A typical length of the configuration space in metric units.
    pub scale: f64,
    /// Whether each tangent coordinate keeps its value of the query; empty if none does.
    pub locked: &'a [bool],
    /// Links that keep their places.
    pub kept: &'a [LinkConstraint],
    /// Pairs that have to stay in touch.
    pub touching: TouchingPairs<'a>,
}

/// Checked pairs that have to stay in touch, and not only apart.
#[derive(Debug, Clone, Copy, Default)]
pub struct TouchingPairs<'a> {
    /// The pairs that have to stay in touch.
    pub pairs: &'a [PairId],
    /// Largest distance of their nearest contact \[m\]; it exceeds the clearance.
    pub most: f64,
    /// Distance \[m\] that descents aim at, at most the largest.
    pub aim: f64,
    /// Whether a configuration in which one of them is farther apart is not free.
    pub are_required: bool,
}

/// Stored boundary samples, from some of which descents start.
#[derive(Clone, Copy)]
pub struct Stored<'a> {
    /// The samples; each was free in the scene that was learned.
    pub samples: &'a SampleSet,
    /// Whether contact planes hold for each checked pair. `None` means that all hold and every
    /// sample is free here; an empty list means that none holds.
    pub holding: Option<&'a [bool]>,
}

impl Stored<'_> {
    /// Whether contact planes of samples hold for a pair.
    pub fn holds(&self, pair: PairId) -> bool {
        self.holding.is_none_or(|holding| holding.get(pair.index()) == Some(&true))
    }
}

impl<'a> Context<'a> {
    /// Creates a context without locked coordinates or held pairs.
    pub fn new(checker: &'a Checker, metric: &'a Metric, balls: &'a InnerBalls, stored: Option<Stored<'a>>) -> Self {
        let (clearance, scale) = (checker.base_clearance(), metric.diameter());
        let touching = TouchingPairs::default();
        Self { checker, metric, balls, stored, clearance, scale, locked: &[], kept: &[], touching }
    }

    /// Makes links keep their places. Stored samples do not keep them.
    pub fn keeping<'b>(self, kept: &'b [LinkConstraint]) -> Context<'b>
    where
        'a: 'b,
    {
        if kept.is_empty() { self } else { Context { kept, ..self }.elsewhere() }
    }

    /// Marks samples as possibly colliding, with contact planes that do not hold.
    pub fn elsewhere(self) -> Self {
        let stored = self.stored.map(|stored| Stored { holding: Some(&[]), ..stored });
        Self { stored, ..self }
    }

    /// Whether some joints or links keep their places of the query, or pairs have to touch.
    pub fn is_constrained(&self) -> bool {
        !self.locked.is_empty() || self.is_held()
    }

    /// Whether links have to keep their places, or pairs to touch.
    pub fn is_held(&self) -> bool {
        !self.kept.is_empty() || self.touching.are_required
    }

    /// Whether a tangent coordinate keeps its value of the query.
    pub fn is_locked(&self, v: usize) -> bool {
        self.locked.get(v).is_some_and(|is_locked| *is_locked)
    }

    /// Resets the locked coordinates of `config` to their values of `rest`.
    pub fn hold(&self, rest: &[f64], config: &mut [f64]) {
        if self.locked.is_empty() {
            return;
        }
        for factor in self.checker.scene().space.factors().iter().filter(|factor| self.locked[factor.v]) {
            config[factor.coordinates()].copy_from_slice(&rest[factor.coordinates()]);
        }
    }
}

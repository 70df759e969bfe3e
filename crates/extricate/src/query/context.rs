//! What a query stands on.

use super::bound::inner_spheres::InnerBalls;
use super::report::coverage::Coverage;
use super::worlds::delta::Change;
use crate::collision::Checker;
use crate::metric::Metric;
use crate::samples::SampleSet;
use crate::scene::PairId;
use serde::{Deserialize, Serialize};

/// What a query stands on; borrowed from a model, and from the changed scene where it is asked in
/// one.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The exact checker.
    pub checker: &'a Checker,
    /// The scene's metric.
    pub metric: &'a Metric,
    /// For the lower bound.
    pub balls: &'a InnerBalls,
    /// What was learned.
    pub learned: Learned<'a>,
    /// Set where that was in another scene: samples may collide, and be far from any boundary.
    pub change: Option<&'a Change>,
    /// What queries stand on where samples are of no use: in a changed scene those that meet what
    /// came, and all whose samples turn out to collide.
    pub unlearned: Option<Learned<'a>>,
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

/// What is known of a scene by learning it.
#[derive(Clone, Copy)]
pub struct Learned<'a> {
    /// Verified boundary samples; at least one.
    pub boundary: &'a SampleSet,
    /// What the distance to the nearest sample is compared with.
    pub coverage: &'a Coverage,
    /// How many starts a refined query takes.
    pub starts: StartsPerDof,
}

/// Starts of a refined query for each degree of freedom that it searches over, whatever they find.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StartsPerDof {
    /// Of the nearest stored samples.
    pub stored: f64,
    /// Of configurations around the query.
    pub around: f64,
}

impl<'a> Context<'a> {
    /// The one way to make it.
    pub fn new(
        (checker, metric, balls): (&'a Checker, &'a Metric, &'a InnerBalls),
        learned: Learned<'a>,
        change: Option<&'a Change>,
    ) -> Self {
        let (clearance, scale) = (checker.base_clearance(), metric.diameter());
        Self {
            checker,
            metric,
            balls,
            learned,
            change,
            unlearned: None,
            clearance,
            scale,
            locked: &[],
            held: Held::default(),
        }
    }

    /// The same without samples, for a query in a changed scene at which a new one of these pairs
    /// collides.
    pub fn unlearned_for(&self, colliding: &[PairId]) -> Option<Self> {
        let change = self.change?;
        let meets_new = colliding.iter().any(|pair| change.is_new(*pair));
        if meets_new { self.without_samples() } else { None }
    }

    /// The same without samples; `None` if there are none.
    pub fn without_samples(&self) -> Option<Self> {
        let learned = self.unlearned.filter(|_| !self.samples().is_empty())?;
        Some(Self { learned, change: None, unlearned: None, ..*self })
    }

    /// Whether no sample is what a query begins with: there is none, or nearly every one has joints
    /// elsewhere that are to stay.
    pub fn begins_without_samples(&self) -> bool {
        self.samples().is_empty() || !self.locked.is_empty()
    }

    /// Whether a tangent coordinate stays where the query has it.
    pub fn is_locked(&self, v: usize) -> bool {
        self.locked.get(v).is_some_and(|is_locked| *is_locked)
    }

    /// Brings the coordinates that stay to where `q` has them.
    pub fn hold(&self, q: &[f64], config: &mut [f64]) {
        if self.locked.is_empty() {
            return;
        }
        for factor in self.checker.scene().space.factors().iter().filter(|factor| self.locked[factor.v]) {
            config[factor.coordinates()].copy_from_slice(&q[factor.coordinates()]);
        }
    }

    /// Whether samples have to be verified anew.
    pub fn scene_changed(&self) -> bool {
        self.change.is_some()
    }

    /// The stored samples.
    pub fn samples(&self) -> &'a SampleSet {
        self.learned.boundary
    }
}

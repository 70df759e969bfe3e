//! What a query is asked to do.

use serde::Serialize;

use super::termination::Termination;

/// How hard a query tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// The nearest stored boundary sample, or in many dimensions one nearly as near (4 % farther in
    /// the mean on a hand of 16 joints); free as of learning. Its lower bound is that of a few
    /// balls inside the bodies of one colliding pair, often far below what the other efforts prove.
    Nearest,
    /// Fewer descents than refined: about half the checks. One answer in a few hundred is farther.
    Quick,
    /// Descents from several starts in different directions; the best end is verified.
    #[default]
    Refined,
    /// Many starts and long refinement.
    Exhaustive,
    /// As refined, and then branch and bound until [`QueryOptions::gap`] is proved or the budget is
    /// spent: the depth never rises meanwhile, and the lower bound never falls. See
    /// [`super::bound::branch_and_bound`] for what it can prove.
    Proved,
}

impl Effort {
    /// All, by how hard they try.
    pub const ALL: [Self; 5] = [Self::Nearest, Self::Quick, Self::Refined, Self::Exhaustive, Self::Proved];

    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Quick => "quick",
            Self::Refined => "refined",
            Self::Exhaustive => "exhaustive",
            Self::Proved => "proved",
        }
    }
}

/// Gap that [`Effort::Proved`] works for if none is requested.
pub const DEFAULT_GAP: f64 = 0.05;
/// Gap at which [`Effort::Quick`] and [`Effort::Refined`] stop if none is requested.
pub const REFINED_GAP: f64 = 0.15;

/// Most exits that a shell should let anyone ask for in [`QueryOptions::exits`]: memory is taken
/// for all of them.
pub const MAX_EXITS: usize = 100_000;

/// Most starts that a query makes of [`QueryOptions::starts`], and that a shell lets anyone ask
/// for: each takes a descent, and millions would never end.
pub const MAX_STARTS: usize = 100_000;

/// Exits that are looked for where the one nearest to a goal is chosen.
const TO_CHOOSE: usize = 8;

/// Options of a query. The default is one refined answer without limits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QueryOptions {
    /// How hard to try.
    pub effort: Effort,
    /// How many distinct exits are wanted, see [`super::Answer::exits`]; 0 and 1 ask for the
    /// nearest alone. More than one is found by refinement, so not with [`Effort::Nearest`].
    pub exits: usize,
    /// Starts of descents, all in all; `None` leaves it to the effort. Directions come first, then
    /// stored samples of a model; the rest are around the query. Fewer are faster and find the
    /// nearest exit less often. More than [`MAX_STARTS`] are as many.
    pub starts: Option<usize>,
    /// Share of the depth that need not be proved, in `[0, 1)`: the search stops as soon as
    /// `lower_bound >= (1 - gap) depth`. [`Effort::Proved`] works for it ([`DEFAULT_GAP`] if it is
    /// `None`). The other efforts stop as soon as they happen to meet it, and otherwise end as
    /// without it: quick and refined ones at [`REFINED_GAP`] if it is `None`, exhaustive ones at
    /// none. 0 searches on, whatever is proved. It has no effect with several
    /// [`QueryOptions::exits`] or a goal ([`QueryOptions::toward`]).
    pub gap: Option<f64>,
    /// Clearance \[m\] to aim at in place of the scene's, for pairs without one of their own
    /// ([`crate::scene::clearances`]). If nothing is found that keeps it, or only what is more than
    /// ten times as far as the nearest exit at the scene's clearance (and what the difference moves
    /// at least), the witness keeps as much of it as halving the difference finds near that exit,
    /// at least the scene's. See [`super::Answer::clearance`].
    pub clearance: Option<f64>,
    /// Joints that stay where the query has them, as indices into [`crate::Scene::joints`]; those
    /// beyond their limits, or of which a pair in collision alone depends, leave no answer.
    pub locked: Vec<usize>,
    /// A configuration that the witness is to be near to, among exits that are nearly as near as
    /// the nearest.
    pub toward: Option<Toward>,
    /// When to stop early.
    pub termination: Termination,
    /// Whether to prove how far around the witness nothing touches, see
    /// [`super::Answer::free_radius`]. Costs as much as many checks.
    pub free_radius: bool,
    /// Whether to look at the straight segment to the witness, see [`super::Answer::segment`].
    /// Costs as much as many checks.
    pub segment: bool,
    /// With [`Effort::Nearest`], whether to tell every pair that collides at the query, not one
    /// alone, and the contacts at the witness; both take longer than to find it. The other efforts
    /// tell them always.
    pub contacts: bool,
}

impl QueryOptions {
    /// How many exits to look for: several where one of them is chosen.
    pub(crate) fn wanted(&self) -> usize {
        let to_choose = if self.toward.is_some() && self.effort != Effort::Nearest { TO_CHOOSE } else { 1 };
        self.exits.max(to_choose)
    }

    /// How many starts to make, if the effort does not say.
    pub(crate) fn wanted_starts(&self) -> Option<usize> {
        self.starts.map(|starts| starts.min(MAX_STARTS))
    }

    /// The gap that ends what a refined query does: the first part of every effort above.
    pub(crate) fn first_gap(&self) -> Option<f64> {
        self.stopping(self.gap.or(Some(REFINED_GAP)))
    }

    /// The gap that ends all that an effort does.
    pub(crate) fn last_gap(&self) -> Option<f64> {
        self.stopping(match self.effort {
            Effort::Nearest | Effort::Exhaustive => self.gap,
            Effort::Quick | Effort::Refined => self.gap.or(Some(REFINED_GAP)),
            Effort::Proved => self.gap.or(Some(DEFAULT_GAP)),
        })
    }

    fn stopping(&self, gap: Option<f64>) -> Option<f64> {
        gap.filter(|_| self.effort != Effort::Nearest && self.wanted() == 1)
    }

    /// Whether contacts are told.
    pub(crate) fn tells_contacts(&self) -> bool {
        self.contacts || self.effort != Effort::Nearest
    }
}

/// Where the witness is to lie, where several exits are about as near.
#[derive(Debug, Clone, PartialEq)]
pub struct Toward {
    /// A configuration.
    pub goal: Vec<f64>,
    /// Exits count that are farther than the nearest one by at most this share of its depth, at
    /// least 0.
    pub share: f64,
}

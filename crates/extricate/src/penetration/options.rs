//! What a query is asked to do.

use std::fmt;
use std::sync::Arc;

use serde::Serialize;

/// How hard a query tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// The nearest stored boundary sample, or in many dimensions one nearly as near (4 % farther in the mean on a hand of 16 joints); free as of learning. Its lower bound is
    /// that of a few balls inside the bodies of one colliding pair, often far below what the other efforts prove.
    Nearest,
    /// Diverse candidates, pulled in, slid along the contact surface, verified.
    #[default]
    Refined,
    /// Many starts and long refinement.
    Exhaustive,
    /// As refined, and then branch and bound until [`QueryOptions::gap`] is proved or the budget is
    /// spent: the depth never rises meanwhile, and the lower bound never falls. See
    /// [`super::certificate::branches`] for what it can prove.
    Proved,
}

impl Effort {
    /// All, by how hard they try.
    pub const ALL: [Self; 4] = [Self::Nearest, Self::Refined, Self::Exhaustive, Self::Proved];

    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Refined => "refined",
            Self::Exhaustive => "exhaustive",
            Self::Proved => "proved",
        }
    }
}

/// Gap that [`Effort::Proved`] works for where none is asked for.
pub const DEFAULT_GAP: f64 = 0.05;

/// Most ways out that a shell should let anyone ask for in [`QueryOptions::exits`]: memory is taken for all of them.
pub const MOST_WAYS_OUT: usize = 100_000;

/// Exits that are looked for where the one nearest to a goal is chosen.
const TO_CHOOSE: usize = 8;

/// Options of a query. The default is one refined answer without limits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QueryOptions {
    /// How hard to try.
    pub effort: Effort,
    /// How many distinct ways out are wanted, see [`super::Answer::exits`]; 0 and 1 ask for the nearest alone. More than one
    /// is found by refinement, so not with [`Effort::Nearest`].
    pub exits: usize,
    /// Starts of descents, all in all; `None` leaves it to the effort ([`Effort::Refined`]: what
    /// the model measured, for as long as they find something nearer). Stored samples come first,
    /// as many as the effort takes; the rest are around the query. Fewer are faster and find the
    /// nearest exit less often.
    pub starts: Option<usize>,
    /// Share of the depth that need not be proved, in `[0, 1)`: the search stops as soon as
    /// `lower_bound >= (1 - gap) depth`. [`Effort::Proved`] works for it ([`DEFAULT_GAP`] where it is
    /// `None`); the other efforts stop where they happen to meet it, and otherwise end as without
    /// it. Of no effect with several [`QueryOptions::exits`] or a goal ([`QueryOptions::toward`]).
    pub gap: Option<f64>,
    /// Clearance \[m\] to aim at in place of the scene's, for pairs without one of their own
    /// ([`crate::scene::clearances`]); where nothing is found that keeps it, the scene's holds. See
    /// [`super::Answer::clearance`].
    pub clearance: Option<f64>,
    /// Joints that stay where the query has them, as indices into [`crate::Scene::joints`]; those
    /// beyond their limits, or of which a pair in collision alone depends, leave no answer.
    pub locked: Vec<usize>,
    /// A configuration that the witness is to be near to, among exits that are nearly as near as
    /// the nearest.
    pub toward: Option<Toward>,
    /// When to stop early.
    pub budget: QueryBudget,
    /// Who may end it before the budget is spent.
    pub stop: Option<Stop>,
    /// Whether to prove how far around the witness nothing touches, see
    /// [`super::Answer::free_radius`]. Costs as much as many checks.
    pub free_radius: bool,
    /// Whether to look at the straight way to the witness, see [`super::Answer::way`]. Costs as much as many checks.
    pub way: bool,
    /// With [`Effort::Nearest`], whether to tell every pair that collides at the query, not one alone, and the contacts at the witness; both take
    /// longer than to find it. The other efforts tell them always.
    pub contacts: bool,
}

impl QueryOptions {
    /// How many exits to look for: several where one of them is chosen.
    pub(super) fn wanted(&self) -> usize {
        let to_choose = if self.toward.is_some() && self.effort != Effort::Nearest { TO_CHOOSE } else { 1 };
        self.exits.max(to_choose)
    }

    /// The gap that ends the search.
    pub(super) fn wanted_gap(&self) -> Option<f64> {
        let gap = if self.effort == Effort::Proved { self.gap.or(Some(DEFAULT_GAP)) } else { self.gap };
        gap.filter(|_| self.effort != Effort::Nearest && self.wanted() == 1)
    }

    /// Whether contacts are told.
    pub(super) fn tells_contacts(&self) -> bool {
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

/// When a query stops early, with the best answer so far.
///
/// # Guarantee
/// More of either never gives a larger depth: a query is a fixed sequence of steps, and a budget ends it after some of them. (Time
/// can end two runs of the same budget at different steps.) A spent budget still leaves a free witness, verified but for
/// [`Effort::Nearest`], and its proved bound.
///
/// In a changed scene ([`crate::Model::query_in`]) it is overdrawn by what it takes to find a first witness: the nearest stored exits and samples are
/// checked until one is free there; where the nearest sixteen samples collide, descents lead out of them, and where those fail all others
/// are checked, or else other configurations, since an answer is worth more than the budget. So a query with a budget has
/// an answer wherever one without has, and no descent begins once it is spent. Only a [`Stop`] ends that search, and leaves no answer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct QueryBudget {
    /// Collision checks and distance evaluations. Overdrawn by what ends the query: at most three of them for the answer, one for each of
    /// several [`super::Answer::exits`], one for the way if that is asked for, and in a changed scene the search for a first witness.
    pub checks: Option<usize>,
    /// Seconds from the start of the call; looked at before each step. Overdrawn by the same.
    pub seconds: Option<f64>,
}

/// A question asked before each step of a query, on its thread: `true` ends it, with what a spent budget leaves. Two are equal where
/// one is a clone of the other.
#[derive(Clone)]
pub struct Stop(Arc<dyn Fn() -> bool + Send + Sync>);

impl Stop {
    /// Ends queries where `ask` says so; steps take some tens of microseconds, so it should take far less.
    pub fn when(ask: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(ask))
    }

    /// Whether to end now.
    pub fn is_asked(&self) -> bool {
        (self.0)()
    }
}

impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Stop(..)")
    }
}

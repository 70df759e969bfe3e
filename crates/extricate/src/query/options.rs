//! Options of a query: its search and its report.

use serde::Serialize;

use super::keep::KeptLink;
use super::termination::Termination;
use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::interface::{setters, words};
use crate::scene::PairId;

/// How hard a query tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Effort {
    /// Takes the nearest stored boundary sample, or in many dimensions one nearly as near (4 %
    /// farther in the mean on a hand of 16 joints). Learning verified that it is free. The lower
    /// bound comes from a few balls inside the bodies of one colliding pair, and is often far below
    /// that of the other efforts.
    Nearest,
    /// Runs fewer descents than refined, with about half the checks. One answer in a few hundred is
    /// farther.
    Quick,
    /// Runs descents from several starts in different directions, and verifies the best end.
    #[default]
    Refined,
    /// Runs descents from many starts, with long refinement.
    Exhaustive,
    /// Works like refined, then runs branch and bound until [`QueryOptions::gap`] is proved or the
    /// budget is spent. Meanwhile the depth never rises, and the lower bound never falls. See
    /// [`super::bound::branch_and_bound`] for the bounds that it can prove.
    Proved,
}

words! {
    Effort as "effort" {
        Nearest = "nearest",
        Quick = "quick",
        Refined = "refined",
        Exhaustive = "exhaustive",
        Proved = "proved",
    }
}

/// Gap that [`Effort::Proved`] aims to prove if none is requested.
pub const DEFAULT_GAP: f64 = 0.05;
/// Gap at which [`Effort::Quick`] and [`Effort::Refined`] stop if none is requested.
pub const REFINED_GAP: f64 = 0.15;

/// Largest value of [`QueryOptions::exits`], because memory is allocated for all exits.
pub const MAX_EXITS: usize = 100_000;

/// Largest value of [`QueryOptions::starts`]. Each start runs a descent, and millions would never
/// end.
pub const MAX_STARTS: usize = 100_000;

/// Number of exits to search for if the one nearest to a goal is chosen.
const EXITS_TO_CHOOSE: usize = 8;

/// Pairs that have to touch are at most this much beyond the clearance apart \[m\].
pub const TOUCH_M: f64 = 5e-4;

/// Options of a query. The default is one refined answer without limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct QueryOptions {
    /// How hard the query tries.
    pub effort: Effort,
    /// Number of distinct exits to find, at least 1, see [`super::Answer::exits`]. More than one is
    /// not allowed with [`Effort::Nearest`], because refinement finds the others.
    pub exits: usize,
    /// Number of all starts of descents; with `None` the effort sets it. Directions come first,
    /// then stored samples of a model, then starts around the query. Fewer are faster and find the
    /// nearest exit less often.
    pub starts: Option<usize>,
    /// Share of the depth that need not be proved, in `[0, 1)`. The search stops as soon as
    /// `lower_bound >= (1 - gap) depth`. [`Effort::Proved`] searches until this holds, with
    /// [`DEFAULT_GAP`] for `None`. The other efforts stop early if it happens to hold, and
    /// otherwise end as without a gap. For `None`, quick and refined queries stop at
    /// [`REFINED_GAP`], and exhaustive ones at no gap. With 0 the search continues whatever is
    /// proved. A gap is not allowed with several [`QueryOptions::exits`], or with a goal
    /// ([`QueryOptions::toward`]).
    pub gap: Option<f64>,
    /// Clearance \[m\] to aim at instead of the scene's, for pairs without one of their own
    /// ([`crate::scene::clearances`]). A witness that keeps it is too far if its depth exceeds ten
    /// times the sum of two distances: the depth at the scene's clearance and the least motion for
    /// the difference. If no nearer witness is found, the answer keeps as much of the clearance as
    /// halving the difference finds near that exit, at least the scene's. See
    /// [`super::Answer::clearance`].
    pub clearance: Option<f64>,
    /// Joints that keep their positions in the query, as indices into [`crate::Scene::joints`].
    /// There is no answer if one of them is beyond its limits, or if a colliding pair depends on
    /// them alone.
    pub locked: Vec<usize>,
    /// Links that keep their places in the query. There is no answer if nothing free is found that
    /// keeps them.
    pub keep: Vec<KeptLink>,
    /// Pairs of bodies that have to touch at the witness: their distance is at most [`TOUCH_M`]
    /// beyond the clearance. There is no answer if nothing free is found in which all do.
    pub touch: Vec<PairId>,
    /// A goal: the witness is the exit nearest to it, among exits about as near as the nearest one.
    pub toward: Option<Toward>,
    /// When the query stops early.
    pub termination: Termination,
    /// Whether to prove a radius around the witness within which nothing touches, see
    /// [`super::Answer::free_radius`]. This costs as much as many checks.
    pub free_radius: bool,
    /// Whether to check the straight segment to the witness, see [`super::Answer::segment`]. This
    /// costs as much as many checks.
    pub segment: bool,
    /// With [`Effort::Nearest`], whether to report every pair that collides at the query instead of
    /// one, and the contacts at the witness. Both take longer than finding the witness. The other
    /// efforts always report them.
    pub contacts: bool,
}

setters! {
    QueryOptions {
        effort: Effort,
        exits: usize,
        starts: usize = Some,
        gap: f64 = Some,
        clearance: f64 = Some,
        locked: Vec<usize>,
        keep: Vec<KeptLink>,
        touch: Vec<PairId>,
        toward: Toward = Some,
        termination: Termination,
        free_radius: bool,
        segment: bool,
        contacts: bool,
    }
}

impl Default for QueryOptions {
    /// Returns the options of one refined answer without limits.
    fn default() -> Self {
        Self {
            effort: Effort::default(),
            exits: 1,
            starts: None,
            gap: None,
            clearance: None,
            locked: Vec::new(),
            keep: Vec::new(),
            touch: Vec::new(),
            toward: None,
            termination: Termination::default(),
            free_radius: false,
            segment: false,
            contacts: false,
        }
    }
}

impl QueryOptions {
    /// Checks that every option has an allowed value, and that the options go together.
    ///
    /// # Errors
    /// [`Error::Option`], which names the option, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        let is_length = |length: f64| (0.0..=1e9).contains(&length);
        self.check_together()?;
        self.keep.iter().try_for_each(KeptLink::check)?;
        if !(1..=MAX_EXITS).contains(&self.exits) {
            return refuse("exits", self.exits, expected("exits"));
        }
        if let Some(bad) = self.starts.filter(|starts| !(1..=MAX_STARTS).contains(starts)) {
            return refuse("starts", bad, expected("starts"));
        }
        if let Some(bad) = self.gap.filter(|gap| !(0.0..1.0).contains(gap)) {
            return refuse("gap", bad, expected("gap"));
        }
        if let Some(bad) = self.clearance.filter(|length| !is_length(*length)) {
            return refuse("clearance", bad, expected("clearance"));
        }
        if let Some(bad) = self.termination.max_seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return refuse("max_seconds", bad, expected("max_seconds"));
        }
        match self.toward.as_ref().map(|toward| toward.share).filter(|share| !is_length(*share)) {
            Some(bad) => refuse("toward_share", bad, expected("toward_share")),
            None => Ok(()),
        }
    }

    fn check_together(&self) -> Result<()> {
        let stops = self.gap.is_some() || self.effort == Effort::Proved;
        if self.exits > 1 && self.effort == Effort::Nearest {
            return refuse("exits", self.exits, "1 with effort \"nearest\": others are found by refinement");
        }
        if self.exits > 1 && stops {
            return refuse("exits", self.exits, "1 with a gap to prove: the search stops at one");
        }
        if let Some(starts) = self.starts.filter(|_| self.effort == Effort::Nearest) {
            return refuse("starts", starts, "none with effort \"nearest\", which refines nothing");
        }
        if let Some(gap) = self.gap.filter(|_| self.effort == Effort::Nearest) {
            return refuse("gap", gap, "none with effort \"nearest\", which searches nothing");
        }
        if self.toward.is_some() && stops {
            return refuse("toward", "a goal", "none with a gap to prove: the search stops at the nearest exit");
        }
        Ok(())
    }

    /// Returns the number of exits to search for, several if a goal chooses one of them.
    pub(crate) fn wanted(&self) -> usize {
        let to_choose = if self.toward.is_some() && self.effort != Effort::Nearest { EXITS_TO_CHOOSE } else { 1 };
        self.exits.max(to_choose)
    }

    /// Returns the gap that ends the refined search, which every greater effort runs first. There
    /// is no default if only a witness is requested.
    pub(crate) fn first_gap(&self, is_unproved: bool) -> Option<f64> {
        self.stopping(self.gap.or((!is_unproved).then_some(REFINED_GAP)))
    }

    /// Returns the gap that ends the whole search of an effort.
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

    /// Returns whether contacts are reported.
    pub(crate) fn tells_contacts(&self) -> bool {
        self.contacts || self.effort != Effort::Nearest
    }
}

/// Chooses the witness if several exits are about as near: the exit nearest to a goal.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Toward {
    /// Configuration to which the chosen exit is nearest.
    pub goal: Config,
    /// An exit counts if it is farther than the nearest one by at most this share of its depth, at
    /// least 0.
    pub share: f64,
}

impl Toward {
    /// Chooses the exit nearest to `goal` among those that are farther than the nearest exit by at
    /// most `share` of its depth.
    pub fn new(goal: Config, share: f64) -> Self {
        Self { goal, share }
    }
}

/// A query option as Python spells it; the command line uses `-` for `_`, and C uses the same
/// names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OptionEntry {
    /// Name of the option.
    pub name: &'static str,
    /// Default value, as Python writes it.
    pub default: &'static str,
    /// Values that the option accepts.
    pub expected: &'static str,
}

/// All query options. Tests check the signatures of Python, the help of the command line and the
/// header of C against them.
pub const QUERY_OPTIONS: &[OptionEntry] = &[
    entry("effort", "'refined'", "\"nearest\", \"quick\", \"refined\", \"exhaustive\" or \"proved\""),
    entry("exits", "1", "1 to 100000"),
    entry("starts", "None", "1 to 100000"),
    entry("gap", "None", "0 or more and less than 1"),
    entry("clearance", "None", "0 to 1e9 [m]"),
    entry("locked", "None", "names of joints"),
    entry("keep", "None", "links that keep their places"),
    entry("touch", "None", "pairs of names of bodies"),
    entry("toward", "None", "a configuration"),
    entry("toward_share", "0.25", "0 to 1e9"),
    entry("max_checks", "None", "0 or more"),
    entry("max_seconds", "None", "more than 0"),
    entry("free_radius", "False", "True or False"),
    entry("segment", "False", "True or False"),
    entry("contacts", "False", "True or False"),
];

const fn entry(name: &'static str, default: &'static str, expected: &'static str) -> OptionEntry {
    OptionEntry { name, default, expected }
}

fn expected(name: &str) -> &'static str {
    QUERY_OPTIONS.iter().find(|option| option.name == name).map_or("another value", |option| option.expected)
}

fn refuse(name: &'static str, value: impl ToString, expected: &str) -> Result<()> {
    Err(Error::Option { name, value: value.to_string(), expected: expected.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_no_sense_is_named() {
        let options = QueryOptions::default;
        assert!(options().check().is_ok());
        let goal = Toward { goal: Config::trusted(&[0.0]), share: 0.25 };
        for (bad, part) in [
            (options().exits(0), "option exits: got 0, expected 1 to 100000"),
            (options().exits(2).effort(Effort::Nearest), "exits: got 2, expected 1 with effort"),
            (options().exits(2).gap(0.1), "exits: got 2, expected 1 with a gap"),
            (options().starts(0), "starts: got 0, expected 1 to 100000"),
            (options().gap(1.0), "gap: got 1, expected 0 or more and less than 1"),
            (options().gap(0.1).effort(Effort::Nearest), "gap: got 0.1, expected none"),
            (options().clearance(-1.0), "clearance: got -1, expected 0 to 1e9 [m]"),
            (options().termination(Termination::after_seconds(0.0)), "max_seconds: got 0, expected more than 0"),
            (options().toward(goal.clone()).effort(Effort::Proved), "toward: got a goal, expected none"),
            (options().toward(Toward { share: f64::NAN, ..goal.clone() }), "toward_share: got NaN, expected 0 to"),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        assert!("quick".parse::<Effort>().is_ok_and(|effort| effort == Effort::Quick && effort.to_string() == "quick"));
        let unknown = "quickly".parse::<Effort>().unwrap_err().to_string();
        assert!(unknown.contains(expected("effort")), "{unknown}");
        for (name, most) in [("exits", MAX_EXITS), ("starts", MAX_STARTS)] {
            assert_eq!(expected(name), format!("1 to {most}"));
        }
    }
}

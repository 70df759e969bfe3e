//! How a model was learned and how good it measured itself to be. This file measures nothing.

use serde::{Deserialize, Serialize};

use super::evaluate::figures::{Density, Excess, Gap};
use crate::interface::words;

/// How a model was learned and how good it measured itself to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Statistics {
    /// Number of labels spent: exact checks and evaluations of contacts.
    pub labels: usize,
    /// Seed of every sampler of the run.
    pub seed: u64,
    /// Number of boundary samples stored; all were verified free.
    pub boundary_samples: usize,
    /// Number of solved samples among them; they are stored last. Each is the exit of a colliding
    /// configuration that learning solved.
    #[serde(alias = "exits")]
    pub solved_samples: usize,
    /// Number of stand-ins among them; they are stored first. These are free configurations that
    /// make up for boundary samples if fewer than 128 were found.
    pub stand_ins: usize,
    /// Number of support vectors of the classifier, over all pairs.
    pub support_vectors: usize,
    /// Share of uniform configurations that collide.
    pub colliding_share: f64,
    /// Held-out accuracy on free configurations; `None` without a classifier or held-out ones.
    pub accuracy_free: Option<f64>,
    /// 95 % confidence interval of `accuracy_free` (Wilson).
    pub accuracy_free_interval: Option<[f64; 2]>,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: Option<f64>,
    /// 95 % confidence interval of `accuracy_colliding` (Wilson).
    pub accuracy_colliding_interval: Option<[f64; 2]>,
    /// Every boundary sample that is not a stand-in has a colliding configuration within this
    /// distance, in the scene's metric. `None` if all are stand-ins.
    pub boundary_gap: Option<f64>,
    /// How densely the boundary is sampled; `None` if nothing held out collided, or after
    /// interruption.
    pub density: Option<Density>,
    /// How good refined queries are on held-out colliding configurations: 64 of them, or fewer if
    /// one check for every four labels does not pay for so many. `None` if none was queried, as
    /// with fewer than 10,000 labels.
    pub excess: Option<Excess>,
    /// How much of the depth the same queries leave unproved; also `None` in models of versions
    /// that did not measure it.
    #[serde(default)]
    pub gap: Option<Gap>,
    /// Collision and distance evaluations spent on measuring these three, in addition to `labels`.
    pub measuring_checks: usize,
    /// What ended learning. With a limit in seconds, the model depends on the speed of the machine.
    pub ended_by: EndedBy,
}

/// Greatest count that a file may give: beyond what any run can spend, and far from where sums
/// overflow.
const MAX_COUNT: u64 = 1 << 48;

/// Checks that a count read from bytes is plausible.
///
/// # Errors
/// The name, the value, and what was expected.
fn check_count(name: &str, count: usize) -> Result<(), String> {
    if count as u64 <= MAX_COUNT { Ok(()) } else { Err(format!("{name}: got {count}, expected at most {MAX_COUNT}")) }
}

/// Checks that a share read from bytes lies in `[0, 1]`.
///
/// # Errors
/// The name, the value, and what was expected.
fn check_share(name: &str, share: f64) -> Result<(), String> {
    if (0.0..=1.0).contains(&share) { Ok(()) } else { Err(format!("{name}: got {share:?}, expected 0 to 1")) }
}

impl Statistics {
    /// Checks that statistics read from bytes can belong to a model with this many samples.
    ///
    /// # Errors
    /// The figure, its value, and what was expected.
    pub(crate) fn check(&self, samples: usize) -> Result<(), String> {
        let Self { labels, boundary_samples, solved_samples, stand_ins, support_vectors, .. } = self;
        let of_excess = self.excess.map_or(0, |excess| excess.queries);
        let of_gap = self.gap.map_or(0, |gap| gap.queries);
        for (name, count) in [
            ("labels", *labels),
            ("support_vectors", *support_vectors),
            ("measuring_checks", self.measuring_checks),
            ("excess.queries", of_excess),
            ("gap.queries", of_gap),
        ] {
            check_count(name, count)?;
        }
        if *boundary_samples != samples {
            return Err(format!("boundary_samples: got {boundary_samples}, expected {samples}"));
        }
        if solved_samples.saturating_add(*stand_ins) > samples {
            let found = format!("got {solved_samples} and {stand_ins}");
            return Err(format!("solved_samples and stand_ins: {found}, expected at most {samples} together"));
        }
        let accuracies = [
            ("accuracy_free", self.accuracy_free, self.accuracy_free_interval),
            ("accuracy_colliding", self.accuracy_colliding, self.accuracy_colliding_interval),
        ];
        check_share("colliding_share", self.colliding_share)?;
        for (name, share, interval) in accuracies {
            let mut shares = share.into_iter().chain(interval.into_iter().flatten());
            shares.try_for_each(|share| check_share(name, share))?;
        }
        self.check_figures()
    }

    /// Checks that distances are at most [`FARTHEST_DISTANCE`] and shares at most 1, none negative.
    fn check_figures(&self) -> Result<(), String> {
        let density = self.density.map(|Density { spacing_median, spacing_p95, reach_median, reach_p95 }| {
            [spacing_median, spacing_p95, reach_median, reach_p95]
        });
        let distances = self.boundary_gap.into_iter().chain(density.into_iter().flatten());
        for distance in distances {
            if !(0.0..=FARTHEST_DISTANCE).contains(&distance) {
                let expected = format!("expected distances from 0 to {FARTHEST_DISTANCE:e}");
                return Err(format!("boundary_gap and density: got {distance:?}, {expected}"));
            }
        }
        if let Some(excess) = self.excess {
            let [low, high] = excess.within_5pct_interval;
            [excess.within_5pct, low, high].into_iter().try_for_each(|share| check_share("excess", share))?;
        }
        Ok(())
    }
}

/// Greatest distance between configurations that a file may give, in metric units: coordinates are
/// at most 1e9, and so are weights.
pub const FARTHEST_DISTANCE: f64 = 1e18;

/// What ended a learning run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum EndedBy {
    /// The budget of labels was spent. Versions before 14 had two more ends, which are read as this
    /// one.
    #[serde(alias = "memory", alias = "quality")]
    Labels,
    /// The budget of seconds was spent.
    Seconds,
    /// The caller stopped the run.
    Interruption,
}

words! {
    EndedBy as "ended_by" { Labels = "labels", Seconds = "seconds", Interruption = "interruption" }
}

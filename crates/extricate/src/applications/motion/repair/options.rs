//! Options and result of a repair.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::interface::setters;
use crate::query::{Context, KeptLink, Termination};

/// Margin of pushed configurations beyond the scene's clearance if no aim is given, as a share of
/// the radius of the smallest moving body. An edge between two such configurations may bend by as
/// much.
const AIM: f64 = 0.1;

/// Share of the distance of touching pairs within which the result holds them: steps are linear,
/// and contacts bend.
pub const HELD_SHARE: f64 = 0.9;

/// Options of a repair.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RepairOptions {
    /// Clearance \[m\] to which configurations are pushed out, for pairs without one of their own;
    /// or as much of it as they can keep nearby, at least the scene's. `None` is the scene's
    /// clearance plus a tenth of the radius of the smallest moving body.
    pub aim: Option<f64>,
    /// Largest accepted [`Repaired::deviation`]; `None` means no limit.
    pub max_deviation: Option<f64>,
    /// Links that keep their places at the first row, or at given poses, all along the path. With
    /// [`RepairOptions::frames`] each row keeps them where it has them, but not the edges between.
    pub keep: Vec<KeptLink>,
    /// Whether the rows are frames of a motion: the result has one row for each, at the same time.
    pub frames: bool,
    /// With [`RepairOptions::frames`], but not with [`RepairOptions::keep`]: the longest step from
    /// frame to frame, in metric units. The result lags behind steps that are longer. `None` means
    /// no limit.
    pub max_step: Option<f64>,
    /// With [`RepairOptions::frames`]: pairs that are at most this far apart \[m\] beyond the
    /// clearance in a row, or overlap there, stay as near in the result if they can. The default of
    /// `aim` is then at most half of it. `None` keeps no contacts.
    pub touch: Option<f64>,
    /// Resolution \[m\] at which edges are proved, see [`crate::SegmentOptions::resolution`].
    pub resolution: f64,
    /// The seed of all random numbers.
    pub seed: u64,
    /// When to give up.
    pub termination: Termination,
}

setters! {
    RepairOptions {
        aim: f64 = Some,
        max_deviation: f64 = Some,
        keep: Vec<KeptLink>,
        frames: bool,
        max_step: f64 = Some,
        touch: f64 = Some,
        resolution: f64,
        seed: u64,
        termination: Termination,
    }
}

impl Default for RepairOptions {
    /// Proves edges to 0.1 mm, and ends after 100,000 checks.
    fn default() -> Self {
        let termination = Termination::after_checks(100_000);
        Self {
            aim: None,
            max_deviation: None,
            keep: Vec::new(),
            frames: false,
            max_step: None,
            touch: None,
            resolution: 1e-4,
            seed: 0,
            termination,
        }
    }
}

impl RepairOptions {
    pub(super) fn check(&self) -> Result<()> {
        let lengths = [
            ("aim", self.aim.unwrap_or(0.0)),
            ("max_deviation", self.max_deviation.unwrap_or(0.0)),
            ("max_step", self.max_step.unwrap_or(0.0)),
            ("touch", self.touch.unwrap_or(0.0)),
            ("resolution", self.resolution),
        ];
        for (name, value) in [("max_step", self.max_step), ("touch", self.touch)] {
            if let Some(value) = value.filter(|value| !self.frames || *value == 0.0) {
                let expected = "none without `frames`, and more than 0 with it".into();
                return Err(Error::Option { name, value: value.to_string(), expected });
            }
        }
        if let Some(value) = self.max_step.filter(|_| !self.keep.is_empty()) {
            let expected = "none with `keep`: a result that lags behind keeps no link".into();
            return Err(Error::Option { name: "max_step", value: value.to_string(), expected });
        }
        match lengths.into_iter().find(|(_, length)| !(0.0..=1e9).contains(length)) {
            Some((name, value)) => {
                Err(Error::Option { name, value: value.to_string(), expected: "a number from 0 to 1e9".into() })
            }
            None => Ok(()),
        }
    }

    /// Checks that pairs can touch at the aimed clearance, in a scene of this clearance \[m\].
    pub(super) fn check_touch(&self, clearance: f64) -> Result<()> {
        match (self.aim, self.touch) {
            (Some(aim), Some(touch)) if HELD_SHARE * touch <= aim - clearance => {
                let least = (aim - clearance) / HELD_SHARE;
                let expected = format!("more than {least}, because the result keeps the aim of {aim} m");
                Err(Error::Option { name: "touch", value: touch.to_string(), expected })
            }
            _ => Ok(()),
        }
    }

    /// Returns the clearance to aim at \[m\].
    pub(super) fn aim_over(&self, context: &Context) -> f64 {
        self.aim.unwrap_or(context.clearance + AIM * context.checker.moving_radius()).max(context.clearance)
    }
}

/// A repaired path, see [`crate::Solver::repair`].
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Repaired {
    /// Configurations, joined by geodesics; empty if no path was found.
    pub points: Vec<Vec<f64>>,
    /// For each point, the corresponding position on the old path: 2.25 is a quarter of the edge
    /// from row 2 to row 3. Places turn time stamps of rows into those of points. They ascend, and
    /// are whole numbers for rows that stay.
    pub places: Vec<f64>,
    /// Largest distance, in metric units, of a point from its place, and of a row of the old path
    /// from the corresponding point of the new one.
    pub deviation: f64,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Length of the old path, in the same metric.
    pub length_before: f64,
    /// Number of stretches of the old path that were replaced.
    pub stretches: usize,
    /// Number of gaps in these stretches that trees had to close.
    pub gaps: usize,
    /// Number of pairs that touch, summed over the rows; 0 without [`RepairOptions::touch`].
    pub touched: usize,
    /// Number of these that touch in the result.
    pub kept: usize,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: usize,
}

impl Repaired {
    /// Whether a path was found.
    pub fn is_found(&self) -> bool {
        !self.points.is_empty()
    }
}

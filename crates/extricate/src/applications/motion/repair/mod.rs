//! Repair: turns a path that collides into one nearby that is proved free.
//!
//! Read in this order: `options` (options and result), `old_path` (where the old path is free),
//! `repairer`, `mod` (the steps), `push_stretch`, `gaps`, `pull`; `frames` is the other way, for
//! motions whose rows are frames.
//!
//! 1. *Stretches*: prove the old edges free from both ends; replace what is between (`old_path`).
//! 2. *Push*: bring configurations along a stretch to free ones that keep the aimed clearance, each
//!    begun from the last one. If the edge between two is not proved, push its middle too
//!    (`push_stretch`).
//! 3. *Gaps*: if any are left, as after a jump of the nearest exit, close them by RRT-Connect in a
//!    widening tube around the old path (`gaps`).
//! 4. *Pull*: move points back toward the old path, and remove those that are not needed (`pull`).
//!
//! # Source
//! Pushing configurations of a path out at a larger clearance than the proved one follows
//! small-step retraction: M. Saha, J.-C. Latombe, Y.-C. Chang and F. Prinz, "Finding narrow
//! passages with probabilistic roadmaps: the small-step retraction method", Autonomous Robots
//! 19(3), 2005, doi:10.1007/s10514-005-4748-1. Deviation: exits are found by queries, not by
//! shrinking bodies.

mod frames;
mod gaps;
mod old_path;
mod options;
mod pull;
mod push_stretch;
mod repairer;

pub use options::{RepairOptions, Repaired};

use super::path;
use crate::cspace::{Config, Rows};
use crate::error::{Error, Result};
use crate::query::keep::LinkConstraint;
use crate::solver::Solver;
use old_path::Point;
use repairer::Repairer;

impl Solver {
    /// Returns a path that is proved free, as near to the path of `points` (one or more rows) as is
    /// found. Its free parts stay, except beside collisions. A colliding end is moved too. Links of
    /// [`RepairOptions::keep`] keep their places; parts in which they do not are repaired too.
    ///
    /// # Guarantee
    /// Every configuration of the result is proved free. Links are proved to be kept at all of
    /// them, and with [`RepairOptions::frames`] at those of the rows. If no such path is found,
    /// [`Repaired::points`] is empty; that proves nothing. The same solver, points and options give
    /// the same result, unless a limit in seconds ends it.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no row, or if one is no configuration of the scene within its
    /// limits: the row is named. [`Error::Option`] for an option that makes no sense.
    pub fn repair(&self, points: Rows, options: &RepairOptions) -> Result<Repaired> {
        options.check()?;
        options.check_touch(self.checker().base_clearance())?;
        let space = &self.scene().space;
        let config = |(row, q): (usize, &[f64])| {
            space.config(q).map_err(|error| Error::input("path", format!("row {row}"), error.to_string()))
        };
        let old: Vec<Config> = points.iter().enumerate().map(config).collect::<Result<_>>()?;
        if old.is_empty() {
            return Err(Error::input("path", "rows", "got none, expected one or more"));
        }
        options.keep.iter().try_for_each(|link| link.check_in(self.scene()))?;
        // Frames keep links where each row has them, by the options of their queries.
        let keep = if options.frames { &[][..] } else { &options.keep };
        let kept = LinkConstraint::all(self.scene(), keep, &old[0]);
        Ok(Repairer::new(&self.context().keeping(&kept), &old, options).repair())
    }
}

impl Repairer<'_> {
    fn repair(mut self) -> Repaired {
        if self.options.frames {
            let Some(points) = self.frame_by_frame() else { return self.none() };
            let is_new = |(place, q): &Point| self.old.at(*place) != *q;
            let changed: Vec<bool> = points.iter().map(is_new).collect();
            let runs = changed.chunk_by(|a, b| a == b).filter(|run| run[0]).count();
            return self.answer(points, runs);
        }
        let stretches = self.old.colliding(push_stretch::STEP_SHARE * self.context.metric.diameter(), &mut self.prover);
        let mut new: Vec<Point> = Vec::new();
        let mut from = 0.0;
        for stretch in &stretches {
            // A colliding end is no part of the new path.
            if stretch.from > from {
                self.old.copy(from, stretch.from, &mut new);
            }
            let Some(points) = self.replace(stretch.from, stretch.to) else { return self.none() };
            new.extend(points);
            from = stretch.to;
        }
        if from < self.old.end() || stretches.is_empty() {
            self.old.copy(from, self.old.end(), &mut new);
        }
        // Points where stretches meet are there twice. Equal rows stay: their places differ.
        new.dedup();
        self.answer(new, stretches.len())
    }

    /// Returns new points for the stretch between two places, both included.
    fn replace(&mut self, from: f64, to: f64) -> Option<Vec<Point>> {
        let pushed = self.push(from, to)?;
        let closed = self.close(pushed)?;
        Some(self.pull(closed))
    }

    fn answer(self, new: Vec<Point>, stretches: usize) -> Repaired {
        let deviation = self.farthest(&new);
        if self.options.max_deviation.is_some_and(|most| deviation > most) {
            return self.none();
        }
        let (metric, nq) = (self.context.metric, new[0].1.len());
        let flat: Vec<f64> = new.iter().flat_map(|(_, q)| q.iter().copied()).collect();
        Repaired {
            length: path::length(metric, &flat, nq),
            length_before: self.old.length(),
            places: new.iter().map(|(place, _)| *place).collect(),
            points: new.into_iter().map(|(_, q)| q).collect(),
            deviation,
            stretches,
            gaps: self.gaps,
            touched: self.touched,
            kept: self.kept,
            checks: self.prover.checks,
        }
    }

    fn none(&self) -> Repaired {
        Repaired { checks: self.prover.checks, length_before: self.old.length(), ..Repaired::default() }
    }
}

#[cfg(test)]
mod tests;

//! Whether a whole geodesic between two configurations is free. The proof halves it until the
//! bodies cannot move farther along any stretch than they are apart at its middle.

mod proved;
mod search;
pub mod speed_paths;
pub mod stretches;

use super::checker::{CheckScratch, Checker};
use crate::interface::setters;
use crate::scene::{PairId, Scene};
pub(crate) use proved::prove;
pub use search::LEAST_RESOLUTION;
pub(crate) use search::SegmentBudget;
use search::{MIN_STRETCH_SHARE, Search};
use stretches::Stretch;

/// Resolution of the check of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SegmentOptions {
    /// Length \[m\] to which contacts are located. Bodies that come within about this of losing the
    /// clearance may leave a segment undecided. A contact is enclosed in a stretch along which the
    /// bodies that may collide move by at most about this relative to each other. Smaller values
    /// than [`LEAST_RESOLUTION`] count as that.
    pub resolution: f64,
}

setters! { SegmentOptions { resolution: f64 } }

impl Default for SegmentOptions {
    /// A resolution of 0.1 mm.
    fn default() -> Self {
        Self { resolution: 1e-4 }
    }
}

/// Result of a segment check. Fractions are those of [`crate::cspace::ConfigSpace::interpolate`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SegmentOutcome {
    /// Proved: every configuration of the segment is free.
    Free,
    /// The segment meets a collision.
    Contact {
        /// Proved: every configuration up to this fraction is free. It is 0 if the first one
        /// collides.
        free_until: f64,
        /// [`Checker::label`] calls the configuration at this fraction colliding. From `free_until`
        /// to here, the bodies that may collide move by at most about the resolution relative to
        /// each other.
        colliding_at: f64,
        /// A pair that collides there; see [`Scene::pair_names`].
        pair: PairId,
    },
    /// There is no proof, and no collision was found next to where the proof ends. Two bodies come
    /// too near to losing the clearance, 262,144 stretches did not suffice for so long a motion, or
    /// a budget ended the proof.
    Undecided {
        /// Proved: every configuration up to this fraction is free.
        free_until: f64,
        /// Fraction at which a pair is within the resolution of losing the clearance, or at which
        /// the proof was given up.
        near_at: f64,
        /// The pair, or one that is not proved there; see [`Scene::pair_names`].
        pair: PairId,
    },
}

/// See [`Checker::segment`].
pub fn segment(
    checker: &Checker,
    from: &[f64],
    to: &[f64],
    options: &SegmentOptions,
    scratch: &mut CheckScratch,
) -> SegmentOutcome {
    segment_within(checker, (from, to), options, &SegmentBudget::UNLIMITED, scratch)
}

/// See [`Checker::segment`]; the proof is given up if the budget ends.
pub fn segment_within(
    checker: &Checker,
    (from, to): (&[f64], &[f64]),
    options: &SegmentOptions,
    budget: &SegmentBudget,
    scratch: &mut CheckScratch,
) -> SegmentOutcome {
    let mut own = std::mem::take(&mut scratch.segment);
    let outcome = Search { checker, from, to, scratch, own: &mut own, budget }.run(options);
    scratch.segment = own;
    outcome
}

impl Search<'_> {
    fn run(&mut self, options: &SegmentOptions) -> SegmentOutcome {
        let resolution = options.resolution.max(LEAST_RESOLUTION);
        let Scene { space, .. } = &*self.checker.scene;
        self.own.q.resize(space.nq(), 0.0);
        self.own.rates.resize(space.nv(), 0.0);
        self.own.checks = 0;
        space.difference(self.from, self.to, &mut self.own.rates);
        if let Some(pair) = self.colliding(0.0) {
            return SegmentOutcome::Contact { free_until: 0.0, colliding_at: 0.0, pair: PairId::new(pair) };
        }
        let mut colliding = self.colliding(1.0).map(|pair| (1.0, pair));

        self.begin();
        let mut count = 0;
        while let Some(stretch) = self.own.stretches.pop() {
            count += 1;
            self.own.pairs.truncate(stretch.last);
            let Some((pair, speed)) = self.unproved(&stretch) else { continue };
            let Stretch { from, to, last, .. } = stretch;
            let middle = 0.5 * (from + to);
            let found = {
                let mut unproved = self.own.pairs[last..].iter().map(|&pair| pair as usize);
                unproved.find(|&pair| self.checker.pair_collides(pair, self.scratch))
            };
            if let Some(found) = found {
                colliding = Some((middle, found));
                self.own.stretches.clear();
            }
            // Stop at the least length, and if no number lies between the ends.
            let finest = (to - from) * speed <= MIN_STRETCH_SHARE * resolution || middle <= from || middle >= to;
            if self.is_spent() {
                return SegmentOutcome::Undecided { free_until: from, near_at: middle, pair: PairId::new(pair) };
            }
            if finest || count >= self.budget.stretches {
                return self.end(&stretch, (pair, speed), colliding, resolution);
            }
            let (first, last) = (last, self.own.pairs.len());
            if found.is_none() {
                self.own.stretches.push(Stretch { from: middle, to, first, last });
            }
            self.own.stretches.push(Stretch { from, to: middle, first, last });
        }
        SegmentOutcome::Free
    }

    /// Chooses the outcome after a stretch of the least length is not proved.
    fn end(
        &mut self,
        stretch: &Stretch,
        (pair, speed): (usize, f64),
        colliding: Option<(f64, usize)>,
        resolution: f64,
    ) -> SegmentOutcome {
        let free_until = stretch.from;
        // The bound on the speed holds within the stretch; just outside, the speed may be a little
        // higher.
        let reach = free_until + 0.9 * resolution / speed;
        let contact =
            |(colliding_at, pair)| SegmentOutcome::Contact { free_until, colliding_at, pair: PairId::new(pair) };
        if let Some(found) = colliding.filter(|(at, _)| *at <= reach) {
            return contact(found);
        }
        let steps = (1.0 / MIN_STRETCH_SHARE) as u32;
        for step in 1..=steps {
            let at = free_until + (reach.min(1.0) - free_until) * f64::from(step) / f64::from(steps);
            if let Some(pair) = self.colliding(at) {
                return contact((at, pair));
            }
        }
        SegmentOutcome::Undecided { free_until, near_at: 0.5 * (stretch.from + stretch.to), pair: PairId::new(pair) }
    }
}

#[cfg(test)]
pub mod tests;

//! Proofs that a segment with a free first end is free, for callers that try many segments. The
//! search fails early, wherever the segment meets a collision.

use super::search::{LEAST_RESOLUTION, MIN_STRETCH_SHARE, Search, SegmentBudget};
use super::stretches::Stretch;
use crate::collision::checker::{CheckScratch, Checker};

/// Whether a segment was proved free, and how many checks that took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proved {
    /// Whether every configuration of the segment is proved free.
    pub is_free: bool,
    /// Number of configurations at which distances or collisions were evaluated.
    pub checks: usize,
}

/// Whether every configuration of the geodesic is proved free. The first one must be known to be
/// free.
///
/// # Guarantee
/// `true` is proved as in [`Checker::segment`]. `false` proves nothing: a collision was met, two
/// bodies come within about `resolution` \[m\] of losing the clearance, or the budget ended.
///
/// # Cost
/// Stretches are halved breadth first. A collision in the middle of a long segment then costs a few
/// evaluations, not a proof of all that comes before it.
pub fn prove(
    checker: &Checker,
    (from, to): (&[f64], &[f64]),
    resolution: f64,
    budget: &SegmentBudget,
    scratch: &mut CheckScratch,
) -> Proved {
    let mut own = std::mem::take(&mut scratch.segment);
    let mut search = Search { checker, from, to, scratch, own: &mut own, budget };
    let is_free = search.run_breadth_first(resolution.max(LEAST_RESOLUTION));
    let checks = own.checks;
    scratch.segment = own;
    Proved { is_free, checks }
}

impl Search<'_> {
    fn run_breadth_first(&mut self, resolution: f64) -> bool {
        let space = &self.checker.scene.space;
        self.own.q.resize(space.nq(), 0.0);
        self.own.rates.resize(space.nv(), 0.0);
        self.own.checks = 0;
        space.difference(self.from, self.to, &mut self.own.rates);
        if self.colliding(1.0).is_some() {
            return false;
        }
        self.begin();
        let mut at = 0;
        while let Some(&stretch) = self.own.stretches.get(at) {
            at += 1;
            let before = self.own.pairs.len();
            let Some((_, speed)) = self.unproved(&stretch) else { continue };
            let Stretch { from, to, .. } = stretch;
            let middle = 0.5 * (from + to);
            let after = self.own.pairs.len();
            let collides = (before..after).any(|k| {
                let pair = self.own.pairs[k] as usize;
                self.checker.pair_collides(pair, self.scratch)
            });
            let finest = (to - from) * speed <= MIN_STRETCH_SHARE * resolution || middle <= from || middle >= to;
            if collides || finest || at >= self.budget.stretches || self.is_spent() {
                return false;
            }
            let (first, last) = (before, after);
            self.own.stretches.push(Stretch { from, to: middle, first, last });
            self.own.stretches.push(Stretch { from: middle, to, first, last });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{SegmentOptions, SegmentOutcome, signed_distances};
    use crate::cspace::Label;
    use crate::cspace::sampling::Halton;
    use crate::scene::{PairId, builtin};

    #[test]
    fn what_is_proved_is_what_segments_prove() {
        let (mut both, mut neither) = (0, 0);
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let space = &checker.scene().space;
            let (halton, mut scratch) = (Halton::new(space.nv(), 2), CheckScratch::default());
            let [mut a, mut b, mut far] = [(); 3].map(|()| vec![0.0; space.nq()]);
            for index in 0..200 {
                halton.config(space, 2 * index, &mut a);
                halton.config(space, 2 * index + 1, &mut far);
                space.interpolate(&a, &far, [0.3, 0.03][index as usize % 2], &mut b);
                if checker.label(&a, &mut scratch) == Label::Colliding {
                    continue;
                }
                let proved = prove(&checker, (&a, &b), 1e-4, &SegmentBudget::UNLIMITED, &mut scratch);
                let outcome = checker.segment(&a, &b, &SegmentOptions::default(), &mut scratch);
                assert_eq!(proved.is_free, outcome == SegmentOutcome::Free, "{name} {index}: {outcome:?}");
                assert!(proved.checks > 0 && scratch.segment_checks() > 0);
                both += usize::from(proved.is_free);
                neither += usize::from(!proved.is_free);
            }
        }
        assert!(both > 40 && neither > 40, "{both} {neither}");
    }

    /// A long edge takes many evaluations, and a budget ends the proof after the permitted ones.
    #[test]
    fn a_budget_ends_a_proof() {
        let checker = Checker::new(builtin::scene("planar-arm").unwrap().into());
        let space = &checker.scene().space;
        let (halton, mut scratch) = (Halton::new(space.nv(), 2), CheckScratch::default());
        let [mut a, mut b] = [(); 2].map(|()| vec![0.0; space.nq()]);
        let long = (0..1000).find_map(|index| {
            halton.config(space, 2 * index, &mut a);
            halton.config(space, 2 * index + 1, &mut b);
            let is_free = checker.label(&a, &mut scratch) == Label::Free;
            let whole = prove(&checker, (&a, &b), 1e-5, &SegmentBudget::UNLIMITED, &mut scratch);
            (is_free && whole.is_free && whole.checks > 8).then_some(whole)
        });
        let whole = long.expect("a long free edge");
        for most in [1, 3, whole.checks / 2] {
            let budget = SegmentBudget { is_spent: &|checks| checks >= most, ..SegmentBudget::UNLIMITED };
            let proved = prove(&checker, (&a, &b), 1e-5, &budget, &mut scratch);
            assert!(!proved.is_free && proved.checks <= most + 1, "{most}: {proved:?}");
            let options = SegmentOptions { resolution: 1e-5 };
            let SegmentOutcome::Undecided { free_until, .. } =
                checker.segment_within((&a, &b), &options, &budget, &mut scratch)
            else {
                panic!("a proof that a budget ends says neither")
            };
            assert!(free_until < 1.0 && scratch.segment_checks() <= most + 2);
        }
    }

    /// With floors below zero, pairs may overlap to the depth that they have at one configuration.
    /// Exactly the configurations within these depths are free.
    #[test]
    fn floors_below_zero_are_depths() {
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let space = &checker.scene().space;
            let (halton, mut scratch) = (Halton::new(space.nv(), 6), CheckScratch::default());
            let [mut q, mut far] = [(); 2].map(|()| vec![0.0; space.nq()]);
            for index in 0..15 {
                halton.config(space, 2 * index, &mut q);
                halton.config(space, 2 * index + 1, &mut far);
                let all = |q: &[f64], scratch: &mut CheckScratch| signed_distances(&checker, q, scratch);
                let floors: Vec<(PairId, f64)> = all(&q, &mut scratch)
                    .iter()
                    .enumerate()
                    .map(|(k, d)| (PairId::new(k), d.min(0.0) - 0.01))
                    .collect();
                let relaxed = checker.with_floors(&floors);
                assert_eq!(relaxed.label(&q, &mut scratch), Label::Free, "{name} {index}");
                let mut p = q.clone();
                for step in 1..=6 {
                    space.interpolate(&q, &far, f64::from(step) / 6.0, &mut p);
                    let keeps = all(&p, &mut scratch).iter().zip(&floors).all(|(d, (_, floor))| *d >= *floor);
                    assert_eq!(relaxed.label(&p, &mut scratch) == Label::Free, keeps, "{name} {index} {step}");
                }
            }
        }
    }
}

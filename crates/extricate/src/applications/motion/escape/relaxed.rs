//! The set in which an escape stays: colliding pairs may collide no deeper than at the query.

use crate::collision::{CheckScratch, Checker, signed_distances_of};
use crate::scene::PairId;

/// The set, as what a checker with other clearances calls free.
pub struct Relaxed {
    /// Requires of pairs that collide at the query their signed distance there less a tolerance.
    pub checker: Checker,
    /// These pairs, and their signed distances at the query \[m\].
    pub colliding: Vec<(PairId, f64)>,
}

impl Relaxed {
    /// Makes the set for `q`. An edge in it is proved as one in free space is: a signed distance,
    /// of either sign, changes by no more than points of one body move, seen from the other.
    pub fn at(checker: &Checker, q: &[f64], tolerance: f64, scratch: &mut CheckScratch) -> Self {
        let mut pairs = Vec::new();
        checker.colliding_pairs(q, scratch, &mut pairs);
        let distances = signed_distances_of(checker, q, &pairs, scratch);
        let colliding: Vec<(PairId, f64)> = pairs.into_iter().zip(distances).collect();
        let floors: Vec<(PairId, f64)> =
            colliding.iter().map(|(pair, distance)| (*pair, distance - tolerance)).collect();
        Self { checker: checker.with_floors(&floors), colliding }
    }

    /// Returns the set in which the colliding pairs have come the `share` of the way to `aim`
    /// \[m\], or to a clearance of their own, and all other pairs keep it.
    pub fn raised(&self, checker: &Checker, aim: f64, share: f64) -> Checker {
        let aimed = checker.with_clearance(aim);
        let raised = |(pair, distance): &(PairId, f64)| {
            let target = aimed.clearance_of(pair.index());
            (*pair, distance + share * (target - distance))
        };
        let floors: Vec<(PairId, f64)> = self.colliding.iter().map(raised).collect();
        aimed.with_floors(&floors)
    }
}

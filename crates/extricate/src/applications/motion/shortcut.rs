//! Shortens paths by proved edges between points that were not neighbours.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::prover::Prover;

/// Attempts for each point of the path, and the fewest. Raising either shortens paths of trees by
/// less than a hundredth.
const ATTEMPTS_PER_POINT: usize = 2;
const MIN_ATTEMPTS: usize = 10;

/// Removes points that are not needed: tries edges between random points, then from each point to
/// the one after its neighbour.
///
/// # Guarantee
/// Every edge of the result is proved if all edges of the path are. The ends stay.
///
/// # Source
/// The shortcut heuristic as R. Geraerts and M. H. Overmars describe it, "Creating high-quality
/// paths for motion planning", IJRR 26(8), 2007, doi:10.1177/0278364907079280. Deviation: edges
/// join points of the path only.
pub fn shortcut(prover: &mut Prover, points: &mut Vec<Vec<f64>>, rng: &mut ChaCha8Rng) {
    let attempts = MIN_ATTEMPTS.max(ATTEMPTS_PER_POINT * points.len());
    for _ in 0..attempts {
        if points.len() < 3 || prover.is_spent() {
            return;
        }
        let first = rng.random_range(0..points.len() - 2);
        let last = rng.random_range(first + 2..points.len());
        if prover.proves(&points[first], &points[last]) {
            points.drain(first + 1..last);
        }
    }
    let mut at = 0;
    while at + 2 < points.len() && !prover.is_spent() {
        if prover.proves(&points[at], &points[at + 2]) {
            points.remove(at + 1);
        } else {
            at += 1;
        }
    }
}

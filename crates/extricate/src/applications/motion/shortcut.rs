//! Shorter paths: edges between points that were not neighbours, where they are proved.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::prover::Prover;

/// Attempts for each point of the path, and the fewest. More shorten what trees give by less than a
/// hundredth each.
const ATTEMPTS_A_POINT: usize = 2;
const LEAST_ATTEMPTS: usize = 10;

/// Removes points that are not needed: edges between random points, then from each point to the one
/// after its neighbour.
///
/// # Guarantee
/// Every edge of the result is proved, where those of the path are. The ends stay.
///
/// # Source
/// The shortcut heuristic as R. Geraerts and M. H. Overmars describe it, "Creating high-quality
/// paths for motion planning", IJRR 26(8), 2007, doi:10.1177/0278364907079280. Here between points
/// of the path alone.
pub fn shortcut(prover: &mut Prover, points: &mut Vec<Vec<f64>>, rng: &mut ChaCha8Rng) {
    let attempts = LEAST_ATTEMPTS.max(ATTEMPTS_A_POINT * points.len());
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

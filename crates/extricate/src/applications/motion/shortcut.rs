//! Shortens paths by proved edges.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::prover::Prover;
use crate::cspace::ConfigSpace;
use crate::metric::Metric;

/// Attempts to join points for each point of the path, and the fewest.
const ATTEMPTS_PER_POINT: usize = 2;
const MIN_ATTEMPTS: usize = 10;
/// Shortening ends after this many attempts in a row that shorten nothing.
const MAX_MISSES: usize = 24;
/// An attempt is made only if it shortens the path by at least this share of its length.
const MIN_GAIN_SHARE: f64 = 2e-3;

/// Shortens a path: joins its points by edges, then cuts from anywhere on one edge to anywhere on
/// another, in all joints or in one alone.
///
/// # Guarantee
/// Every edge of the result is proved if all edges of the path are. The ends stay, and the path
/// never becomes longer.
///
/// # Source
/// The shortcut and the partial shortcut of R. Geraerts and M. H. Overmars, "Creating high-quality
/// paths for motion planning", IJRR 26(8), 2007, doi:10.1177/0278364907079280.
pub fn shortcut(prover: &mut Prover, metric: &Metric, points: &mut Vec<Vec<f64>>, rng: &mut ChaCha8Rng) {
    // Edges that keep links have many points, and joining two of them takes many checks.
    let per_point = if prover.is_held() { 0 } else { ATTEMPTS_PER_POINT };
    let attempts = MIN_ATTEMPTS.max(per_point * points.len());
    for _ in 0..attempts {
        if points.len() < 3 || prover.is_spent() {
            return;
        }
        let first = rng.random_range(0..points.len() - 2);
        let last = rng.random_range(first + 2..points.len());
        if let Some(way) = prover.join(&points[first], &points[last])
            && (way.len() == 1
                || length(metric, &points[first], &way) < length(metric, &points[first], &points[first + 1..=last]))
        {
            points.splice(first + 1..=last, way);
        }
    }
    let mut misses = 0;
    while misses < MAX_MISSES && points.len() > 2 && !prover.is_spent() {
        misses = if cut(prover, metric, points, rng) { 0 } else { misses + 1 };
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

/// Draws two configurations on different edges, and replaces what is between them by a geodesic, in
/// all factors of the space or in one of them. Returns whether that is shorter and proved.
fn cut(prover: &mut Prover, metric: &Metric, points: &mut Vec<Vec<f64>>, rng: &mut ChaCha8Rng) -> bool {
    let space = &prover.checker.scene().space;
    let lengths: Vec<f64> = points.windows(2).map(|edge| metric.distance(&edge[0], &edge[1])).collect();
    let total: f64 = lengths.iter().sum();
    let mut drawn = [rng.random::<f64>() * total, rng.random::<f64>() * total];
    drawn.sort_by(f64::total_cmp);
    let factor = rng.random_bool(0.5).then(|| rng.random_range(0..space.factors().len()));
    // With one factor replaced, a configuration does not keep its links.
    let factor = factor.filter(|_| !prover.is_held());
    let [(first, from), (last, to)] = drawn.map(|along| at_length(space, points, &lengths, along));
    if first == last {
        return false;
    }
    let mut between = vec![from, to];
    if let Some(factor) = factor.map(|factor| &space.factors()[factor]) {
        let mut whole = points[first + 1..=last].to_vec();
        let (mut along, mut straight) = (-drawn[0] + lengths[..first].iter().sum::<f64>(), vec![0.0; space.nq()]);
        for (point, length) in whole.iter_mut().zip(&lengths[first..]) {
            along += length;
            let share = along / (drawn[1] - drawn[0]);
            space.interpolate(&between[0], &between[1], share.clamp(0.0, 1.0), &mut straight);
            point[factor.coordinates()].copy_from_slice(&straight[factor.coordinates()]);
        }
        between.splice(1..1, whole);
    }
    let most = lengths[first..=last].iter().sum::<f64>() - MIN_GAIN_SHARE * total;
    let ends = [points[first].clone(), points[last + 1].clone()];
    let is_short = |between: &[Vec<f64>]| length(metric, &ends[0], between.iter().chain(&ends[1..])) <= most;
    if !is_short(&between) {
        return false;
    }
    let Some(way) = joined(prover, &between).filter(|way| way.len() == between.len() || is_short(way)) else {
        return false;
    };
    // Parts of proved edges may be bisected at other places, so that they need proofs of their own.
    let is_proved = prover.proves(&ends[0], &way[0]) && prover.proves(&way[way.len() - 1], &ends[1]);
    if is_proved {
        points.splice(first + 1..=last, way);
    }
    is_proved
}

/// Returns configurations from the first to the last of some that lead from each to the next by
/// proved edges.
fn joined(prover: &mut Prover, points: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut way = vec![points[0].clone()];
    for edge in points.windows(2) {
        way.extend(prover.join(&edge[0], &edge[1])?);
    }
    Some(way)
}

/// Returns the length of a path from a configuration through others.
fn length<'a>(metric: &Metric, from: &'a [f64], to: impl IntoIterator<Item = &'a Vec<f64>>) -> f64 {
    let mut before = from;
    let step = |next: &'a Vec<f64>| metric.distance(std::mem::replace(&mut before, next), next);
    to.into_iter().map(step).sum()
}

/// Returns the edge that has the place `along` a path, and the configuration there.
fn at_length(space: &ConfigSpace, points: &[Vec<f64>], lengths: &[f64], mut along: f64) -> (usize, Vec<f64>) {
    let mut edge = 0;
    while edge + 1 < lengths.len() && along > lengths[edge] {
        along -= lengths[edge];
        edge += 1;
    }
    let mut q = vec![0.0; space.nq()];
    let share = if lengths[edge] > 0.0 { (along / lengths[edge]).min(1.0) } else { 0.0 };
    space.interpolate(&points[edge], &points[edge + 1], share, &mut q);
    (edge, q)
}

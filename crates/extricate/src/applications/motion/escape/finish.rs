//! Finds from where on a path is free, and measures it.

use super::options::{Escape, EscapeMethod, found_nothing};
use super::search::Search;
use crate::applications::motion::path;
use crate::applications::motion::prover::Prover;
use crate::collision::signed_distances_of;
use crate::query::Deadline;

/// Factor by which the search for the free part is coarser than proofs of edges.
const COARSENING_FACTOR: f64 = 10.0;
/// Configurations of an edge at which depths are measured.
const SAMPLES_PER_EDGE: usize = 4;

/// Splits the path where its free part begins, and measures it.
pub fn finish(search: Search, mut points: Vec<Vec<f64>>, method: EscapeMethod) -> Escape {
    let Search { context, q, options, relaxed, prover: mut inside, .. } = search;
    let mut outside = Prover::new(context.checker, COARSENING_FACTOR * options.resolution, Deadline::default());
    let space = &context.checker.scene().space;
    let mut first = points.len() - 1;
    // The end counts as free only because the scene's own checker says so.
    if !outside.holds(&points[first]) {
        return found_nothing(&relaxed.colliding, inside.checks + outside.checks);
    }
    while first > 0 {
        let free = outside.proved_until(&points[first], &points[first - 1]);
        if free < 1.0 {
            let mut border = vec![0.0; q.len()];
            space.interpolate(&points[first], &points[first - 1], free, &mut border);
            // A part of a proved edge is proved: it is the same geodesic up to rounding, which
            // proofs allow for.
            if free > 0.0 {
                points.insert(first, border);
            }
            break;
        }
        first -= 1;
    }
    let (mut deepening, mut p) = (0.0, vec![0.0; q.len()]);
    let pairs: Vec<_> = relaxed.colliding.iter().map(|(pair, _)| *pair).collect();
    for (a, b) in points.iter().zip(points.iter().skip(1)).take(first) {
        for sample in 1..=SAMPLES_PER_EDGE {
            space.interpolate(a, b, sample as f64 / SAMPLES_PER_EDGE as f64, &mut p);
            inside.checks += 1;
            let distances = signed_distances_of(context.checker, &p, &pairs, inside.scratch());
            let deeper = relaxed.colliding.iter().zip(distances).map(|((_, before), now)| before - now);
            deepening = deeper.fold(deepening, f64::max);
        }
    }
    let flat = points.concat();
    Escape {
        free_from: first,
        method: Some(method),
        colliding: relaxed.colliding.clone(),
        deepening,
        needed_tolerance: None,
        length: path::length(context.metric, &flat, q.len()),
        max_displacement: path::max_displacement(context.metric, q, &flat),
        checks: inside.checks + outside.checks,
        points,
    }
}

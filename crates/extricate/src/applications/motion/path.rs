//! Measures of a path, which is given as rows of configurations.

use crate::metric::{Anchor, Metric, MetricScratch};

/// Returns the length of a polyline in the metric: the sum over its edges.
pub fn length(metric: &Metric, points: &[f64], nq: usize) -> f64 {
    let edges = points.chunks_exact(nq).zip(points.chunks_exact(nq).skip(1));
    edges.map(|(a, b)| metric.distance(a, b)).sum()
}

/// Returns the largest displacement \[m\] of any point of the moving geometry between `q` and any
/// point of a path.
pub fn max_displacement(metric: &Metric, q: &[f64], points: &[f64]) -> f64 {
    let (mut anchor, mut scratch) = (Anchor::default(), MetricScratch::default());
    metric.anchor(q, &mut anchor);
    let displaced = points.chunks_exact(q.len()).map(|p| metric.max_displacement_from(&anchor, p, &mut scratch));
    displaced.fold(0.0, f64::max)
}

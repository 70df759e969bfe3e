//! Traces the boundary from colliding configurations to verified free ones close to it.

use rayon::prelude::*;

use super::{BoundaryScratch, SampleQuery, SampleSet};
use crate::cspace::sampling::Halton;
use crate::cspace::{ConfigSpace, Label};
use crate::learning::exploration::{BATCH, Exploration, ROWS_A_TASK};
use crate::learning::{Budget, LabelBatch};
use crate::math::elementary::log2;
use crate::metric::{Anchor, Metric};

/// The inputs that all steps of tracing share.
pub struct TraceInputs<'a> {
    /// The configuration space of the scene.
    pub space: &'a ConfigSpace,
    /// Metric that measures distances between configurations.
    pub metric: &'a Metric,
    /// Returns exact labels of configurations.
    pub label: &'a LabelBatch<'a>,
    /// Sequence that further configurations are drawn from.
    pub halton: &'a Halton,
    /// Every sample has a colliding configuration within this distance (metric units).
    pub gap: f64,
    /// Seed of the sample index.
    pub seed: u64,
}

/// Most halvings of a segment: enough for any gap above 2^-40 of the space's diameter.
const MAX_HALVINGS: u32 = 40;
/// Seeds of the first pass. Each later pass takes twice as many, up to [`BATCH`], so that a short
/// budget is spent on whole passes.
const FIRST_PASS_SEEDS: usize = 256;

/// Traces the boundary from the configurations of `known`, at least one of which is free, until the
/// share `by` of the budget is spent. Returns boundary samples, row major.
///
/// Every colliding seed is joined to the nearest known free configuration and to the nearest
/// boundary sample found so far; both segments are halved toward the boundary. The samples thus lie
/// where random colliding configurations have exits, and each pass starts from better samples.
/// Seeds are taken in the order of `known`, to which further ones are added if they run out.
///
/// One pass is made even if that share is spent already, or if time or the caller ended the budget:
/// without it, nothing would be known of the boundary. If the share is spent, the pass takes at
/// most half of the labels left. The limit in labels always holds.
///
/// # Guarantee
/// Every sample was labelled free, and some configuration within the gap of it was labelled
/// colliding.
pub fn trace(inputs: &TraceInputs, known: &mut Exploration, by: f64, budget: &mut Budget) -> Vec<f64> {
    let nq = inputs.space.nq();
    let until = (by * (budget.spent() as f64 + budget.left() as f64)) as usize;
    let set = |configs: &[f64]| SampleSet::new(inputs.metric, nq, configs.to_vec(), inputs.seed);
    let free = set(&known.free[..known.free.len().min(MAX_FREE_STARTS * nq)]);
    let (mut samples, mut traced, mut seeds_used, mut most_seeds) =
        (Vec::new(), None::<SampleSet>, 0, FIRST_PASS_SEEDS);
    while budget.left() > 0 {
        let left = match until.saturating_sub(budget.spent()) {
            0 => budget.left() / 2,
            left => left,
        };
        if known.colliding.len() / nq < seeds_used + most_seeds {
            // New seeds get at most a quarter of the labels left; halving needs the others.
            known.extend(inputs.space, inputs.halton, (left / 4).clamp(1, BATCH), inputs.label, budget);
        }
        let last = (seeds_used + most_seeds).min(known.colliding.len() / nq);
        let seeds = &known.colliding[seeds_used * nq..last * nq];
        (seeds_used, most_seeds) = (last, (2 * most_seeds).min(BATCH));
        let (mut near, mut far) = segments(inputs.metric, [Some(&free), traced.as_ref()], seeds, nq);
        let is_paid = halve(inputs, (&mut near, &mut far), left, samples.is_empty(), budget);
        samples.extend_from_slice(&near);
        budget.note(samples.len() / nq, None);
        if !is_paid || budget.end().is_some() || budget.spent() >= until || budget.fraction() >= by {
            break;
        }
        if traced.as_ref().is_none_or(|set| 2 * set.len() <= samples.len() / nq) && !samples.is_empty() {
            traced = Some(set(&samples));
        }
    }
    samples
}

/// Returns the segments from the nearest sample of each set to each seed: their free and their
/// colliding ends, row major.
fn segments(metric: &Metric, sets: [Option<&SampleSet>; 2], seeds: &[f64], nq: usize) -> (Vec<f64>, Vec<f64>) {
    let starts: Vec<[Option<Vec<f64>>; 2]> = seeds
        .par_chunks_exact(nq)
        .map_init(Default::default, |scratch: &mut (BoundaryScratch, Anchor, Vec<(u32, f64)>), seed| {
            sets.map(|set| nearest(metric, set?, seed, scratch))
        })
        .collect();
    let (mut near, mut far) = (Vec::new(), Vec::new());
    for (seed, start) in seeds.chunks_exact(nq).zip(&starts) {
        for start in start.iter().flatten() {
            near.extend_from_slice(start);
            far.extend_from_slice(seed);
        }
    }
    (near, far)
}

/// Most free configurations used as starts; more gain little once there are boundary samples.
const MAX_FREE_STARTS: usize = 50_000;

fn nearest(
    metric: &Metric,
    set: &SampleSet,
    seed: &[f64],
    (scratch, anchor, out): &mut (BoundaryScratch, Anchor, Vec<(u32, f64)>),
) -> Option<Vec<f64>> {
    metric.anchor(seed, anchor);
    set.nearest(SampleQuery::NEAREST, metric, anchor, 1, scratch, out);
    out.first().map(|(id, _)| set.config(*id).to_vec())
}

/// Halves every segment from a `free` row to the `colliding` row beside it, in lockstep, until the
/// longest is below the gap.
///
/// Segments that `most` labels cannot pay for are not begun; returns whether all were. If the
/// budget ends on the way, segments that are still longer than the gap are dropped. With `finish`,
/// they are halved to the end, as far as labels are left.
fn halve(
    inputs: &TraceInputs,
    (free, colliding): (&mut Vec<f64>, &mut Vec<f64>),
    most: usize,
    finish: bool,
    budget: &mut Budget,
) -> bool {
    let nq = inputs.space.nq();
    let affordable = |longest: f64, left: usize| {
        let halvings = log2(longest / inputs.gap).ceil().max(1.0);
        if halvings.is_finite() { left / halvings as usize } else { left }
    };
    let (mut middles, mut paid) = (Vec::new(), true);
    for halvings in 0..MAX_HALVINGS {
        let lengths: Vec<f64> = free
            .par_chunks_exact(nq)
            .zip(colliding.par_chunks_exact(nq))
            .with_min_len(ROWS_A_TASK)
            .map(|(a, b)| inputs.metric.distance(a, b))
            .collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        if longest <= inputs.gap {
            return paid;
        }
        if halvings == 0 {
            let rows = lengths.len().min(affordable(longest, most));
            paid = rows == lengths.len();
            free.truncate(rows * nq);
            colliding.truncate(rows * nq);
        }
        let rows = free.len() / nq;
        if rows > budget.left() || (budget.end().is_some() && !finish) {
            let kept = lengths.iter().take(rows).map(|length| *length <= inputs.gap);
            let kept = free.chunks_exact(nq).zip(kept).filter(|(_, kept)| *kept);
            *free = kept.flat_map(|(row, _)| row.iter().copied()).collect();
            return paid;
        }
        middles.resize(free.len(), 0.0);
        let ends = free.par_chunks_exact(nq).zip(colliding.par_chunks_exact(nq));
        let halved = ends.zip(middles.par_chunks_exact_mut(nq)).with_min_len(ROWS_A_TASK);
        halved.for_each(|((a, b), middle)| inputs.space.interpolate(a, b, 0.5, middle));
        for (row, label) in budget.label(inputs.label, &middles).into_iter().enumerate() {
            let side = if label == Label::Free { &mut *free } else { &mut *colliding };
            side[row * nq..(row + 1) * nq].copy_from_slice(&middles[row * nq..(row + 1) * nq]);
        }
    }
    paid
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::scene::builtin;
    use std::ops::ControlFlow;
    use std::sync::Arc;

    /// The obstacle region is a disc of radius 1: every sample lies just outside of its circle.
    #[test]
    fn samples_lie_outside_a_disc_within_the_gap() {
        let scene = builtin::scene("planar-arm").unwrap();
        let nq = scene.space.nq();
        let metric = Metric::new(Arc::new(scene.clone()));
        let radius = |q: &[f64]| q[..2].iter().map(|x| x * x).sum::<f64>().sqrt();
        let label = |configs: &[f64]| {
            let of = |q: &[f64]| if radius(q) < 1.0 { Label::Colliding } else { Label::Free };
            configs.chunks_exact(nq).map(of).collect()
        };
        let mut report = |_: &_| ControlFlow::Continue(());
        let mut budget =
            Budget::new(&LearnOptions { labels: 60_000, seconds: None, ..Default::default() }, &mut report);
        let halton = Halton::new(scene.space.nv(), 1);
        let mut known = Exploration::default();
        known.extend(&scene.space, &halton, 8000, &label, &mut budget);
        let inputs =
            TraceInputs { space: &scene.space, metric: &metric, label: &label, halton: &halton, gap: 0.01, seed: 1 };
        let samples = trace(&inputs, &mut known, 1.0, &mut budget);
        assert!(samples.len() / nq > 1000, "{}", samples.len() / nq);
        for q in samples.chunks_exact(nq) {
            assert!((1.0..1.0101).contains(&radius(q)), "{q:?}");
        }
        assert!(budget.spent() <= 60_000, "{}", budget.spent());
    }
}

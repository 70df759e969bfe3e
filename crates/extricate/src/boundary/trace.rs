//! Tracing the boundary: from colliding configurations to verified free ones right beside the obstacle region.

use rayon::prelude::*;

use super::{BoundaryScratch, SampleSet};
use crate::cspace::sampling::Halton;
use crate::cspace::{ConfigSpace, Label};
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::{Budget, LabelBatch};
use crate::metric::{Anchor, Metric};

/// What tracing stands on.
pub struct TraceGround<'a> {
    /// The configuration space.
    pub space: &'a ConfigSpace,
    /// Distances between configurations.
    pub metric: &'a Metric,
    /// Exact labels.
    pub label: &'a LabelBatch<'a>,
    /// Every sample gets a colliding configuration within this distance (metric units).
    pub gap: f64,
    /// For the index.
    pub seed: u64,
}

/// Most halvings of a segment: enough for any gap above 2^-40 of the space's diameter.
const MAX_HALVINGS: u32 = 40;

/// Spends the budget on boundary samples; returns them row major.
///
/// Every colliding seed is joined to the nearest known free configuration and to the nearest boundary sample found so far;
/// both segments are halved toward the seed. So the samples lie where the exits of random colliding configurations are, and
/// each pass starts from better ones. Seeds that the classifier gets wrong come first (`colliding` is in that order).
///
/// # Guarantee
/// Every row was labelled free, and some configuration within `gap` of it was labelled colliding.
pub fn trace(ground: &TraceGround, known: &mut Exploration, halton: &Halton, budget: &mut Budget) -> Vec<f64> {
    let nq = ground.space.nq();
    let mut samples: Vec<f64> = Vec::new();
    if known.free.is_empty() {
        return samples;
    }
    let free = SampleSet::new(ground.metric, nq, thin(&known.free, nq, MOST_FREE), ground.seed);
    let mut traced: Option<SampleSet> = None;
    let mut seeds_used = 0;
    while budget.end().is_none() {
        if known.colliding.len() / nq < seeds_used + BATCH {
            known.extend(ground.space, halton, BATCH, ground.label, budget);
        }
        let until = (seeds_used + BATCH).min(known.colliding.len() / nq);
        let seeds = &known.colliding[seeds_used * nq..until * nq];
        seeds_used = until;
        let starts: Vec<[Option<Vec<f64>>; 2]> = seeds
            .par_chunks_exact(nq)
            .map_init(Default::default, |scratch: &mut (BoundaryScratch, Anchor, Vec<(u32, f64)>), seed| {
                [Some(&free), traced.as_ref()].map(|set| nearest(ground.metric, set?, seed, scratch))
            })
            .collect();
        let (mut near, mut far) = (Vec::new(), Vec::new());
        for (seed, start) in seeds.chunks_exact(nq).zip(&starts) {
            for start in start.iter().flatten() {
                near.extend_from_slice(start);
                far.extend_from_slice(seed);
            }
        }
        halve(ground, &mut near, &mut far, budget);
        samples.extend_from_slice(&near);
        budget.note(samples.len() / nq, None);
        if traced.as_ref().is_none_or(|set| 2 * set.len() <= samples.len() / nq) {
            traced = Some(SampleSet::new(ground.metric, nq, samples.clone(), ground.seed));
        }
    }
    samples
}

/// Free configurations kept as starts; more cost search time and gain little once boundary samples are there.
const MOST_FREE: usize = 50_000;

fn thin(configs: &[f64], nq: usize, most: usize) -> Vec<f64> {
    configs[..configs.len().min(most * nq)].to_vec()
}

fn nearest(
    metric: &Metric,
    set: &SampleSet,
    seed: &[f64],
    (scratch, anchor, out): &mut (BoundaryScratch, Anchor, Vec<(u32, f64)>),
) -> Option<Vec<f64>> {
    metric.anchor(seed, anchor);
    set.nearest(metric, anchor, 1, scratch, out);
    out.first().map(|(id, _)| set.config(*id).to_vec())
}

/// Halves every segment from a `free` row to the `colliding` row beside it, in lockstep, until the longest is below the gap.
fn halve(ground: &TraceGround, free: &mut [f64], colliding: &mut [f64], budget: &mut Budget) {
    let nq = ground.space.nq();
    let mut middles = vec![0.0; free.len()];
    for _ in 0..MAX_HALVINGS {
        let longest = free
            .par_chunks_exact(nq)
            .zip(colliding.par_chunks_exact(nq))
            .map(|(a, b)| ground.metric.distance(a, b))
            .reduce(|| 0.0, f64::max);
        if longest <= ground.gap {
            return;
        }
        let rows = free.chunks_exact(nq).zip(colliding.chunks_exact(nq));
        for ((a, b), middle) in rows.zip(middles.chunks_exact_mut(nq)) {
            ground.space.interpolate(a, b, 0.5, middle);
        }
        for (row, label) in budget.label(ground.label, &middles).into_iter().enumerate() {
            let side = if label == Label::Free { &mut *free } else { &mut *colliding };
            side[row * nq..(row + 1) * nq].copy_from_slice(&middles[row * nq..(row + 1) * nq]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::scene::builtin;
    use std::ops::ControlFlow;
    use std::sync::Arc;

    /// A disc of radius 1 as obstacle region in a square: every sample lies on the circle from outside.
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
        let ground = TraceGround { space: &scene.space, metric: &metric, label: &label, gap: 0.01, seed: 1 };
        let samples = trace(&ground, &mut known, &halton, &mut budget);
        assert!(samples.len() / nq > 1000, "{}", samples.len() / nq);
        for q in samples.chunks_exact(nq) {
            assert!((1.0..1.0101).contains(&radius(q)), "{q:?}");
        }
    }
}

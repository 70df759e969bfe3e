//! PairDirection of the stored samples that a search starts from: the nearest, no two alike.

use crate::math::linear_algebra::dot;
use crate::metric::Anchor;
use crate::query::context::Context;
use crate::query::local_metric::LocalMetric;
use crate::query::plan::Plan;
use crate::samples::{BoundaryScratch, SampleKind, SampleQuery};

/// Candidates for each start: near samples lie in crowds, of which one start is enough.
const CANDIDATES_PER_START: usize = 4;

/// Stored samples near the query, no two alike.
#[derive(Default)]
pub struct StoredStarts {
    /// Candidates for starts, nearest first, with their distances; with squared distances in the
    /// other coordinates if joints are locked.
    pub near: Vec<(u32, f64)>,
    visited: usize,
    pub chosen: Vec<u32>,
    /// Coordinates of the chosen ones in which the local metric is the identity.
    places: Vec<f64>,
    config: Vec<f64>,
    /// Indices of the factors that are not locked.
    moving: Vec<usize>,
    pub is_gathered: bool,
}

impl StoredStarts {
    pub fn reset(&mut self) {
        (self.visited, self.is_gathered) = (0, false);
        self.near.clear();
        self.chosen.clear();
        self.places.clear();
    }

    /// Gathers candidates for `plan.stored` starts. If joints are locked, only the distance in the
    /// other coordinates counts.
    pub fn gather(&mut self, context: &Context, plan: &Plan, q: &Anchor, scratch: &mut BoundaryScratch) {
        self.is_gathered = true;
        let Some(stored) = context.stored else { return };
        let (samples, count) = (stored.samples, CANDIDATES_PER_START * plan.stored);
        let among = if samples.solved() == 0 { SampleKind::All } else { SampleKind::Solved };
        if context.locked.is_empty() {
            let wanted = SampleQuery { among, care: plan.care, ..SampleQuery::NEAREST };
            return samples.nearest(wanted, context.metric, q, count, scratch, &mut self.near);
        }
        let factors = context.checker.scene().space.factors();
        self.moving.clear();
        self.moving.extend((0..factors.len()).filter(|k| !context.is_locked(factors[*k].v)));
        let first = if among == SampleKind::All { 0 } else { samples.len() - samples.solved() };
        for id in first as u32..samples.len() as u32 {
            let config = samples.config(id);
            // Most samples exceed the limit after a coordinate or two.
            let limit = if self.near.len() < count { f64::INFINITY } else { self.near[count - 1].1 };
            let mut squared = 0.0;
            for &factor in &self.moving {
                squared += factors[factor].distance_squared(&q.q, config);
                if squared >= limit {
                    break;
                }
            }
            if squared < limit {
                self.near.truncate(count - 1);
                let at = self.near.partition_point(|near| near.1 <= squared);
                self.near.insert(at, (id, squared));
            }
        }
    }

    /// Chooses the next candidate that is unlike all chosen samples; returns whether there was one.
    pub fn choose_next(
        &mut self,
        context: &Context,
        plan: &Plan,
        (q, rest): (&[f64], &[f64]),
        local: &mut LocalMetric,
    ) -> bool {
        let (space, samples) = (&context.checker.scene().space, context.stored.map(|stored| stored.samples));
        while let Some((&(id, _), samples)) = self.near.get(self.visited).zip(samples) {
            self.visited += 1;
            self.config.clear();
            self.config.extend_from_slice(samples.config(id));
            context.hold(rest, &mut self.config);
            let before = self.places.len();
            local.flatten(space, q, &self.config, &mut self.places);
            let (chosen, place) = self.places.split_at(before);
            let squared = |other: &[f64]| other.iter().zip(place).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            let reach = plan.spread * plan.spread * dot(place, place);
            if chosen.chunks_exact(space.nv()).all(|other| squared(other) > reach) {
                self.chosen.push(id);
                return true;
            }
            self.places.truncate(before);
        }
        false
    }
}

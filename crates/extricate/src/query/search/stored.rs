//! Which stored samples a search starts from: the nearest, no two alike.

use crate::math::linear_algebra::dot;
use crate::metric::Anchor;
use crate::query::context::Context;
use crate::query::local_metric::LocalMetric;
use crate::query::plan::Plan;
use crate::samples::{BoundaryScratch, SampleKind, SampleQuery};

/// Stored samples that are looked at for each that is started from.
const LOOKED_AT: usize = 4;

/// Stored samples near the query, no two alike.
#[derive(Default)]
pub struct StoredStarts {
    /// Samples that starts are chosen of, with their distances, nearest first.
    pub near: Vec<(u32, f64)>,
    looked_at: usize,
    pub chosen: Vec<u32>,
    /// Coordinates of the chosen ones in which the local metric is the identity.
    places: Vec<f64>,
    config: Vec<f64>,
    pub is_gathered: bool,
}

impl StoredStarts {
    /// Forgets those of another search.
    pub fn reset(&mut self) {
        (self.looked_at, self.is_gathered) = (0, false);
        self.near.clear();
        self.chosen.clear();
        self.places.clear();
    }

    /// Gathers samples that `plan.stored` starts are chosen of. If joints are held still, those
    /// whose other coordinates are near count.
    pub fn gather(&mut self, context: &Context, plan: &Plan, q: &Anchor, scratch: &mut BoundaryScratch) {
        self.is_gathered = true;
        let Some(stored) = context.stored else { return };
        let (samples, count) = (stored.samples, LOOKED_AT * plan.stored);
        let among = if samples.solved() == 0 { SampleKind::All } else { SampleKind::Solved };
        if context.locked.is_empty() {
            let wanted = SampleQuery { among, care: plan.care, ..SampleQuery::NEAREST };
            return samples.nearest(wanted, context.metric, q, count, scratch, &mut self.near);
        }
        let factors = context.checker.scene().space.factors();
        let first = if among == SampleKind::All { 0 } else { samples.len() - samples.solved() };
        let distance = |id: usize| {
            let moving = factors.iter().filter(|factor| !context.is_locked(factor.v));
            moving.map(|factor| factor.distance_squared(&q.q, samples.config(id as u32))).sum::<f64>()
        };
        self.near.extend((first..samples.len()).map(|id| (id as u32, distance(id))));
        let order = |a: &(u32, f64), b: &(u32, f64)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0));
        if count < self.near.len() {
            self.near.select_nth_unstable_by(count, order);
            self.near.truncate(count);
        }
        self.near.sort_unstable_by(order);
    }

    /// Chooses the next sample that is unlike all that were chosen; whether there is one.
    pub fn choose_next(
        &mut self,
        context: &Context,
        plan: &Plan,
        (q, rest): (&[f64], &[f64]),
        local: &mut LocalMetric,
    ) -> bool {
        let (space, samples) = (&context.checker.scene().space, context.stored.map(|stored| stored.samples));
        while let Some((&(id, _), samples)) = self.near.get(self.looked_at).zip(samples) {
            self.looked_at += 1;
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

//! Where descents start: stored samples near the query, solved ones before others, nearest first,
//! no two alike.

pub mod around;
pub mod directions;
pub mod first_witness;

use super::context::Context;
use super::plan::Plan;
use super::search::local_metric::LocalMetric;
use crate::cspace::Factor;
use crate::math::linear_algebra::dot;
use crate::metric::Anchor;
use crate::samples::contact_planes::Elsewhere;
use crate::samples::{BoundaryScratch, SampleKind, SampleQuery};

/// So many solved samples have to be known for one to be started from: with few, the nearest are
/// far.
const KNOWN_A_START: usize = 8;
/// Nearest samples that are looked at for one that is chosen.
const LOOKED_AT: usize = 2;
/// The same where other samples are started from too, which lie in crowds along the boundary.
const LOOKED_AT_IN_CROWDS: usize = 6;

/// What starts are chosen for.
#[derive(Clone, Copy)]
pub struct Ask<'a> {
    /// What the search stands on.
    pub context: &'a Context<'a>,
    /// How many, and how unlike.
    pub plan: &'a Plan,
    /// The query.
    pub anchor: &'a Anchor,
    /// Set in a search over some of the joints.
    pub part: Option<PartOf<'a>>,
}

/// Some of the joints: which, and where the others stay.
#[derive(Clone, Copy)]
pub struct PartOf<'a> {
    /// The factors of the space, and which of them are searched over.
    pub all: &'a [Factor],
    pub searched: &'a [usize],
    /// Where the others stay.
    pub base: &'a [f64],
    /// Of which pairs stored contact planes hold, whatever the others do.
    pub holding: Elsewhere<'a>,
}

impl<'a> PartOf<'a> {
    /// The factors that are searched over.
    pub fn factors(&self) -> impl Iterator<Item = &'a Factor> + use<'a> {
        let all = self.all;
        self.searched.iter().map(|at| &all[*at])
    }

    /// How many degrees of freedom they have.
    pub fn degrees(&self) -> usize {
        self.factors().map(|factor| factor.manifold.dimensions()).sum()
    }

    /// The base with the part's coordinates of `from`.
    pub fn compose(&self, from: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(self.base);
        for factor in self.factors() {
            let coordinates = factor.coordinates();
            out[coordinates.clone()].copy_from_slice(&from[coordinates]);
        }
    }
}

/// With fewer solved samples, a search over a part looks among all.
const MANY_SOLVED: usize = 256;
/// Most samples that it looks at: the coordinates of a part are few.
const MOST_SCANNED: usize = 4096;

/// The starts of one search, nearest first.
#[derive(Default)]
pub struct Starts {
    /// The samples that were chosen.
    pub chosen: Vec<u32>,
    /// Their flat coordinates, row major.
    places: Vec<f64>,
    /// The samples they are chosen of, with their distances, nearest first, and how many of them
    /// were looked at.
    near: Vec<(u32, f64)>,
    /// Memory to gather them.
    found: Vec<(u32, f64)>,
    others: Vec<(u32, f64)>,
    looked_at: usize,
    composed: Vec<f64>,
    /// How many starts the samples were gathered for.
    gathered_for: usize,
}

/// How many of `count` starts are solved samples.
fn solved_of(context: &Context, count: usize) -> usize {
    count.min(context.samples().solved() / KNOWN_A_START)
}

/// Of which samples the nearest is what a search of so many starts begins with.
pub fn begins_among(context: &Context, count: usize) -> SampleKind {
    if count > 0 && solved_of(context, count) == count { SampleKind::Solved } else { SampleKind::All }
}

impl Starts {
    /// Forgets those of another search.
    pub fn reset(&mut self) {
        self.chosen.clear();
        self.places.clear();
        self.near.clear();
        (self.looked_at, self.gathered_for) = (0, 0);
    }

    /// Gathers samples that `count` starts are chosen of, nearest first, behind those that were
    /// gathered before.
    pub fn gather(&mut self, ask: &Ask, count: usize, scratch: &mut BoundaryScratch) {
        let &Ask { context, plan, anchor, .. } = ask;
        self.gathered_for = count;
        let Self { near, found, others, .. } = self;
        let (samples, solved) = (context.samples(), solved_of(context, count));
        let wanted = SampleQuery { among: SampleKind::Solved, care: plan.care, ..SampleQuery::NEAREST };
        samples.nearest(wanted, context.metric, anchor, LOOKED_AT * solved, scratch, found);
        if solved < count || count == 0 {
            let more = (LOOKED_AT_IN_CROWDS * (count - solved)).max(1);
            let wanted = SampleQuery { among: SampleKind::All, ..wanted };
            samples.nearest(wanted, context.metric, anchor, more, scratch, others);
            found.append(others);
            found.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            found.dedup();
        }
        let known = near.len();
        for new in found.iter() {
            if !near[..known].iter().any(|old| old.0 == new.0) {
                near.push(*new);
            }
        }
    }

    /// The nearest of all samples, where only solved ones were gathered and it is nearer than
    /// `depth`: no effort answers with more than effort `nearest`.
    pub fn nearer_sample(&mut self, ask: &Ask, depth: f64, scratch: &mut BoundaryScratch) -> Option<(u32, f64)> {
        let &Ask { context, plan, anchor, .. } = ask;
        if begins_among(context, plan.starts) == SampleKind::All {
            return None;
        }
        let wanted = SampleQuery { care: plan.care, ..SampleQuery::NEAREST };
        context.samples().nearest(wanted, context.metric, anchor, 1, scratch, &mut self.others);
        self.others.first().copied().filter(|nearest| nearest.1 < depth)
    }

    /// Gathers the samples whose coordinates of a part are nearest, wherever the others are: of all
    /// solved ones, or where those are few of all.
    pub fn gather_for_part(&mut self, ask: &Ask, part: &PartOf) {
        let samples = ask.context.samples();
        let first = if samples.solved() < MANY_SOLVED { 0 } else { samples.len() - samples.solved() };
        let stride = (samples.len() - first).div_ceil(MOST_SCANNED).max(1);
        let distance = |id: usize| {
            let config = samples.config(id as u32);
            part.factors().map(|factor| factor.distance_squared(&ask.anchor.q, config)).sum::<f64>()
        };
        let Self { near, gathered_for, .. } = self;
        near.extend((first..samples.len()).step_by(stride).map(|id| (id as u32, distance(id))));
        let order = |a: &(u32, f64), b: &(u32, f64)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0));
        let wanted = LOOKED_AT_IN_CROWDS * ask.plan.most_starts;
        if wanted < near.len() {
            near.select_nth_unstable_by(wanted, order);
            near.truncate(wanted);
        }
        near.sort_unstable_by(order);
        *gathered_for = ask.plan.most_starts;
    }

    /// The samples that starts are chosen of, with their distances, nearest first.
    pub fn near(&self) -> &[(u32, f64)] {
        &self.near
    }

    /// The start of rank `rank`, if there is one: as many as asked for are chosen when they are
    /// needed.
    pub fn get(
        &mut self,
        rank: usize,
        ask: &Ask,
        local: &mut LocalMetric,
        scratch: &mut BoundaryScratch,
    ) -> Option<u32> {
        while self.chosen.len() <= rank {
            if self.looked_at < self.near.len() {
                let id = self.near[self.looked_at].0;
                self.looked_at += 1;
                self.choose(ask, id, local);
            } else if self.gathered_for < ask.plan.most_starts && ask.part.is_none() {
                let more = (2 * self.gathered_for).clamp(rank + 1, ask.plan.most_starts);
                self.gather(ask, more, scratch);
            } else {
                return None;
            }
        }
        Some(self.chosen[rank])
    }

    /// Chooses a sample, unless it is too like a chosen one.
    fn choose(&mut self, ask: &Ask, id: u32, local: &mut LocalMetric) {
        let (space, spread) = (&ask.context.checker.scene().space, ask.plan.spread);
        let (nv, known) = (space.nv(), self.places.len());
        let config = match ask.part {
            Some(part) => {
                part.compose(ask.context.samples().config(id), &mut self.composed);
                &self.composed
            }
            None => ask.context.samples().config(id),
        };
        local.flatten(space, &ask.anchor.q, config, &mut self.places);
        let (before, place) = self.places.split_at(known);
        let squared = |other: &[f64]| other.iter().zip(place).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let reach = spread * spread * dot(place, place);
        if before.chunks_exact(nv).all(|other| squared(other) > reach) {
            self.chosen.push(id);
        } else {
            self.places.truncate(known);
        }
    }
}

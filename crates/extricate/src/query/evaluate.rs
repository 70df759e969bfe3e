//! The exact checks, contacts and distances of a query, counted against its budget.

use std::cell::Cell;

use super::keep::Projection;
use super::termination::Deadline;
use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch};
use crate::cspace::Label;
use crate::metric::{Anchor, MetricScratch};
use crate::query::context::Context;
use crate::scene::PairId;

/// The contact of a pair that has to stay in touch is searched within this distance \[m\].
const HELD_PAIR_MARGIN_M: f64 = 10.0;

/// Evaluates labels, contacts and distances, and remembers the latest.
#[derive(Default)]
pub struct Evaluator {
    pub check: CheckScratch,
    pub metric: MetricScratch,
    /// Exact checks and contact evaluations so far.
    pub checks: usize,
    /// Limits of the query.
    pub limit: Deadline,
    /// Checks that are kept in reserve to verify known exits.
    pub reserved: usize,
    /// Moves configurations to where links are kept.
    projection: Projection,
    /// Whether the search still lacks an exit. The budget then does not end it, since there would
    /// be no answer; only a stop does.
    pub needs_exit: bool,
    /// Whether the budget has ended any part of this query.
    is_cut: Cell<bool>,
    /// Contacts of the latest evaluation.
    pub contacts: Vec<Contact>,
    /// The configuration of `contacts`, if these are all its exact contacts within `exact_within`
    /// \[m\]; else empty.
    exact_at: Vec<f64>,
    exact_within: f64,
    /// The configuration that a check of this query last called free, else empty; and the clearance
    /// \[m\] that it was checked for.
    free_at: Vec<f64>,
    free_keeps: f64,
}

impl Evaluator {
    /// Begins a query with this limit, and counts the check of its configuration.
    pub fn begin(&mut self, limit: Deadline) {
        // Queries of a batch share one stop. Cloning it for each would make threads contend for its
        // reference count.
        if self.limit.stop == limit.stop {
            (self.limit.checks, self.limit.deadline) = (limit.checks, limit.deadline);
        } else {
            self.limit = limit;
        }
        self.check.forget_contacts();
        (self.checks, self.reserved, self.needs_exit) = (1, 0, false);
        self.is_cut.set(false);
        self.exact_at.clear();
        self.free_at.clear();
    }

    /// Begins the search of another group, whose checker checks other pairs.
    pub fn begin_group(&mut self) {
        self.check.forget_contacts();
        self.exact_at.clear();
        self.free_at.clear();
        (self.needs_exit, self.reserved) = (true, 0);
    }

    /// Records that `known` exits of the `wanted` ones are known.
    pub fn note_exits(&mut self, known: usize, wanted: usize) {
        self.needs_exit = known == 0;
        self.reserved = if wanted > 1 { known.min(wanted) } else { 0 };
    }

    /// Whether the budget is spent. Each step calls this before it begins, and does not begin if
    /// so.
    pub fn is_spent(&self) -> bool {
        let is_spent = match self.needs_exit {
            true => self.is_stopped(),
            false => self.limit.is_reached(self.checks + self.reserved),
        };
        self.is_cut.set(self.is_cut.get() || is_spent);
        is_spent
    }

    /// Whether [`Self::is_spent`] ended any step of this query.
    pub fn is_cut(&self) -> bool {
        self.is_cut.get()
    }

    pub fn is_stopped(&self) -> bool {
        self.limit.is_stopped()
    }

    /// Labels a configuration by an exact check, and counts it unless the last check that found a
    /// free configuration was of the same. A configuration beyond its limits, or at which a kept
    /// link is off or a pair that has to touch is apart, is not free.
    pub fn label(&mut self, context: &Context, q: &[f64]) -> Label {
        // The steps of a descent along meshes are checked, so its end is often known.
        if !self.free_at.is_empty() && self.free_keeps >= context.clearance && self.free_at == q {
            return Label::Free;
        }
        self.checks += 1;
        // Steps and stored samples keep the limits, but the guarantee of a witness must not rely on
        // that.
        if !context.checker.scene().space.is_within(q) {
            return Label::Colliding;
        }
        if !context.kept.is_empty() && !self.projection.keeps(context.checker.scene(), context.kept, q) {
            return Label::Colliding;
        }
        let label = context.checker.label(q, &mut self.check);
        if label == Label::Free && context.touching.are_required && self.largest_gap(context, q) > 0.0 {
            return Label::Colliding;
        }
        if label == Label::Free {
            self.free_at.clear();
            self.free_at.extend_from_slice(q);
            self.free_keeps = context.clearance;
        }
        label
    }

    /// Moves `q` to a configuration nearby that keeps the links; returns whether there is one.
    pub fn project(&mut self, context: &Context, q: &mut Vec<f64>) -> bool {
        context.kept.is_empty() || self.projection.project(context.checker.scene(), context.kept, context.locked, q)
    }

    /// Evaluates the contacts at `q`; returns by how much \[m\] the worst misses the clearance,
    /// negative if all keep it.
    pub fn contacts_at(&mut self, context: &Context, q: &[f64], query: ContactQuery) -> f64 {
        self.checks += 1;
        self.contacts.clear();
        self.exact_at.clear();
        if query.search == ContactSearch::Exact {
            self.exact_at.extend_from_slice(q);
            self.exact_within = context.checker.exact_within(query.margin);
        }
        context.checker.contacts(q, query, &mut self.check, &mut self.contacts);
        let least = self.contacts.iter().map(|c| c.distance).fold(query.margin, f64::min);
        let missed = context.clearance - least;
        context.touching.pairs.iter().fold(missed, |missed, pair| missed.max(self.too_far(context, q, *pair)))
    }

    /// Returns by how much \[m\] pairs that have to touch are too far apart; negative if all touch.
    pub fn largest_gap(&mut self, context: &Context, q: &[f64]) -> f64 {
        context.touching.pairs.iter().fold(f64::NEG_INFINITY, |most, pair| most.max(self.gap(context, q, *pair)))
    }

    /// Returns by how much \[m\] a pair that has to touch is too far apart; negative if it touches.
    pub fn gap(&mut self, context: &Context, q: &[f64], pair: PairId) -> f64 {
        self.contacts.clear();
        self.exact_at.clear();
        self.too_far(context, q, pair)
    }

    /// Returns by how much \[m\] a pair that has to stay in touch is too far apart. Adds its
    /// nearest contact if none is within the margin.
    fn too_far(&mut self, context: &Context, q: &[f64], pair: PairId) -> f64 {
        let known = self.contacts.iter().filter(|contact| contact.pair == pair).map(|contact| contact.distance);
        let mut nearest = known.fold(f64::INFINITY, f64::min);
        if nearest.is_infinite() {
            let query = ContactQuery { margin: HELD_PAIR_MARGIN_M, search: ContactSearch::Exact };
            let start = self.contacts.len();
            context.checker.contacts_of(q, pair, query, &mut self.check, &mut self.contacts);
            let found = &mut self.contacts[start..];
            found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            nearest = found.first().map_or(HELD_PAIR_MARGIN_M, |contact| contact.distance);
            self.contacts.truncate(start + 1);
        }
        nearest - context.touching.most
    }

    /// Returns the contacts nearer than `margin` \[m\] at `q`, ascending by pair. If they were
    /// known, `check` keeps the poses of its last configuration, which may differ from `q`.
    pub fn touching(&mut self, context: &Context, q: &[f64], margin: f64) -> &[Contact] {
        if self.exact_at == q && self.exact_within >= margin {
            self.contacts.retain(|contact| contact.distance < margin);
            self.exact_within = margin;
        } else {
            self.contacts_at(context, q, ContactQuery { margin, search: ContactSearch::Exact });
        }
        self.contacts.sort_by_key(|contact| contact.pair);
        &self.contacts
    }

    /// Returns the distance from the anchor (metric units).
    pub fn distance(&mut self, context: &Context, anchor: &Anchor, q: &[f64]) -> f64 {
        context.metric.distance_from(anchor, q, &mut self.metric)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::prepared::Prepared;
    use crate::scene::builtin;

    /// Steps and stored samples keep the limits; the check must hold if one does not.
    #[test]
    fn what_lies_beyond_limits_is_not_free() {
        let world = Prepared::new(builtin::scene("planar-arm").unwrap());
        let (mut evaluator, context) = (Evaluator::default(), world.context());
        evaluator.begin(Deadline::default());
        let straight = [1.9, 0.0, 0.0];
        assert_eq!(evaluator.label(&context, &straight), Label::Free);
        // Full turns that the joint cannot make give the same poses; the others give no poses.
        for (at, value) in [(1, std::f64::consts::TAU), (2, -std::f64::consts::TAU), (0, f64::NAN), (2, f64::INFINITY)]
        {
            let mut q = straight;
            q[at] = value;
            assert_eq!(evaluator.label(&context, &q), Label::Colliding, "{q:?}");
        }
    }
}

//! What a query asks of the exact checker, counted; and when it has asked enough.

use std::cell::Cell;

use super::termination::Deadline;
use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch};
use crate::cspace::Label;
use crate::metric::{Anchor, MetricScratch};
use crate::query::context::Context;
use crate::scene::PairId;

/// Contacts of a pair that is to stay in touch are looked for as far as this \[m\].
const WHEREVER: f64 = 10.0;

/// Labels, contacts and distances, and what the last of them were of.
#[derive(Default)]
pub struct Evaluator {
    /// For the exact checker.
    pub check: CheckScratch,
    /// For distances.
    pub metric: MetricScratch,
    /// Exact checks and contact evaluations so far.
    pub checks: usize,
    /// Where they end.
    pub limit: Deadline,
    /// Of these, how many are kept aside to check exits that are known.
    pub reserved: usize,
    /// Whether no exit is known yet: without one there is no answer, and only a stop ends the
    /// search for it.
    pub needs_exit: bool,
    /// Whether the budget has ended anything of this query.
    is_cut: Cell<bool>,
    /// Of the configuration whose contacts were evaluated last.
    pub contacts: Vec<Contact>,
    /// That configuration, where `contacts` are all its exact ones nearer than a margin \[m\]; else
    /// empty.
    exact_at: Vec<f64>,
    exact_within: f64,
    /// The configuration that a check of this query last called free, else empty; and the clearance
    /// that it was asked to keep \[m\].
    free_at: Vec<f64>,
    free_keeps: f64,
}

impl Evaluator {
    /// Begins a query, which may spend so much; the check of its configuration is counted.
    pub fn begin(&mut self, limit: Deadline) {
        // Queries of a batch share who may stop them: counting who holds it, each anew, would have
        // threads wait for each other.
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

    /// Begins the search of another group, whose checker looks at other pairs.
    pub fn begin_group(&mut self) {
        self.check.forget_contacts();
        self.exact_at.clear();
        self.free_at.clear();
        (self.needs_exit, self.reserved) = (true, 0);
    }

    /// Notes that so many exits are known, of those that are wanted.
    pub fn note_exits(&mut self, known: usize, wanted: usize) {
        self.needs_exit = known == 0;
        self.reserved = if wanted > 1 { known.min(wanted) } else { 0 };
    }

    /// Whether the budget is spent; whoever goes on asks, and ends if it is.
    pub fn is_spent(&self) -> bool {
        let is_spent = match self.needs_exit {
            true => self.is_stopped(),
            false => self.limit.is_reached(self.checks + self.reserved),
        };
        self.is_cut.set(self.is_cut.get() || is_spent);
        is_spent
    }

    /// Whether the budget was spent when something of this query would have gone on.
    pub fn is_cut(&self) -> bool {
        self.is_cut.get()
    }

    /// Whether the caller ended the query.
    pub fn is_stopped(&self) -> bool {
        self.limit.is_stopped()
    }

    /// An exact check, counted, unless the last one that found a free configuration was of the
    /// same. What lies beyond its limits is not free.
    pub fn label(&mut self, context: &Context, q: &[f64]) -> Label {
        // A descent along meshes has its steps checked; where it ends is then known.
        if !self.free_at.is_empty() && self.free_keeps >= context.clearance && self.free_at == q {
            return Label::Free;
        }
        self.checks += 1;
        // Steps and stored samples keep the limits; what a witness promises rests on neither.
        if !context.checker.scene().space.is_within(q) {
            return Label::Colliding;
        }
        let label = context.checker.label(q, &mut self.check);
        if label == Label::Free {
            self.free_at.clear();
            self.free_at.extend_from_slice(q);
            self.free_keeps = context.clearance;
        }
        label
    }

    /// Takes the contacts at `q`; returns by how much \[m\] the worst misses the clearance
    /// (negative: by how much it keeps it).
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
        context.held.pairs.iter().fold(missed, |missed, pair| missed.max(self.too_far(context, q, *pair)))
    }

    /// By how much \[m\] a pair that is to stay in touch is too far apart. Its nearest contact is
    /// added where it lies beyond the margin.
    fn too_far(&mut self, context: &Context, q: &[f64], pair: PairId) -> f64 {
        let known = self.contacts.iter().filter(|contact| contact.pair == pair).map(|contact| contact.distance);
        let mut nearest = known.fold(f64::INFINITY, f64::min);
        if nearest.is_infinite() {
            let (start, query) = (self.contacts.len(), ContactQuery { margin: WHEREVER, search: ContactSearch::Exact });
            context.checker.contacts_of(q, pair, query, &mut self.check, &mut self.contacts);
            let found = &mut self.contacts[start..];
            found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            nearest = found.first().map_or(WHEREVER, |contact| contact.distance);
            self.contacts.truncate(start + 1);
        }
        nearest - context.held.most
    }

    /// Contacts of the pairs nearer than `margin` \[m\] at `q`, ascending by pair. Where they were
    /// known before, `check` holds the poses of whatever it saw last.
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

    /// Distance from the anchor, in metric units.
    pub fn distance(&mut self, context: &Context, anchor: &Anchor, q: &[f64]) -> f64 {
        context.metric.distance_from(anchor, q, &mut self.metric)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::prepared::Prepared;
    use crate::scene::builtin;

    /// Whoever offers a witness, a stored sample or a step, keeps the limits; this holds if not.
    #[test]
    fn what_lies_beyond_limits_is_not_free() {
        let world = Prepared::new(builtin::scene("planar-arm").unwrap());
        let (mut evaluator, context) = (Evaluator::default(), world.context());
        evaluator.begin(Deadline::default());
        let straight = [1.9, 0.0, 0.0];
        assert_eq!(evaluator.label(&context, &straight), Label::Free);
        // The same poses, but for turns that the joint cannot make; and no poses at all.
        for (at, value) in [(1, std::f64::consts::TAU), (2, -std::f64::consts::TAU), (0, f64::NAN), (2, f64::INFINITY)]
        {
            let mut q = straight;
            q[at] = value;
            assert_eq!(evaluator.label(&context, &q), Label::Colliding, "{q:?}");
        }
    }
}

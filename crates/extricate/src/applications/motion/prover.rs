//! Labels configurations and proves edges in one set, and counts checks until a budget is spent.

use super::held::Held;
use crate::collision::{
    CheckScratch, Checker, Contact, ContactQuery, SegmentBudget, SegmentOptions, SegmentOutcome, prove,
};
use crate::cspace::Label;
use crate::query::keep::LinkConstraint;
use crate::query::{Deadline, Termination};

/// An edge that has to bend is halved at most this often: 4,096 pieces suffice for half a turn at
/// tolerances of 1e-7.
const MAX_HALVINGS: usize = 12;
/// A projected middle that is farther from an end than this share of the edge is on another branch
/// of the links' places: halves would not become short.
const MAX_HALF_SHARE: f64 = 0.75;

/// Evaluates a set of configurations: the free ones, or those that a checker with other clearances
/// of its pairs ([`Checker::with_floors`]) calls free. Links may have to be kept besides.
pub struct Prover<'a> {
    /// The checker that defines the set.
    pub checker: &'a Checker,
    scratch: CheckScratch,
    /// Resolution of the proofs of edges \[m\].
    resolution: f64,
    /// Number of configurations evaluated so far.
    pub checks: usize,
    limit: Deadline,
    held: Held,
}

impl<'a> Prover<'a> {
    pub fn new(checker: &'a Checker, resolution: f64, limit: Deadline) -> Self {
        Self { checker, scratch: CheckScratch::default(), resolution, checks: 0, limit, held: Held::default() }
    }

    /// Leaves only those configurations in the set that keep these links.
    pub fn holding(self, kept: &[LinkConstraint]) -> Self {
        Self { held: Held::new(kept), ..self }
    }

    pub fn is_spent(&self) -> bool {
        self.limit.is_reached(self.checks)
    }

    /// Returns the rest of the budget, for a query that is part of the same work.
    pub fn left(&self) -> Termination {
        self.limit.left(self.checks)
    }

    /// Allows at most `checks` further checks. Returns the limit before, for [`Prover::unlimit`].
    pub fn limited(&mut self, checks: usize) -> Option<usize> {
        let before = self.limit.checks;
        let most = self.checks.saturating_add(checks);
        self.limit.checks = Some(before.map_or(most, |before| before.min(most)));
        before
    }

    /// Restores the limit that [`Prover::limited`] returned.
    pub fn unlimit(&mut self, before: Option<usize>) {
        self.limit.checks = before;
    }

    /// Whether `q` is within its limits and in the set.
    pub fn holds(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        let scene = self.checker.scene();
        scene.space.is_within(q) && self.held.keeps(scene, q) && self.checker.label(q, &mut self.scratch) == Label::Free
    }

    /// Whether the whole edge from `a`, which has to be in the set, is proved to lie in it before
    /// the budget is spent.
    pub fn proves(&mut self, a: &[f64], b: &[f64]) -> bool {
        self.held.keeps_edge(self.checker.scene(), a, b) && self.proves_free(a, b)
    }

    /// As [`Prover::proves`], but for kept links.
    fn proves_free(&mut self, a: &[f64], b: &[f64]) -> bool {
        let (limit, spent) = (&self.limit, self.checks);
        let budget = SegmentBudget { is_spent: &|checks| limit.is_reached(spent + checks), ..SegmentBudget::UNLIMITED };
        let proved = prove(self.checker, (a, b), self.resolution, &budget, &mut self.scratch);
        self.checks += proved.checks;
        proved.is_free
    }

    /// Returns configurations that proved edges join, from `a` (left out) to `b`: `b` alone if
    /// links need not be kept. `a` has to be in the set.
    pub fn join(&mut self, a: &[f64], b: &[f64]) -> Option<Vec<Vec<f64>>> {
        // Many proofs of short edges are saved if the end is not in the set.
        if self.is_held() && !self.holds(b) {
            return None;
        }
        let (way, is_there) = self.advance(a, b);
        is_there.then_some(way)
    }

    /// As [`Prover::join`], but returns how far it comes if it does not come to `b`, and whether it
    /// does.
    ///
    /// A straight edge between two configurations that keep a link leaves its place in between,
    /// unless it is short. So it is halved, and its middle projected back, until every part is
    /// proved to keep the links and to be in the set.
    ///
    /// # Source
    /// D. Berenson, S. S. Srinivasa, D. Ferguson and J. J. Kuffner, "Manipulation planning on
    /// constraint manifolds", ICRA 2009, doi:10.1109/ROBOT.2009.5152399; Z. Kingston, M. Moll and
    /// L. E. Kavraki, "Exploring implicit spaces for constrained sampling-based planning", IJRR
    /// 38(10-11), 2019, doi:10.1177/0278364919868530. Deviation: links are proved to be kept
    /// between the points too.
    pub fn advance(&mut self, a: &[f64], b: &[f64]) -> (Vec<Vec<f64>>, bool) {
        let mut way = Vec::new();
        let is_there = self.bend([a, b], MAX_HALVINGS, &mut way);
        (way, is_there)
    }

    /// Appends the configurations of [`Prover::advance`], with at most this many halvings of the
    /// edge; returns whether the last is its end.
    fn bend(&mut self, [a, b]: [&[f64]; 2], halvings: usize, way: &mut Vec<Vec<f64>>) -> bool {
        let space = &self.checker.scene().space;
        if self.held.keeps_edge(self.checker.scene(), a, b) {
            let is_proved = self.proves_free(a, b);
            way.extend(is_proved.then(|| b.to_vec()));
            return is_proved;
        }
        let mut middle = a.to_vec();
        space.interpolate(a, b, 0.5, &mut middle);
        if halvings == 0 || self.is_spent() || !self.project(&mut middle) {
            return false;
        }
        let halves = [[a, &middle[..]], [&middle[..], b]];
        let most = MAX_HALF_SHARE * space.distance(a, b);
        halves.iter().all(|[from, to]| space.distance(from, to) <= most)
            && halves.into_iter().all(|half| !self.is_spent() && self.bend(half, halvings - 1, way))
    }

    /// Whether links have to be kept.
    pub fn is_held(&self) -> bool {
        !self.held.is_empty()
    }

    /// Whether `q` keeps the links.
    pub fn keeps(&mut self, q: &[f64]) -> bool {
        self.held.keeps(self.checker.scene(), q)
    }

    /// Moves `q` to a configuration nearby that keeps the links; counts as a check if there are
    /// any. Returns whether there is one.
    pub fn project(&mut self, q: &mut Vec<f64>) -> bool {
        self.checks += usize::from(self.is_held());
        self.held.project(self.checker.scene(), q)
    }

    /// Returns the fraction of the edge from `a` up to which it is proved to lie in the set before
    /// the budget is spent; 1 for the whole edge. It is 0 if links are not kept all along the edge.
    pub fn proved_until(&mut self, a: &[f64], b: &[f64]) -> f64 {
        if !self.held.keeps_edge(self.checker.scene(), a, b) {
            return 0.0;
        }
        let options = SegmentOptions { resolution: self.resolution };
        let (limit, spent) = (&self.limit, self.checks);
        let budget = SegmentBudget { is_spent: &|checks| limit.is_reached(spent + checks), ..SegmentBudget::UNLIMITED };
        let outcome = self.checker.segment_within((a, b), &options, &budget, &mut self.scratch);
        self.checks += self.scratch.segment_checks();
        match outcome {
            SegmentOutcome::Free => 1.0,
            SegmentOutcome::Contact { free_until, .. } | SegmentOutcome::Undecided { free_until, .. } => free_until,
        }
    }

    /// Writes the contacts of a configuration; [`Prover::scratch`] then has its poses.
    pub fn contacts(&mut self, q: &[f64], query: ContactQuery, contacts: &mut Vec<Contact>) {
        self.checks += 1;
        contacts.clear();
        self.checker.contacts(q, query, &mut self.scratch, contacts);
    }

    /// Memory of the checker, for other evaluations by it.
    pub fn scratch(&mut self) -> &mut CheckScratch {
        &mut self.scratch
    }
}

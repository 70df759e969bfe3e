//! The path that is repaired: its places, and its parts that are not free.

use crate::applications::motion::prover::Prover;
use crate::cspace::{Config, ConfigSpace};
use crate::metric::Metric;

/// A point of a new path: the place on the old one that it stands for, and a configuration.
pub type Point = (f64, Vec<f64>);

/// Golden-section steps that enclose the nearest place of an edge: to a thousandth of the edge.
const GOLDEN_STEPS: usize = 14;
/// Share of the interval that each step keeps.
const GOLDEN_SHARE: f64 = 0.618;

/// Rows of the old path. A place is a number: row 2 is at 2, the middle of the edge after it at
/// 2.5.
pub struct OldPath<'a> {
    rows: &'a [Config],
    metric: &'a Metric,
    space: &'a ConfigSpace,
}

/// A part that is to be replaced, between two places. The old path is free at both, or ends there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    pub from: f64,
    pub to: f64,
}

impl<'a> OldPath<'a> {
    /// Takes one row or more.
    pub fn new(metric: &'a Metric, rows: &'a [Config]) -> Self {
        Self { rows, metric, space: &metric.scene().space }
    }

    pub fn rows(&self) -> &'a [Config] {
        self.rows
    }

    /// Returns the place of the last row.
    pub fn end(&self) -> f64 {
        (self.rows.len() - 1) as f64
    }

    pub fn at(&self, place: f64) -> Vec<f64> {
        let row = (place.floor().max(0.0) as usize).min(self.rows.len() - 1);
        let share = place - row as f64;
        let mut q = self.rows[row].to_vec();
        if share > 0.0 && row + 1 < self.rows.len() {
            self.space.interpolate(&self.rows[row], &self.rows[row + 1], share, &mut q);
        }
        q
    }

    pub fn length(&self) -> f64 {
        self.length_between(0.0, self.end())
    }

    /// Returns the length between two places, in the metric.
    pub fn length_between(&self, from: f64, to: f64) -> f64 {
        let mut points = Vec::new();
        self.copy(from, to, &mut points);
        points.iter().zip(points.iter().skip(1)).map(|(a, b)| self.metric.distance(&a.1, &b.1)).sum()
    }

    /// Returns the rows strictly between two places.
    pub fn rows_between(&self, from: f64, to: f64) -> impl Iterator<Item = usize> + use<> {
        (from.floor() as usize + 1..self.rows.len()).take_while(move |row| (*row as f64) < to)
    }

    /// Returns the place between two others that is nearest to a configuration.
    pub fn nearest_place(&self, q: &[f64], from: f64, to: f64) -> f64 {
        let ends: Vec<f64> = std::iter::once(from).chain(self.rows_between(from, to).map(|row| row as f64)).collect();
        let next = ends.iter().copied().skip(1).chain([to]);
        let on_edge = |(from, to): (f64, f64)| self.nearest_on_edge(q, from, to);
        let found = ends.iter().copied().zip(next).map(on_edge).min_by(|a, b| a.0.total_cmp(&b.0));
        found.map_or(from, |(_, place)| place)
    }

    /// Returns the least distance to an edge, and the place of it. Golden sections find it, since
    /// along an edge the distance falls and then rises.
    fn nearest_on_edge(&self, q: &[f64], mut from: f64, mut to: f64) -> (f64, f64) {
        let distance = |place: f64| self.metric.distance(&self.at(place), q);
        for _ in 0..GOLDEN_STEPS {
            let (low, high) = (to - GOLDEN_SHARE * (to - from), from + GOLDEN_SHARE * (to - from));
            if distance(low) <= distance(high) { to = high } else { from = low }
        }
        let place = 0.5 * (from + to);
        (distance(place), place)
    }

    /// Appends the path from one place to another: both ends and all rows between.
    pub fn copy(&self, from: f64, to: f64, into: &mut Vec<Point>) {
        into.push((from, self.at(from)));
        into.extend(self.rows_between(from, to).map(|row| (row as f64, self.rows[row].to_vec())));
        if to > from {
            into.push((to, self.at(to)));
        }
    }

    /// Returns the stretches that are not proved free, in order, with up to `margin` (metric units)
    /// of free edge on both sides: right beside a collision nothing leads elsewhere. Two that meet
    /// at a row become one if neither leaves more than `margin` free beside it.
    pub fn colliding(&self, margin: f64, prover: &mut Prover) -> Vec<Stretch> {
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut add = |from: f64, to: f64| match stretches.last_mut() {
            Some(last) if last.to >= from => last.to = to,
            _ => stretches.push(Stretch { from, to }),
        };
        if self.rows.len() == 1 && !prover.holds(&self.rows[0]) {
            add(0.0, 0.0);
        }
        for (at, (a, b)) in self.rows.iter().zip(self.rows.iter().skip(1)).enumerate() {
            let free = prover.proved_until(a, b);
            if free < 1.0 {
                let back = prover.proved_until(b, a);
                let margin = margin / self.metric.distance(a, b);
                let from = (free - margin).max(0.0);
                add(at as f64 + from, at as f64 + (1.0 - (back - margin).max(0.0)).max(from));
            }
        }
        stretches
    }
}

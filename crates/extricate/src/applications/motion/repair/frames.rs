//! Repairs frame by frame: each row stays a row, at its time.
//!
//! A proxy follows the rows, as in a continuous stream: it moves only where its way is proved free.

use super::old_path::Point;
use super::options::HELD_SHARE;
use super::repairer::Repairer;
use crate::applications::stream::{DEFAULT_MARGIN_M, Follower, StreamOptions};
use crate::collision::{ContactQuery, ContactSearch};
use crate::query::QueryOptions;
use crate::scene::PairId;

/// Clearance that is aimed at beyond the scene's, as a share of the distance up to which pairs
/// touch.
const HELD_AIM_SHARE: f64 = 0.5;

impl Repairer<'_> {
    /// Returns one free configuration for each row, joined by proved edges. Returns `None` if the
    /// first row leads to no free configuration, or if the budget is spent.
    pub(super) fn frame_by_frame(&mut self) -> Option<Vec<Point>> {
        // A pair that is held at the aimed clearance has to touch.
        let most = self.options.touch.map(|touch| self.context.clearance + HELD_AIM_SHARE * touch);
        let aim = match (self.options.aim, most) {
            (None, Some(most)) => Some(most.min(self.context.clearance + DEFAULT_MARGIN_M)),
            (aim, _) => aim,
        };
        let keep = self.options.keep.clone();
        let query = QueryOptions { clearance: aim, keep, ..QueryOptions::default() };
        let mut stream = Follower::new(StreamOptions { continuous: true, ..StreamOptions::default() }, query);
        if let Some(most) = self.options.max_step {
            stream.limit_moves(most);
        }
        let mut points = Vec::new();
        for (row, q) in self.old.rows().iter().enumerate() {
            if self.prover.is_spent() {
                return None;
            }
            stream.limit(self.left());
            let touching = self.options.touch.map(|touch| self.touching(q, touch)).unwrap_or_default();
            stream.hold(touching.clone(), HELD_SHARE * self.options.touch.unwrap_or(0.0));
            let answer = stream.query(self.context, q);
            self.prover.checks += stream.checks();
            let answer = answer.filter(|answer| answer.verified)?;
            if let Some(touch) = self.options.touch {
                let now = self.touching(&answer.witness, touch);
                self.touched += touching.len();
                self.kept += touching.iter().filter(|pair| now.contains(pair)).count();
            }
            points.push((row as f64, answer.witness.into()));
        }
        Some(points)
    }

    /// Returns the pairs that are at most `touch` \[m\] beyond the clearance apart, or overlap.
    fn touching(&mut self, q: &[f64], touch: f64) -> Vec<PairId> {
        let query = ContactQuery { margin: self.context.clearance + touch, search: ContactSearch::Exact };
        let mut contacts = Vec::new();
        self.prover.contacts(q, query, &mut contacts);
        let mut pairs: Vec<PairId> = contacts.iter().map(|contact| contact.pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}

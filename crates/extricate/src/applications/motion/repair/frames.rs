//! Repairs frame by frame: each row stays a row, at its time.
//!
//! A proxy follows the rows, as in a continuous stream: it moves only where its way is proved free.

use super::old_path::Point;
use super::repairer::Repairer;
use crate::applications::stream::{Follower, StreamOptions};
use crate::query::QueryOptions;

impl Repairer<'_> {
    /// Returns one free configuration for each row, joined by proved edges. Returns `None` if the
    /// first row leads to no free configuration, or if the budget is spent.
    pub(super) fn frame_by_frame(&mut self) -> Option<Vec<Point>> {
        let query = QueryOptions { clearance: self.options.aim, ..QueryOptions::default() };
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
            let answer = stream.query(self.context, q);
            self.prover.checks += stream.checks();
            let answer = answer.filter(|answer| answer.verified)?;
            points.push((row as f64, answer.witness.into()));
        }
        Some(points)
    }
}

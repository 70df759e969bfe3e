//! Which exits and samples a query starts from: near, and not like each other.

use super::Ground;
use super::dense::dot;
use super::plan::Plan;
use super::search::QueryScratch;
use crate::boundary::{Among, Care, Wanted};

/// Nearest exits that are looked at for one that is chosen.
const EXITS_LOOKED_AT: usize = 2;

impl QueryScratch {
    /// Fills `chosen` with exits, then with samples of the pool, none too like another.
    pub(super) fn choose(&mut self, ground: &Ground, plan: &Plan) {
        self.chosen.clear();
        self.places.clear();
        if self.near_exits.is_empty() {
            self.find_exits(ground, plan);
        }
        let exits = std::mem::take(&mut self.near_exits);
        self.choose_from(ground, exits.iter().map(|(id, _)| *id), plan.exits, plan.spread);
        self.near_exits = exits;
        // The next plan may ask for more of them.
        self.near_exits.clear();
        let pool = std::mem::take(&mut self.pool);
        let most = self.chosen.len() + plan.starts;
        self.choose_from(ground, pool.iter().take(plan.pool()).map(|(id, _)| *id), most, plan.spread);
        self.pool = pool;
    }

    /// The exits that the plan chooses of, nearest first.
    pub(super) fn find_exits(&mut self, ground: &Ground, plan: &Plan) {
        let care = if plan.in_turn.is_some() { Care::Quick } else { Care::Exact };
        let wanted = Wanted { among: Among::Exits, care, ..Wanted::NEAREST };
        let Self { anchor, boundary, near_exits, .. } = self;
        let near = plan.exits * EXITS_LOOKED_AT;
        ground.boundary.nearest(wanted, ground.metric, anchor, near, boundary, near_exits);
    }

    /// Chooses of `ids`, in order, until `most` are chosen.
    fn choose_from(&mut self, ground: &Ground, ids: impl Iterator<Item = u32>, most: usize, spread: f64) {
        let space = &ground.checker.scene().space;
        let nv = space.nv();
        for id in ids {
            // Of very many, each is compared with all that were chosen.
            if self.chosen.len() >= most || self.refine.is_stopped() {
                break;
            }
            let known = self.chosen.len() * nv;
            self.local.flatten(space, &self.anchor.q, ground.boundary.config(id), &mut self.places);
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LearnOptions;
    use crate::model::Model;
    use crate::model::measure::tests::colliding;
    use crate::penetration::options::{Effort, QueryOptions};
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    /// What a refined query that begins at exits does comes first, and must not take the samples away.
    #[test]
    fn exhaustive_queries_start_from_exits_and_samples() {
        let options = LearnOptions { labels: 700_000, seconds: None, ..LearnOptions::default() };
        let model =
            Model::learn(builtin::scene("planar-arm").unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let exhaustive = QueryOptions { effort: Effort::Exhaustive, ..QueryOptions::default() };
        assert!(Plan::of(&QueryOptions::default(), &model.ground(), &[]).begins_at_exits());
        let first_exit = (model.boundary().len() - model.boundary().exits()) as u32;
        let mut scratch = QueryScratch::default();
        for q in colliding(&model, 10) {
            model.query(&q, &exhaustive, &mut scratch);
            let plan = Plan::of(&exhaustive, &model.ground(), &[]);
            assert!(scratch.chosen.iter().any(|id| *id >= first_exit));
            assert!(scratch.pool.len() == plan.pool(), "{}", scratch.pool.len());
        }
    }
}

//! Which exits and samples a query starts from: near, and not like each other.

use super::Ground;
use super::dense::dot;
use super::plan::Plan;
use super::search::QueryScratch;
use crate::boundary::{Among, Care, Wanted};

/// Nearest exits that are looked at for one that is chosen.
const EXITS_LOOKED_AT: usize = 2;

impl QueryScratch {
    /// Fills `chosen` with exits, then with samples of the pool, none too like another; where the plan says so, nearest first.
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
        if plan.nearest_first {
            self.put_nearest_first(ground.checker.scene().space.nv());
        }
    }

    /// Puts what was chosen in the order of distance, exits and samples together.
    fn put_nearest_first(&mut self, nv: usize) {
        let Self { chosen, places, ordered, .. } = self;
        let distances = places.chunks_exact(nv).map(|place| dot(place, place));
        ordered.clear();
        ordered.extend(distances.zip(chosen.iter().copied()));
        ordered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        chosen.clear();
        chosen.extend(ordered.iter().map(|(_, id)| id));
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
    use crate::penetration::options::{Effort, QueryBudget, QueryOptions};
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn learned(name: &str, labels: usize) -> Model {
        let options = LearnOptions { labels, seconds: None, ..LearnOptions::default() };
        Model::learn(builtin::scene(name).unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    /// Labels around the query alone take more checks than this query has.
    #[test]
    fn few_checks_are_spent_on_descents() {
        let model = learned("hand", 4000);
        assert_eq!(model.boundary().exits(), 0);
        let few = QueryOptions { budget: QueryBudget { checks: Some(20), seconds: None }, ..QueryOptions::default() };
        let (mut scratch, queries) = (QueryScratch::default(), colliding(&model, 100));
        let found = queries.iter().filter(|q| {
            let [of_few, of_all] =
                [&few, &QueryOptions::default()].map(|options| model.query(q, options, &mut scratch));
            assert!(of_few.verified && of_few.depth >= of_all.depth);
            of_few.depth <= 1.05 * of_all.depth
        });
        let found = found.count();
        assert!(found > 80, "{found} of 100");
    }

    #[test]
    fn few_exits_and_samples_are_tried_nearest_first() {
        let model = learned("planar-arm", 20_000);
        let ground = model.ground();
        assert!(model.boundary().exits() > 100 && !ground.relies_on_exits(), "{}", model.boundary().exits());
        let (mut scratch, mut of_exits, mut all) = (QueryScratch::default(), 0, 0);
        let first_exit = (model.boundary().len() - model.boundary().exits()) as u32;
        for q in colliding(&model, 20) {
            model.query(&q, &QueryOptions::default(), &mut scratch);
            let distance = |id: &u32| model.metric().distance(&q, ground.boundary.config(*id));
            assert!(scratch.chosen.is_sorted_by(|a, b| distance(a) <= distance(b) + 1e-9));
            of_exits += scratch.chosen.iter().filter(|id| **id >= first_exit).count();
            all += scratch.chosen.len();
        }
        assert!(0 < of_exits && of_exits < all, "{of_exits} of {all}");
    }

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

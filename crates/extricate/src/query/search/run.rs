//! One search from start to end: which starts are tried, one kind after the other. How one is tried
//! is not here.

use super::{NEAR, Ranks, Search, Turn};
use crate::query::starts::around::{look_around, try_around};
use crate::query::starts::directions::try_directions;

/// Tries separating directions, then the stored samples, then starts around the query.
pub fn run(search: &mut Search) -> Ranks {
    try_directions(search);
    try_starts(search);
    let (by_samples, known) = (search.known.incumbent.depth, &*search.known);
    let stored = known.round.rank_of(by_samples);
    look_around(search);
    let depth = search.known.incumbent.depth;
    let around = if by_samples <= NEAR * depth { 0 } else { search.known.round.rank_of(depth) };
    let degrees = search.part.map_or(search.context.checker.scene().space.nv(), |part| part.degrees());
    Ranks { degrees, stored, around }
}

/// Tries the starts, nearest first, until the plan's are used up and no further exit is to be
/// expected; in a stream those whose turn it is.
fn try_starts(search: &mut Search) {
    if let Some(turn) = search.turn {
        return try_some(search, turn);
    }
    search.known.round.begin();
    for rank in 0..search.plan.most_starts {
        let is_over = search.known.round.is_over(search.plan.starts, search.plan.patience);
        if is_over || search.evaluator.is_spent() || search.is_proved() {
            break;
        }
        let Some(id) = search.start(rank) else { break };
        // Those after it are no nearer.
        if search.is_far(id) {
            break;
        }
        search.try_sample(id);
    }
}

fn try_some(search: &mut Search, Turn { next, starts_per_frame: mut left }: Turn) {
    let (mut place, all) = (next, search.plan.starts + search.plan.around);
    for rank in 0..all {
        place = (next + rank) % all;
        if search.evaluator.is_spent() || left == 0 {
            break;
        }
        let before = search.evaluator.checks;
        let mut is_far = false;
        if let Some(around) = place.checked_sub(search.plan.starts) {
            try_around(search, around);
        } else if let Some(id) = search.start(place) {
            is_far = search.is_far(id);
            if !is_far {
                search.try_sample(id);
            }
        }
        // What its planes gave up cost nothing. What is far has its turn, lest those that cost the
        // most have theirs more often.
        left -= usize::from(is_far || search.evaluator.checks > before);
    }
    search.turn = Some(Turn { next: place, starts_per_frame: left });
}

#[cfg(test)]
mod tests {
    use crate::learning::LearnOptions;
    use crate::model::Model;
    use crate::model::evaluate::tests::colliding;
    use crate::query::worlds::World;
    use crate::scene::builtin;

    /// \[rad\].
    const SHALLOW: f64 = 0.05;

    /// Of a shallow collision all samples of a small model are far: they may not make the query
    /// dearer than it is without a model.
    #[test]
    fn samples_that_are_far_cost_no_checks() {
        let options = LearnOptions { labels: 4_000, seconds: None, seed: 3, ..LearnOptions::default() };
        let model = Model::learn(builtin::scene("four-legs").unwrap(), &options).unwrap();
        let alone = World::new(builtin::scene("four-legs").unwrap());
        let [mut with, mut without, mut shallow] = [0; 3];
        for q in colliding(&model, 300) {
            let [a, b] = [model.view(), alone.view()]
                .map(|view| view.query_with(&q, &Default::default(), &mut Default::default()).unwrap());
            if b.depth < SHALLOW {
                (with, without, shallow) = (with + a.checks, without + b.checks, shallow + 1);
            }
        }
        assert!(shallow > 20 && with < without, "{shallow} queries, {with} checks with a model, {without} without");
    }
}

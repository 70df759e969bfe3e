//! What to do with a scene of which nothing free is known.

use crate::collision::{Checker, most_often_colliding};
use crate::scene::PairId;

/// Configurations below which "collides every time" says nothing.
const FEW: usize = 100;

/// Pairs that an error names.
const NAMED: usize = 5;

/// Told by which pairs collide in `colliding` configurations, row major: all that was labelled.
pub fn advice(checker: &Checker, colliding: &[f64]) -> String {
    let scene = checker.scene();
    let tried: Vec<Vec<f64>> = colliding.chunks_exact(scene.space.nq()).take(1000).map(<[f64]>::to_vec).collect();
    let named = |pair: PairId| format!("[\"{}\", \"{}\"]", scene.pair_names(pair)[0], scene.pair_names(pair)[1]);
    let often = most_often_colliding(checker, &tried);
    let always: Vec<String> =
        often.iter().take_while(|(_, count)| *count == tried.len()).map(|(pair, _)| named(*pair)).collect();
    let share = |(pair, count): &(PairId, usize)| format!("{} ({} %)", named(*pair), 100 * count / tried.len());
    let others: Vec<String> = often.iter().skip(always.len()).take(NAMED).map(share).collect();
    let (always, others) = (always.join(", "), others.join(", "));
    if tried.len() < FEW {
        "too few to tell why; spend more labels or seconds".into()
    } else if always.is_empty() {
        format!(
            "no single pair is to blame; {others} collide most often: disable those that overlap by design, widen the limits, \
             lower the clearance or spend more labels"
        )
    } else {
        // Where those are by design, the next ones may be too: who has to run again for each of
        // them learns of one a run.
        let others = if others.is_empty() { others } else { format!("; of the others, {others} collide most often") };
        format!("these pairs collide every time; if by design, add to the scene: [pairs] disable = [{always}]{others}")
    }
}

//! Advice for a scene of which no free configuration is known.

use crate::collision::{Checker, most_often_colliding};
use crate::scene::PairId;

/// With fewer configurations, "collides every time" says nothing.
const MIN_CONFIGS: usize = 100;

/// Most pairs named besides those that collide every time.
const MAX_NAMED_PAIRS: usize = 5;

/// Returns advice, from how often pairs collide in `colliding` (row major): all that was labelled.
pub fn advice(checker: &Checker, colliding: &[f64]) -> String {
    let scene = checker.scene();
    let tried: Vec<Vec<f64>> = colliding.chunks_exact(scene.space.nq()).take(1000).map(<[f64]>::to_vec).collect();
    let named = |pair: PairId| format!("[\"{}\", \"{}\"]", scene.pair_names(pair)[0], scene.pair_names(pair)[1]);
    let often = most_often_colliding(checker, &tried);
    let always: Vec<String> =
        often.iter().take_while(|(_, count)| *count == tried.len()).map(|(pair, _)| named(*pair)).collect();
    let share = |(pair, count): &(PairId, usize)| format!("{} ({} %)", named(*pair), 100 * count / tried.len());
    let others: Vec<String> = often.iter().skip(always.len()).take(MAX_NAMED_PAIRS).map(share).collect();
    let (always, others) = (always.join(", "), others.join(", "));
    if tried.len() < MIN_CONFIGS {
        "too few to tell why; spend more labels or seconds".into()
    } else if always.is_empty() {
        format!(
            "no single pair is to blame; {others} collide most often: disable those that overlap by design, widen the limits, \
             lower the clearance or spend more labels"
        )
    } else {
        // If those overlap by design, the next ones may too; naming them saves a run for each.
        let others = if others.is_empty() { others } else { format!("; of the others, {others} collide most often") };
        format!("these pairs collide every time; if by design, add to the scene: [pairs] disable = [{always}]{others}")
    }
}

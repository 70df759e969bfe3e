//! Queries ask for no memory but what their answers hold, once their scratch has grown.

use allocation_counter::measure;
use extricate::{Answer, Config, Effort, MetricKind, QueryOptions, QueryScratch, builtin};

use crate::memory::learn;
use crate::query::colliding;

/// How often memory is asked for to hold an answer with one exit: once a list, and once more
/// whenever the colliding pairs, whose number is not known before, outgrow what there is: four of
/// them, then twice as many each time.
fn needed(answer: &Answer) -> u64 {
    let Answer { witness, gradient, touching, contacts, .. } = answer;
    let lists = [witness.is_empty(), gradient.is_empty(), touching.is_empty(), contacts.is_empty()];
    let growths = match answer.colliding.len() {
        0 => 0,
        pairs => 1 + pairs.div_ceil(4).next_power_of_two().ilog2(),
    };
    lists.into_iter().filter(|is_empty| !is_empty).count() as u64 + u64::from(growths)
}

/// Passes over the same queries with the same scratch until none asks for more: buffers change
/// places, and each has to grow once.
const PASSES: usize = 6;

#[test]
fn queries_allocate_nothing_but_their_answers() {
    let metrics = [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement];
    let scenes = builtin::NAMES.iter().flat_map(|name| metrics.into_iter().map(move |metric| (name, metric)));
    for (name, metric) in scenes {
        let mut scene = builtin::scene(name).unwrap();
        scene.metric = metric;
        let model = learn(scene, 3_000, 7);
        let queries = colliding(&model, 10);
        for effort in [Effort::Nearest, Effort::Refined] {
            let options = QueryOptions { effort, ..QueryOptions::default() };
            let mut scratch = QueryScratch::default();
            let mut excess = |q: &Config| {
                let mut answer = None;
                let asked_for =
                    measure(|| answer = Some(model.view().query_with(q, &options, &mut scratch).unwrap())).count_total;
                asked_for.saturating_sub(answer.as_ref().map_or(0, needed))
            };
            let passes = (0..PASSES).map(|_| queries.iter().map(&mut excess).sum());
            let passes: Vec<u64> = passes.take_while(|pass| *pass > 0).collect();
            assert!(passes.len() < PASSES, "{name}, {metric:?}, {effort:?}: {passes:?} allocations too many");
        }
    }
}

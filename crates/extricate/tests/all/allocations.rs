//! Queries allocate only what their answers hold, once the memory of their solver has grown.

use allocation_counter::measure;
use extricate::{Answer, Config, Effort, MetricKind, QueryOptions, builtin};

use crate::baselines::ALLOCATION_WARM_UP_PASSES;
use crate::memory::learned;
use crate::query::colliding;

/// Returns the allocations that an answer with one exit needs, one for each list. The list of
/// colliding pairs has place for four pairs first, and doubles it with one more allocation each
/// time.
fn needed(answer: &Answer) -> u64 {
    let Answer { witness, gradient, touching, contacts, .. } = answer;
    let lists = [witness.is_empty(), gradient.is_empty(), touching.is_empty(), contacts.is_empty()];
    let growths = match answer.colliding.len() {
        0 => 0,
        pairs => 1 + pairs.div_ceil(4).next_power_of_two().ilog2(),
    };
    lists.into_iter().filter(|is_empty| !is_empty).count() as u64 + u64::from(growths)
}

#[test]
fn queries_allocate_nothing_but_their_answers() {
    let metrics = [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement];
    let scenes = builtin::NAMES.iter().flat_map(|name| metrics.into_iter().map(move |metric| (name, metric)));
    for (name, metric) in scenes {
        let scene = builtin::scene(name).unwrap().with_metric(metric);
        let model = learned(scene, 3_000, 7);
        let queries = colliding(&model, 10);
        for effort in [Effort::Nearest, Effort::Refined] {
            let solver = model.clone().options(QueryOptions::default().effort(effort)).unwrap();
            let excess = |q: &Config| {
                let mut answer = None;
                let asked_for = measure(|| answer = Some(solver.query(q).unwrap())).count_total;
                asked_for.saturating_sub(answer.as_ref().map_or(0, needed))
            };
            // Passes repeat since buffers change places, and each has to grow once.
            let passes = (0..ALLOCATION_WARM_UP_PASSES).map(|_| queries.iter().map(excess).sum());
            let passes: Vec<u64> = passes.take_while(|pass| *pass > 0).collect();
            let has_grown = passes.len() < ALLOCATION_WARM_UP_PASSES;
            assert!(has_grown, "{name}, {metric:?}, {effort:?}: {passes:?} allocations too many");
        }
    }
}

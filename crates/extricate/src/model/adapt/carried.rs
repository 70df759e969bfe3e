//! What an adapting run takes over from the old model, and the lists of configurations that it asks
//! of the new scene.

use std::collections::HashMap;

use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::learning::exploration::Exploration;
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::metric::relative::RelativePoses;
use crate::model::learned::Model;
use crate::model::statistics::{Adapted, Statistics};
use crate::scene::{PairId, Scene};

/// Where a model with these statistics comes from, itself if it was learned from nothing.
pub fn origin(statistics: &Statistics) -> Adapted {
    statistics.adapted.unwrap_or(Adapted { learned_labels: statistics.labels, times: 0 })
}

/// `count` low-discrepancy configurations from index `first` on, row major.
pub fn configs_at(scene: &Scene, halton: &Halton, first: u64, count: usize) -> Vec<f64> {
    let mut configs = vec![0.0; count * scene.space.nq()];
    let rows = configs.chunks_exact_mut(scene.space.nq()).enumerate();
    rows.for_each(|(i, q)| halton.config(&scene.space, first + i as u64, q));
    configs
}

/// Adds configurations (row major) to those that are known, by their labels.
pub fn sort_out(configs: &[f64], labels: Vec<Label>, known: &mut Exploration, nq: usize) {
    for (q, label) in configs.chunks_exact(nq).zip(labels) {
        if label == Label::Free { &mut known.free } else { &mut known.colliding }.extend_from_slice(q);
    }
}

/// The old classifier's svms of the pairs that the new scene has too. Each sees the pose of one
/// body relative to the other, so what it learned of an obstacle holds where that has moved. Of
/// many that never move it holds where they stayed, also where some of them are gone; where they
/// are many in one of the scenes alone, it is left.
pub fn carried_over(model: &Model, new: &RelativePoses) -> Option<ObstacleClassifier> {
    let old = RelativePoses::new(model.checker().scene_arc().clone());
    let numbers = new_numbers(&old, new);
    Some(model.classifier()?.renumbered(|part| numbers.get(&part).copied()))
}

/// The number of each old part in the new scene, by the first of its pairs that is still there.
fn new_numbers(old: &RelativePoses, new: &RelativePoses) -> HashMap<u32, u32> {
    let pairs = |scene: &Scene| (0..scene.pairs.len()).map(PairId::new);
    let by_names: HashMap<[&str; 2], PairId> =
        pairs(new.scene()).map(|pair| (new.scene().pair_names(pair), pair)).collect();
    let mut numbers = HashMap::new();
    for pair in pairs(old.scene()) {
        let (before, after) = (old.part(pair), by_names.get(&old.scene().pair_names(pair)).map(|pair| new.part(*pair)));
        if let Some(after) = after.filter(|after| after.is_shared == before.is_shared) {
            numbers.entry(before.first).or_insert(after.first);
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::scene::builtin;
    use crate::scene::{Body, BodyPair};

    /// A scene with `count` more obstacles that never move, from number `first` on.
    fn crowded(first: usize, count: usize) -> RelativePoses {
        let mut scene = builtin::scene("planar-arm").unwrap();
        let fixed = scene.bodies.iter().position(|body| body.frame == 0).unwrap();
        let own: Vec<BodyPair> = scene.pairs.iter().filter(|pair| pair.second == fixed).copied().collect();
        scene.pairs.retain(|pair| pair.second != fixed);
        for k in first..first + count {
            let body = Body { name: format!("box {k}"), ..scene.bodies[fixed].clone() };
            scene.bodies.push(body);
            let second = scene.bodies.len() - 1;
            scene.pairs.extend(own.iter().map(|pair| BodyPair { second, ..*pair }));
        }
        RelativePoses::new(Arc::new(scene))
    }

    #[test]
    fn what_was_learned_of_many_stays_where_the_first_of_them_is_gone() {
        let (old, fewer, few) = (crowded(0, 40), crowded(1, 38), crowded(1, 3));
        let shared: Vec<u32> = (0..old.scene().pairs.len())
            .map(|pair| old.part(PairId::new(pair)))
            .filter(|part| part.is_shared)
            .map(|part| part.first)
            .collect();
        assert!(!shared.is_empty());
        let numbers = new_numbers(&old, &fewer);
        for part in &shared {
            let number = PairId::new(numbers[part] as usize);
            assert!(fewer.part(number).is_shared);
            let moved = |poses: &RelativePoses, pair: PairId| poses.scene().pairs[pair.index()].first;
            assert_eq!(moved(&fewer, number), moved(&old, PairId::new(*part as usize)));
        }
        let numbers = new_numbers(&old, &few);
        assert!(shared.iter().all(|part| !numbers.contains_key(part)), "few are not learned as one");
    }
}

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
/// many that never move it holds where they stayed; where they are many in one of the scenes alone,
/// it is left.
pub fn carried_over(model: &Model, new: &RelativePoses) -> Option<ObstacleClassifier> {
    let classifier = model.classifier()?;
    let old = RelativePoses::new(model.checker().scene_arc().clone());
    let pairs = (0..new.scene().pairs.len()).map(PairId::new);
    let numbers: HashMap<[&str; 2], PairId> = pairs.map(|pair| (new.scene().pair_names(pair), pair)).collect();
    let number = |part: u32| {
        let before = PairId::new(part as usize);
        let part = new.part(*numbers.get(&model.scene().pair_names(before))?);
        (old.part(before).is_shared == part.is_shared).then_some(part.first)
    };
    Some(classifier.renumbered(number))
}

//! Free configurations put together limb by limb, where hardly any random one is free.
//!
//! Of n limbs that are each free with probability p, all are with p^n: of twenty before a wall
//! each, one random configuration in a hundred million. But every limb is free in many of the
//! colliding ones, and what it takes to be free there does not depend on the others.

use crate::collision::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::learning::exploration::Exploration;
use crate::learning::{Budget, LabelBatch};
use crate::query::IndependentParts;

/// Colliding configurations that limbs are taken from.
const DONORS: usize = 512;
/// Times that a configuration is put together anew, while new pairs collide.
const ROUNDS: usize = 4;
/// Configurations that may fail, for one that is wanted.
const ATTEMPTS: usize = 4;

/// Puts up to `wanted` free configurations together, and adds them to those of `known`. Every look
/// at the pairs of a configuration is counted as a label.
///
/// # Guarantee
/// Each was labelled free. Depends on the arguments alone.
pub fn recombine(checker: &Checker, known: &mut Exploration, wanted: usize, label: &LabelBatch, budget: &mut Budget) {
    let (scene, mut scratch, mut parts) = (checker.scene(), CheckScratch::default(), IndependentParts::default());
    let nq = scene.space.nq();
    let donors: Vec<&[f64]> = known.colliding.chunks_exact(nq).take(DONORS.min(budget.left() / 4)).collect();
    let mut pairs_of = |q: &[f64]| {
        let mut pairs = Vec::new();
        checker.colliding_pairs(q, &mut scratch, &mut pairs);
        pairs
    };
    let moved: Vec<Vec<bool>> = donors.iter().map(|q| parts.split(scene, &pairs_of(q)).moved().to_vec()).collect();
    budget.spend(donors.len());
    let (mut found, mut next) = (Vec::new(), 0);
    for base in donors.iter().cycle().take(ATTEMPTS * wanted.min(donors.len())) {
        if found.len() >= wanted * nq || budget.end().is_some() || budget.left() < ROUNDS + 1 {
            break;
        }
        let mut config = base.to_vec();
        for _ in 0..ROUNDS {
            let pairs = pairs_of(&config);
            budget.spend(1);
            if pairs.is_empty() {
                found.extend_from_slice(&config);
                break;
            }
            parts.split(scene, &pairs);
            for root in parts.roots() {
                // Any donor whose coordinates of the part no colliding pair moves; another one
                // every time.
                let is_clear = |at: &usize| parts.of(root).all(|v| !moved[*at][v]);
                let Some(donor) = (0..donors.len()).map(|k| (next + k) % donors.len()).find(is_clear) else { continue };
                next = donor + 1;
                for factor in scene.space.factors().iter().filter(|factor| parts.of(root).any(|v| v == factor.v)) {
                    let coordinates = factor.coordinates();
                    config[coordinates.clone()].copy_from_slice(&donors[donor][coordinates]);
                }
            }
        }
    }
    found.truncate(budget.left() * nq);
    if !found.is_empty() {
        let labels = budget.label(label, &found);
        let rows = found.chunks_exact(nq).zip(labels).filter(|(_, label)| *label == Label::Free);
        rows.for_each(|(q, _)| known.free.extend_from_slice(q));
    }
}

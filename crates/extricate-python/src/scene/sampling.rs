//! Uniformly random configurations: the sequence of `extricate sample`, drawn in batches, and what
//! collides in all of them.

use extricate::internals::collision::nearly_always_colliding;
use extricate::internals::cspace::sampling::uniform;
use extricate::{Checker, Label, PairId};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Configurations labelled at once: enough for all threads, few enough that a rare kind is not
/// drawn far beyond need.
const BATCH: usize = 4096;
/// Tries in a row without a wanted configuration after which there is taken to be none worth
/// drawing.
const MOST_TRIES: usize = 1_000_000;

/// `count` configurations (row major) in `found`, of one label where one is wanted; `None` where
/// `stopped` said so.
///
/// # Errors
/// What to tell where a million tries in a row found nothing.
pub fn sample(
    checker: &Checker,
    count: usize,
    seed: u64,
    wanted: Option<Label>,
    mut found: Vec<f64>,
    stopped: impl Fn() -> bool,
) -> Result<Option<Vec<f64>>, String> {
    let space = &checker.scene().space;
    let nq = space.nq();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut in_vain = 0;
    while found.len() < count * nq {
        if stopped() {
            return Ok(None);
        }
        let rows = if wanted.is_some() { BATCH } else { BATCH.min(count - found.len() / nq) };
        let mut batch = vec![0.0; rows * nq];
        batch.chunks_exact_mut(nq).for_each(|q| uniform(space, &mut rng, q));
        let Some(wanted) = wanted else {
            found.extend(batch);
            continue;
        };
        let mut labels = vec![Label::Free; rows];
        checker.label_batch(&batch, &mut labels);
        in_vain += rows;
        for (q, label) in batch.chunks_exact(nq).zip(labels) {
            if label == wanted && found.len() < count * nq {
                found.extend_from_slice(q);
                in_vain = 0;
            }
        }
        if in_vain >= MOST_TRIES {
            let (kind, other) = if wanted == Label::Free { ("free", "in collision") } else { ("colliding", "free") };
            let sofar = found.len() / nq;
            return Err(format!(
                "no {kind} configuration among {in_vain} uniform ones ({sofar} found before): the scene is nearly always {other}"
            ));
        }
    }
    Ok(Some(found))
}

/// Pairs that collide in all but at most `misses` of `count` configurations; nothing to rely on if
/// `stopped` said so.
pub fn always(checker: &Checker, count: usize, seed: u64, misses: usize, stopped: impl Fn() -> bool) -> Vec<PairId> {
    let nq = checker.scene().space.nq();
    let drawn = sample(checker, count, seed, None, Vec::new(), &stopped).ok().flatten().unwrap_or_default();
    let found = nearly_always_colliding(checker, drawn.chunks_exact(nq).take_while(|_| !stopped()), misses);
    found.into_iter().map(|(pair, _)| pair).collect()
}

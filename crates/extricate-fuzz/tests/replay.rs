//! Runs every target on its corpus and on some thousand inputs made of it: a short form of the long
//! runs, at every test.

use extricate_fuzz::{TARGETS, target};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers of inputs of models, which take long, and of other targets, and a seed of its own.
const MODEL_INPUTS: usize = 300;
const OTHER_INPUTS: usize = 3000;
const SEED: u64 = 20;

#[test]
fn no_input_breaks_a_target() {
    for target in TARGETS {
        let corpus = (target.corpus)();
        assert!(!corpus.is_empty(), "{}: no corpus", target.name);
        corpus.iter().for_each(|(_, bytes)| (target.run)(bytes));
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        for _ in 0..if target.name == "model" { MODEL_INPUTS } else { OTHER_INPUTS } {
            let [one, other] = [(); 2].map(|()| &corpus[rng.random_range(0..corpus.len())].1);
            (target.run)(&(target.mutate)(&mut rng, one, other));
        }
    }
}

#[test]
fn corpora_are_read_and_sealed_to_the_same_bytes() {
    use extricate_fuzz::container::Container;
    for (input, bytes) in (target("model").unwrap().corpus)() {
        let file = Container::open(&bytes).unwrap_or_else(|| panic!("{input} is not opened"));
        assert_eq!(Container::open(&file.sealed()).as_ref(), Some(&file), "{input}");
        assert!(file.arrays.iter().any(|array| !array.bytes.is_empty()), "{input} is empty");
    }
}

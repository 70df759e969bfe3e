//! libFuzzer on the target `roadmap` of `extricate-fuzz`, which also changes inputs part by part.
#![no_main]

use extricate_fuzz::roadmap::run;
use extricate_fuzz::mutate::sealed;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fuzz_target!(|data: &[u8]| run(data));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    if seed % 4 == 0 {
        return fuzzer_mutate(data, size, max_size);
    }
    let input = data[..size].to_vec();
    let changed = sealed(&mut ChaCha8Rng::seed_from_u64(seed.into()), &input, &input);
    let length = changed.len().min(max_size);
    data[..length].copy_from_slice(&changed[..length]);
    length
});

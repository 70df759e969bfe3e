//! libFuzzer on the target `world` of `extricate-fuzz`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| extricate_fuzz::texts::world(data));

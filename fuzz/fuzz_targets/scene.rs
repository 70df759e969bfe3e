//! libFuzzer on the target `scene` of `extricate-fuzz`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| extricate_fuzz::texts::scene(data));

//! libFuzzer on the target `cloud` of `extricate-fuzz`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| extricate_fuzz::meshes::cloud(data));

//! libFuzzer on the target `glb` of `extricate-fuzz`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| extricate_fuzz::meshes::glb(data));

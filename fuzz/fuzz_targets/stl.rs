//! libFuzzer on the target `stl` of `extricate-fuzz`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| extricate_fuzz::meshes::stl(data));

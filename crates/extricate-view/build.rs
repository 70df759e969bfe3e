//! Embeds the library as WebAssembly, for live pages, if EXTRICATE_WASM names the file that
//! scripts/build-wasm.sh made.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-env-changed=EXTRICATE_WASM");
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let bytes = match std::env::var_os("EXTRICATE_WASM") {
        Some(path) => {
            println!("cargo::rerun-if-changed={}", path.display());
            std::fs::read(&path).unwrap_or_else(|error| panic!("EXTRICATE_WASM: {}: {error}", path.display()))
        }
        None => Vec::new(),
    };
    std::fs::write(folder.join("extricate.wasm.gz"), bytes).expect("OUT_DIR can be written");
}

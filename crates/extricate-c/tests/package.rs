//! Checks what cargo-c reads: the version in `cmake/`, and that the files that `Cargo.toml` has it
//! install exist. `scripts/check-c-package.sh` installs them and builds programs with them.

use std::path::Path;

#[test]
fn the_cmake_package_has_the_version_of_the_crate() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cmake/extricateConfigVersion.cmake");
    let text = std::fs::read_to_string(&path).unwrap();
    for wanted in [
        concat!("set(PACKAGE_VERSION \"", env!("CARGO_PKG_VERSION"), "\")"),
        concat!("set(PACKAGE_VERSION_MAJOR ", env!("CARGO_PKG_VERSION_MAJOR"), ")"),
        concat!("set(PACKAGE_VERSION_MINOR ", env!("CARGO_PKG_VERSION_MINOR"), ")"),
    ] {
        assert!(text.lines().any(|line| line == wanted), "{} has no line {wanted}", path.display());
    }
}

#[test]
fn files_to_install_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest: toml::Table = std::fs::read_to_string(root.join("Cargo.toml")).unwrap().parse().unwrap();
    assert!(manifest["features"].get("capi").is_some(), "cargo-c leaves out a package without the feature capi");
    let install = manifest["package"]["metadata"]["capi"]["install"].as_table().unwrap();
    let patterns = install.values().flat_map(|kind| kind["asset"].as_array().unwrap());
    let mut found = Vec::new();
    for pattern in patterns.map(|asset| asset["from"].as_str().unwrap()) {
        let beginning = root.join(pattern.strip_suffix('*').expect("a pattern that ends with *"));
        let folder = if pattern.ends_with("/*") { beginning.as_path() } else { root };
        let before = found.len();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.to_string_lossy().starts_with(&*beginning.to_string_lossy()) {
                found.push(path.file_name().unwrap().to_string_lossy().into_owned());
            }
        }
        assert!(found.len() > before, "no file is named {pattern}");
    }
    for name in ["extricate.h", "extricate.hpp", "extricateConfig.cmake", "LICENSE-MIT", "LICENSE-APACHE"] {
        assert!(found.iter().any(|other| other == name), "{name} is not installed");
    }
}

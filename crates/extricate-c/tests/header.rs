//! Checks that `include/extricate.h` is what cbindgen makes of the sources. Write it anew with
//! `UPDATE_HEADER=1 cargo test -p extricate-c --test header`.

use std::path::Path;

/// Modules, in the order in which the header has their items.
const SOURCES: &[&str] = &[
    "types",
    "motion_types",
    "grasp_types",
    "handles",
    "scene_info",
    "scene",
    "world",
    "solver",
    "answer",
    "check",
    "batch",
    "stream",
    "motion",
    "roadmap",
    "grasp",
    "geometry",
];

#[test]
fn the_header_is_fresh() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let of_sources = SOURCES.iter().fold(cbindgen::Builder::new().with_config(config), |builder, name| {
        builder.with_src(root.join(format!("src/abi/{name}.rs")))
    });
    let mut written = Vec::new();
    of_sources.generate().unwrap().write(&mut written);
    // rustdoc needs brackets to be escaped; readers of a header do not.
    let written = String::from_utf8(written).unwrap().replace("\\[", "[").replace("\\]", "]");
    let path = root.join("include/extricate.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &written).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    for (number, (old, new)) in there.lines().zip(written.lines()).enumerate().filter(|(_, (old, new))| old != new) {
        println!("line {}: - {old}\n        + {new}", number + 1);
    }
    assert!(there == written, "{} is not that of the sources", path.display());
}

#[test]
fn every_source_is_in_the_header() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/abi");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let exports = std::fs::read_to_string(&path).unwrap().contains("no_mangle");
        assert!(!exports || SOURCES.contains(&name.as_str()), "{name}");
    }
}

//! Checks that every dependency of the build has a licence and a source that `deny.toml` allows,
//! and that its other rules hold.
//!
//! The list is that of cargo-deny, which can check more if it is installed. Building it takes
//! longer than all other checks; this test needs nothing but cargo.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

#[test]
fn dependencies_have_allowed_licences() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let deny = std::fs::read_to_string(root.join("deny.toml")).expect("deny.toml");
    let (allowed, exceptions) = (allow_list(&deny), exceptions(&deny));
    let mut faults = Vec::new();
    let packages = packages_of_this_build(&root);
    assert!(packages.len() > 50, "only {} packages", packages.len());
    for package in &packages {
        let name = package["name"].as_str().expect("name");
        match package["license"].as_str() {
            Some(expression) if is_allowed(expression, &allowed) => {}
            Some(expression) if exceptions.get(name).is_some_and(|own| is_allowed(expression, own)) => {}
            Some(expression) => faults.push(format!("{name}: {expression}")),
            None => faults.push(format!("{name}: no licence expression")),
        }
    }
    assert!(faults.is_empty(), "not allowed by deny.toml:\n{}", faults.join("\n"));
}

#[test]
fn dependencies_come_from_allowed_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let deny: toml::Table = std::fs::read_to_string(root.join("deny.toml")).expect("deny.toml").parse().expect("TOML");
    let rule = |table: &str, key: &str| deny[table][key].as_str().expect("a string").to_string();
    for key in ["unknown-registry", "unknown-git"] {
        assert_eq!(rule("sources", key), "deny", "sources.{key}");
    }
    assert_eq!(rule("bans", "wildcards"), "deny");
    let registries: Vec<&str> =
        deny["sources"]["allow-registry"].as_array().expect("a list").iter().filter_map(|url| url.as_str()).collect();
    let mut faults = Vec::new();
    let packages = packages_of_this_build(&root);
    for package in &packages {
        let name = package["name"].as_str().expect("name");
        // A package without a source is part of this repository.
        match package["source"].as_str() {
            Some(source) => {
                let known = source.strip_prefix("registry+").is_some_and(|url| registries.contains(&url));
                if !known {
                    faults.push(format!("{name}: from {source}"));
                }
            }
            None => faults.extend(wildcards(package).map(|other| format!("{name}: any version of {other}"))),
        }
    }
    assert!(faults.is_empty(), "not allowed by deny.toml:\n{}", faults.join("\n"));
    assert!(packages.iter().any(|package| package["source"].is_null()), "no package of this repository");
}

/// Returns the dependencies of any version, except members named by their path.
fn wildcards(package: &Value) -> impl Iterator<Item = &str> {
    let all = package["dependencies"].as_array().into_iter().flatten();
    all.filter(|other| other["req"] == "*" && other["path"].is_null()).filter_map(|other| other["name"].as_str())
}

/// Crates of which several versions are present, which `deny.toml` warns of: the known ones, and
/// the crates that need the other version.
const KNOWN_TWICE: [(&str, &str); 7] = [
    ("syn", "2: gltf-derive, nalgebra-macros"),
    ("embedded-io", "postcard names both"),
    ("hashbrown", "0.16: safetensors, spade"),
    ("toml", "0.9: cbindgen"),
    ("toml_datetime", "with toml"),
    ("winnow", "with toml"),
    ("glam", "names of optional parts of nalgebra and parry"),
];

#[test]
fn no_more_crates_are_there_twice() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let lock: toml::Table =
        std::fs::read_to_string(root.join("Cargo.lock")).expect("Cargo.lock").parse().expect("TOML");
    let names: Vec<&str> =
        lock["package"].as_array().expect("a list").iter().filter_map(|p| p["name"].as_str()).collect();
    assert!(names.is_sorted());
    for twice in names.windows(2).filter(|pair| pair[0] == pair[1]) {
        assert!(KNOWN_TWICE.iter().any(|(name, _)| *name == twice[0]), "{} is there twice", twice[0]);
    }
}

/// Returns what `cargo metadata` resolves for the machine that runs the test, since packages of
/// other systems may be missing.
fn packages_of_this_build(root: &Path) -> Vec<Value> {
    let cargo = || Command::new(env!("CARGO"));
    let version = cargo().arg("-vV").output().expect("cargo -vV").stdout;
    let version = String::from_utf8(version).expect("UTF-8");
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("a host line");
    let output = cargo()
        .current_dir(root)
        .args(["metadata", "--format-version", "1", "--locked", "--filter-platform", host])
        .output()
        .expect("cargo metadata");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    metadata["packages"].as_array().expect("packages").clone()
}

fn allow_list(deny: &str) -> Vec<String> {
    let deny: toml::Table = deny.parse().expect("TOML");
    let allow = deny["licenses"]["allow"].as_array().expect("licenses.allow");
    allow.iter().map(|v| v.as_str().expect("a string").to_string()).collect()
}

/// Returns the licences that only some packages may have.
fn exceptions(deny: &str) -> HashMap<String, Vec<String>> {
    let deny: toml::Table = deny.parse().expect("TOML");
    let text = |value: &toml::Value| value.as_str().expect("a string").to_string();
    let of =
        |one: &toml::Value| (text(&one["crate"]), one["allow"].as_array().expect("a list").iter().map(text).collect());
    deny["licenses"]["exceptions"].as_array().expect("licenses.exceptions").iter().map(of).collect()
}

/// Evaluates an SPDX expression: `OR` binds weaker than `AND`, `WITH` names an exception, and the
/// old `A/B` means `A OR B`.
fn is_allowed(expression: &str, allowed: &[String]) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let ok = any(&tokens, &mut at, allowed);
    assert_eq!(at, tokens.len(), "cannot read the licence expression {expression:?}");
    ok
}

fn any(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let mut ok = all(tokens, at, allowed);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        ok |= all(tokens, at, allowed);
    }
    ok
}

fn all(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let mut ok = one(tokens, at, allowed);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        ok &= one(tokens, at, allowed);
    }
    ok
}

fn one(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let token = tokens.get(*at).copied().unwrap_or_default();
    *at += 1;
    if token == "(" {
        let ok = any(tokens, at, allowed);
        *at += 1;
        return ok;
    }
    let mut name = token.to_string();
    if tokens.get(*at) == Some(&"WITH") {
        name = format!("{name} WITH {}", tokens.get(*at + 1).copied().unwrap_or_default());
        *at += 2;
    }
    allowed.contains(&name)
}

#[test]
fn licence_expressions_are_read() {
    let allowed: Vec<String> = ["MIT", "Unicode-3.0", "Apache-2.0 WITH LLVM-exception"].map(String::from).into();
    for expression in
        ["MIT", "MIT OR GPL-3.0", "GPL-3.0/MIT", "(GPL-3.0 OR MIT) AND Unicode-3.0", "Apache-2.0 WITH LLVM-exception"]
    {
        assert!(is_allowed(expression, &allowed), "{expression}");
    }
    for expression in ["GPL-3.0", "MIT AND GPL-3.0", "(MIT OR Unicode-3.0) AND GPL-3.0", "Apache-2.0"] {
        assert!(!is_allowed(expression, &allowed), "{expression}");
    }
}

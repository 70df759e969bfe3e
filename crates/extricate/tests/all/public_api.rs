//! The public interface as a list in `public_api.txt`, so that every change shows in the diff.
//! `UPDATE_PUBLIC_API=1 cargo test --workspace public_api` writes it anew.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use quote::ToTokens;
use syn::{Attribute, Fields, ImplItem, Item, ItemUse, Type, UseTree, Visibility};

/// Limit on the names that the facade and its modules export.
const MAX_ITEMS: usize = 160;

#[test]
fn the_public_interface_is_the_list() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let exported = exported(&parse(&src.join("lib.rs")).items);
    let listed: BTreeSet<String> = exported.keys().cloned().collect();
    assert!(listed.len() <= MAX_ITEMS, "{} items, at most {MAX_ITEMS}", listed.len());
    let mut found: BTreeSet<String> = BTreeSet::new();
    let mut files = Vec::new();
    below(&src, &mut files);
    for path in files {
        let top = path.strip_prefix(&src).unwrap().iter().next().unwrap().to_string_lossy();
        let top = top.trim_end_matches(".rs");
        for item in parse(&path).items {
            let is_exported = |name: &str| exported.get(name).is_some_and(|modules| modules.contains(top));
            describe(&item, &is_exported, &mut found);
        }
    }
    let text: String = found.iter().map(|line| format!("{line}\n")).collect();
    let names: BTreeSet<&str> = found.iter().filter_map(|line| line.split([' ', ':', '.', '(', '<']).next()).collect();
    let missing: Vec<&String> = listed.iter().filter(|name| !names.contains(name.as_str())).collect();
    // `builtin` is a module, which no item describes.
    assert_eq!(missing, ["builtin"], "exported, but not found in the sources");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/public_api.txt");
    if std::env::var_os("UPDATE_PUBLIC_API").is_some() {
        std::fs::write(&golden, &text).unwrap();
    }
    let expected = std::fs::read_to_string(&golden).unwrap_or_default();
    for line in expected.lines().filter(|line| !found.contains(*line)) {
        println!("- {line}");
    }
    for line in text.lines().filter(|line| !expected.lines().any(|other| other == *line)) {
        println!("+ {line}");
    }
    assert!(text == expected, "the public interface is not that of {}", golden.display());
}

/// Types whose methods are in several modules; no other type has their names.
const EVERYWHERE: &[&str] = &["Solver", "Scene", "Model", "Checker"];

/// Types of other libraries: public ones would change when these do.
const FOREIGN: &[&str] =
    &["Vec3", "Mat3", "nalgebra", "rayon", "postcard", "toml", "serde_json", "ChaCha8Rng", "impl Rng"];

#[test]
fn no_type_of_another_library_is_public() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/public_api.txt");
    let listed = std::fs::read_to_string(&golden).unwrap();
    let is_foreign = |line: &&str| FOREIGN.iter().any(|name| line.contains(name));
    let found: Vec<&str> = listed.lines().filter(is_foreign).collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
    assert!(is_foreign(&"Pose.translation: Vec3"));
}

/// Words for which the glossary (docs/reference/glossary.md) has better ones.
const RETIRED: &[&str] = &[
    "way out",
    "ways out",
    "looked at",
    "looks",
    "asked",
    "asks",
    "told",
    "tells",
    "foot",
    "feet",
    "hope",
    "lesson",
    "wander",
    "lean",
];

#[test]
fn public_docs_keep_to_the_words_of_the_glossary() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let exported = exported(&parse(&src.join("lib.rs")).items);
    let (mut files, mut faults, mut read) = (Vec::new(), Vec::new(), 0);
    below(&src, &mut files);
    for path in files {
        let top = path.strip_prefix(&src).unwrap().iter().next().unwrap().to_string_lossy();
        let top = top.trim_end_matches(".rs");
        for item in parse(&path).items {
            let is_exported = |name: &str| exported.get(name).is_some_and(|modules| modules.contains(top));
            for (name, page) in docs(&item, &is_exported) {
                read += 1;
                let words = retired(&page);
                faults.extend(words.into_iter().map(|word| format!("{}: {name}: \"{word}\"", path.display())));
            }
        }
    }
    assert!(read > 200, "{read}");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    assert_eq!(retired("The way out, as told."), ["way out", "told"]);
    assert!(retired("A mantold footing.").is_empty());
}

fn retired(page: &str) -> Vec<&'static str> {
    let is_letter = |at: usize| page[at..].chars().next().is_some_and(char::is_alphabetic);
    let stands_alone = |(at, word): (usize, &str)| {
        !is_letter(at + word.len()) && !page[..at].chars().next_back().is_some_and(char::is_alphabetic)
    };
    RETIRED.iter().copied().filter(|word| page.match_indices(word).any(stands_alone)).collect()
}

/// Returns the names and docs of all that is public of an exported item.
fn docs(item: &Item, is_exported: &dyn Fn(&str) -> bool) -> Vec<(String, String)> {
    let page = |attributes: &[Attribute]| -> String {
        attributes.iter().filter(|a| a.path().is_ident("doc")).map(|a| a.to_token_stream().to_string()).collect()
    };
    match item {
        Item::Struct(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            let fields = item.fields.iter().filter(|field| is_public(&field.vis));
            let of = |field: &syn::Field| field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            let inside = fields.map(|field| (format!("{}.{}", item.ident, of(field)), page(&field.attrs)));
            std::iter::once((item.ident.to_string(), page(&item.attrs))).chain(inside).collect()
        }
        Item::Enum(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            let inside = item.variants.iter().map(|v| (format!("{}::{}", item.ident, v.ident), page(&v.attrs)));
            std::iter::once((item.ident.to_string(), page(&item.attrs))).chain(inside).collect()
        }
        Item::Fn(item) if is_public(&item.vis) && is_exported(&item.sig.ident.to_string()) => {
            vec![(item.sig.ident.to_string(), page(&item.attrs))]
        }
        Item::Impl(item) if item.trait_.is_none() => {
            let name = item.self_ty.to_token_stream().to_string();
            let name = name.split(' ').next().unwrap_or_default().to_string();
            let functions = item.items.iter().filter_map(|inside| match inside {
                ImplItem::Fn(f) if is_public(&f.vis) => Some((format!("{name}::{}", f.sig.ident), page(&f.attrs))),
                _ => None,
            });
            if is_exported(&name) { functions.collect() } else { Vec::new() }
        }
        _ => Vec::new(),
    }
}

fn parse(path: &Path) -> syn::File {
    syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn below(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            below(&entry, files);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            files.push(entry);
        }
    }
}

fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        let text = a.to_token_stream().to_string();
        text.contains("hidden") || text.contains("cfg (test)")
    })
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// Maps each exported name to the modules of the crate that it may come from.
fn exported(items: &[Item]) -> BTreeMap<String, BTreeSet<String>> {
    let mut names = BTreeMap::new();
    for item in items {
        match item {
            Item::Use(ItemUse { vis, attrs, tree, .. }) if is_public(vis) && !is_hidden(attrs) => {
                leaves(tree, &mut Vec::new(), &mut names);
            }
            Item::Mod(module) if is_public(&module.vis) && !is_hidden(&module.attrs) => {
                let inside = module.content.as_ref().map_or(&[][..], |(_, items)| items);
                exported(inside).into_iter().for_each(|(name, from)| names.entry(name).or_default().extend(from));
            }
            _ => {}
        }
    }
    names
}

fn leaves(tree: &UseTree, path: &mut Vec<String>, names: &mut BTreeMap<String, BTreeSet<String>>) {
    match tree {
        UseTree::Path(segment) => {
            path.push(segment.ident.to_string());
            leaves(&segment.tree, path, names);
            path.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, path, names)),
        UseTree::Name(name) => {
            let from = path.iter().find(|segment| *segment != "crate").cloned().unwrap_or_default();
            names.entry(name.ident.to_string()).or_default().insert(from);
        }
        other => panic!("the facade names what it exports, found {}", other.to_token_stream()),
    }
}

/// Adds a line for each public part of an item.
fn describe(item: &Item, is_exported: &dyn Fn(&str) -> bool, lines: &mut BTreeSet<String>) {
    let mut fields = |name: &str, fields: &Fields| {
        for field in fields.iter().filter(|field| is_public(&field.vis) && !is_hidden(&field.attrs)) {
            let of = field.ident.as_ref().map_or_else(|| "0".into(), ToString::to_string);
            lines.insert(format!("{name}.{of}: {}", text(&field.ty)));
        }
    };
    match item {
        Item::Struct(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            fields(&item.ident.to_string(), &item.fields);
            lines.insert(item.ident.to_string());
        }
        Item::Enum(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            for variant in &item.variants {
                let told = without_docs(&text(&variant.fields));
                lines.insert(format!("{}::{}{told}", item.ident, variant.ident));
            }
            lines.insert(item.ident.to_string());
        }
        Item::Type(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            lines.insert(format!("{} = {}", item.ident, text(&item.ty)));
        }
        Item::Const(item) if is_public(&item.vis) && is_exported(&item.ident.to_string()) => {
            lines.insert(format!("{}: {}", item.ident, text(&item.ty)));
        }
        Item::Fn(item) if is_public(&item.vis) && is_exported(&item.sig.ident.to_string()) => {
            lines.insert(text(&item.sig).trim_start_matches("fn ").to_string());
        }
        Item::Impl(item) if item.trait_.is_none() => {
            let Type::Path(path) = &*item.self_ty else { return };
            let Some(name) = path.path.segments.last().map(|segment| segment.ident.to_string()) else { return };
            if !is_exported(&name) && !EVERYWHERE.contains(&name.as_str()) {
                return;
            }
            for inside in &item.items {
                match inside {
                    ImplItem::Fn(f) if is_public(&f.vis) && !is_hidden(&f.attrs) => {
                        lines.insert(format!("{name}::{}", text(&f.sig).trim_start_matches("fn ")));
                    }
                    ImplItem::Const(c) if is_public(&c.vis) => {
                        lines.insert(format!("{name}::{}: {}", c.ident, text(&c.ty)));
                    }
                    _ => {}
                }
            }
        }
        Item::Macro(item) => describe_macro(&item.mac, is_exported, lines),
        _ => {}
    }
}

/// Adds the methods that the macros of `interface.rs` generate.
fn describe_macro(found: &syn::Macro, is_exported: &dyn Fn(&str) -> bool, lines: &mut BTreeSet<String>) {
    let tokens = text(&found.tokens);
    if found.path.is_ident("words") {
        let name = tokens.split(' ').next().unwrap_or_default();
        if is_exported(name) {
            lines.insert(format!("{name}::ALL: &[Self]"));
            lines.insert(format!("{name}::name(self) -> &'static str"));
        }
    }
    if found.path.is_ident("setters") {
        for one in tokens.split('}').filter(|one| one.contains('{')) {
            let (name, fields) = one.split_once('{').expect("it has one");
            let name = name.trim();
            for (field, kind) in fields.split(',').filter_map(|field| field.split_once(':')) {
                if is_exported(name) {
                    let (field, kind) = (field.trim(), kind.trim().trim_end_matches(" = Some"));
                    lines.insert(format!("{name}::{field}(self, {field}: {kind}) -> Self"));
                }
            }
        }
    }
}

/// Removes the docs from the fields of a variant.
fn without_docs(fields: &str) -> String {
    let mut parts = fields.split("# [doc = ");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |all, part| all + part.split_once("\"]").map_or(part, |(_, rest)| rest.trim_start()))
}

/// Prints tokens without the blanks between them.
fn text(tokens: &impl ToTokens) -> String {
    let mut text = tokens.to_token_stream().to_string();
    for (from, to) in [
        (" :: ", "::"),
        (" < ", "<"),
        (" >", ">"),
        ("& ", "&"),
        (" , ", ", "),
        (" ,", ","),
        ("( ", "("),
        (" )", ")"),
        (" (", "("),
        (" : ", ": "),
        ("[ ", "["),
        (" ]", "]"),
        (" ; ", "; "),
        ("< ", "<"),
        ("' ", "'"),
        ("{ ", "{ "),
    ] {
        text = text.replace(from, to);
    }
    text
}

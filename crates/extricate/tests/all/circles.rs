//! Checks that no files use each other in a circle, so that each can be read before the next.
//!
//! A file uses another if a `use` or a path in its code names an item of that file's module.
//! Re-exports of a facade (`pub use`) do not count, nor do tests.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree, Visibility};

type Module = Vec<String>;

#[test]
fn no_files_use_each_other_in_a_circle() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut modules = BTreeMap::new();
    collect(&src, &mut Vec::new(), &mut modules);
    let uses: BTreeMap<&Module, BTreeSet<Module>> =
        modules.iter().map(|(module, path)| (module, uses_of(module, path, &modules))).collect();
    let circles = circles(&uses);
    let words = |circle: &BTreeSet<Module>| circle.iter().map(|m| m.join("::")).collect::<Vec<_>>().join(", ");
    let listed: Vec<String> = circles.iter().map(words).collect();
    assert!(circles.is_empty(), "{} circles:\n{}", circles.len(), listed.join("\n"));
}

/// Collects every module of a folder, except tests and the crate's root.
fn collect(folder: &Path, module: &mut Module, modules: &mut BTreeMap<Module, PathBuf>) {
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if name == "tests" || name == "lib" {
            continue;
        }
        if path.is_dir() {
            module.push(name);
            collect(&path, module, modules);
            module.pop();
        } else if name == "mod" {
            modules.insert(module.clone(), path);
        } else {
            modules.insert([&module[..], &[name]].concat(), path);
        }
    }
}

struct Uses<'a> {
    module: &'a Module,
    modules: &'a BTreeMap<Module, PathBuf>,
    found: BTreeSet<Module>,
}

fn uses_of(module: &Module, path: &Path, modules: &BTreeMap<Module, PathBuf>) -> BTreeSet<Module> {
    let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mut uses = Uses { module, modules, found: BTreeSet::new() };
    uses.visit_file(&file);
    uses.found
}

impl Uses<'_> {
    /// Notes the module that a path leads to: the longest prefix that is a module.
    fn note(&mut self, segments: &[String]) {
        let mut at: Module = match segments.first().map(String::as_str) {
            Some("crate") => Vec::new(),
            Some("super" | "self") => self.module.clone(),
            Some(first) if self.modules.contains_key(&[&self.module[..], &[first.to_string()]].concat()) => {
                self.module.clone()
            }
            _ => return,
        };
        for segment in segments {
            match segment.as_str() {
                "super" => drop(at.pop()),
                "crate" | "self" => {}
                name => at.push(name.to_string()),
            }
        }
        while !at.is_empty() && !self.modules.contains_key(&at) {
            at.pop();
        }
        if !at.is_empty() && at != *self.module {
            self.found.insert(at);
        }
    }

    fn leaves(&mut self, tree: &UseTree, path: &mut Vec<String>) {
        match tree {
            UseTree::Path(segment) => {
                path.push(segment.ident.to_string());
                self.leaves(&segment.tree, path);
                path.pop();
            }
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.leaves(tree, path)),
            UseTree::Name(name) => self.note(&[&path[..], &[name.ident.to_string()]].concat()),
            UseTree::Rename(name) => self.note(&[&path[..], &[name.ident.to_string()]].concat()),
            UseTree::Glob(_) => self.note(path),
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| a.path().is_ident("cfg") && a.parse_args::<syn::Ident>().is_ok_and(|i| i == "test"))
}

impl<'ast> Visit<'ast> for Uses<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Mod(ItemMod { attrs, .. }) | Item::Use(ItemUse { attrs, .. }) => attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if !matches!(item.vis, Visibility::Public(_)) {
            self.leaves(&item.tree, &mut Vec::new());
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if segments.len() > 1 {
            self.note(&segments);
        }
        visit::visit_path(self, path);
    }
}

/// Returns sets of modules in which each reaches every other one.
fn circles(uses: &BTreeMap<&Module, BTreeSet<Module>>) -> Vec<BTreeSet<Module>> {
    let reached = |from: &Module| {
        let (mut seen, mut stack) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = stack.pop() {
            for next in &uses[&module] {
                if seen.insert(next.clone()) {
                    stack.push(next.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = uses.keys().map(|module| (*module, reached(module))).collect();
    let circle = |module: &&Module| -> BTreeSet<Module> {
        reached[*module].iter().filter(|other| reached[*other].contains(*module)).cloned().collect()
    };
    let all: BTreeSet<BTreeSet<Module>> = uses.keys().map(circle).filter(|circle| circle.len() > 1).collect();
    all.into_iter().collect()
}

#[test]
fn a_circle_is_seen() {
    let module = |name: &str| vec![name.to_string()];
    let (a, b, c) = (module("a"), module("b"), module("c"));
    let one = |name: &Module| BTreeSet::from([name.clone()]);
    let uses = BTreeMap::from([(&a, one(&b)), (&b, one(&a)), (&c, one(&a))]);
    assert_eq!(circles(&uses), [BTreeSet::from([a.clone(), b.clone()])]);
}

//! House rules that the compiler does not check: module docs, dependencies between modules, short
//! functions, no paths of one machine.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules that each module may use, nearest first. ARCHITECTURE.md has the same table.
const MAY_USE: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("error", &[]),
    ("interface", &["error"]),
    ("robot", &["math", "error"]),
    ("cspace", &["math", "error"]),
    ("scene", &["cspace", "robot", "math", "interface", "error"]),
    ("kinematics", &["scene", "cspace", "math"]),
    ("metric", &["kinematics", "scene", "robot", "cspace", "math", "error"]),
    ("collision", &["kinematics", "scene", "robot", "cspace", "math", "interface", "error"]),
    ("learning", &["cspace", "math", "interface", "error"]),
    ("samples", &["learning", "metric", "cspace", "math", "error"]),
    ("query", &["samples", "collision", "metric", "kinematics", "scene", "cspace", "math", "interface", "error"]),
    (
        "model",
        &[
            "query",
            "samples",
            "learning",
            "collision",
            "metric",
            "kinematics",
            "scene",
            "cspace",
            "robot",
            "math",
            "interface",
            "error",
        ],
    ),
    ("solver", &["model", "query", "collision", "metric", "scene", "cspace", "robot", "error"]),
    (
        "applications",
        &[
            "solver",
            "query",
            "collision",
            "metric",
            "kinematics",
            "scene",
            "cspace",
            "robot",
            "math",
            "interface",
            "error",
        ],
    ),
    (
        "io",
        &[
            "applications",
            "solver",
            "model",
            "query",
            "samples",
            "learning",
            "collision",
            "metric",
            "kinematics",
            "scene",
            "cspace",
            "robot",
            "math",
            "interface",
            "error",
        ],
    ),
];
/// Modules of `query/` that each of them may use, in an order in which they can be read.
const QUERY_MODULES: &[(&str, &[&str])] = &[
    ("inner_balls", &[]),
    ("qp", &[]),
    ("keep", &["qp"]),
    ("termination", &[]),
    ("context", &["inner_balls", "keep"]),
    ("prepared", &["context", "inner_balls"]),
    ("options", &["keep", "termination"]),
    ("answer", &["keep", "options"]),
    ("record", &["answer", "keep", "options"]),
    ("read_record", &["answer", "keep"]),
    ("evaluate", &["context", "keep", "termination"]),
    ("groups", &["context"]),
    ("local_metric", &["context"]),
    ("bound", &["context", "groups", "inner_balls", "options", "qp"]),
    ("exits", &["answer", "local_metric"]),
    ("descent", &["answer", "context", "evaluate", "exits", "keep", "qp"]),
    ("plan", &["context", "descent", "options"]),
    ("contact_planes", &["plan"]),
    ("search", &["answer", "bound", "context", "descent", "evaluate", "exits", "groups", "local_metric", "plan", "qp"]),
    ("beyond_limits", &["answer", "context", "search"]),
    ("constraints", &["answer", "context", "descent", "keep", "options", "plan", "search", "termination"]),
    ("report", &["answer", "beyond_limits", "bound", "context", "evaluate", "exits", "options", "search"]),
    (
        "nearest_exit",
        &[
            "answer",
            "beyond_limits",
            "bound",
            "constraints",
            "context",
            "exits",
            "groups",
            "options",
            "plan",
            "report",
            "search",
            "termination",
        ],
    ),
];
/// The facade may name every module.
const FACADE: &str = "lib";
/// Columns of a comment line, except for code and tables in it.
const MAX_COLUMNS: usize = 100;
/// Lines of a function, its signature included.
const MAX_FUNCTION_LINES: usize = 80;
/// Beginnings of paths that exist on one machine only, each cut in two so that this file passes its
/// own test.
const MACHINE_PATHS: &[[&str; 2]] = &[["/ho", "me/"], ["/wo", "rk/"], ["/ro", "ot/"], ["/Us", "ers/"]];

#[test]
fn modules_use_only_what_the_table_allows() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut faults = Vec::new();
    for path in files_below(&src, &["rs"]) {
        let relative = path.strip_prefix(&src).expect("below src");
        faults.extend(forbidden_uses(relative, &read(&path)));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Every module of the query uses only earlier ones of the table: an order of reading.
#[test]
fn rooms_of_the_query_use_only_what_their_table_allows() {
    let query = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/query");
    let place = |room: &str| QUERY_MODULES.iter().position(|(name, _)| *name == room);
    let mut faults = Vec::new();
    for path in files_below(&query, &["rs"]) {
        let relative = path.strip_prefix(&query).expect("below query");
        let (own, is_root) = (module_of(relative), relative.components().count() == 1);
        if own == "mod" {
            continue;
        }
        let Some(own_place) = place(&own) else {
            faults.push(format!("{own}: no room of the table"));
            continue;
        };
        let code = without_comments_and_tests(&read(&path));
        let mut used = names_after(&code, "crate::query::");
        if is_root || relative == Path::new(&own).join("mod.rs") {
            used.extend(names_after(&code, "super::"));
        }
        let is_far = |room: &String| place(room).is_none_or(|at| at >= own_place);
        for room in used.into_iter().filter(|room| *room != own && path.file_name() != Some("tests.rs".as_ref())) {
            if is_far(&room) || !QUERY_MODULES[own_place].1.contains(&room.as_str()) {
                faults.push(format!("{}: `{own}` must not use `{room}`", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    assert_eq!(names_after("use super::{a::B, c};\nsuper::super::d", "super::"), ["a", "c", "d"]);
}

#[test]
fn files_say_what_they_are() {
    let files = files_below(&repository().join("crates"), &["rs"]);
    let faults: Vec<String> = files
        .iter()
        .filter(|path| !read(path).starts_with("//!"))
        .map(|path| format!("{}: does not begin with a module doc (//!)", path.display()))
        .collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Shells use only the public interface, so that others can build the same.
#[test]
fn shells_use_the_interface_alone() {
    for shell in ["cli", "c", "python", "view", "wasm"] {
        for path in files_below(&repository().join(format!("crates/extricate-{shell}/src")), &["rs"]) {
            let is_test = path.file_name() == Some("tests.rs".as_ref());
            let code = without_comments_and_tests(&read(&path));
            assert!(is_test || !code.contains("internals"), "{}: names `internals`", path.display());
        }
    }
}

#[test]
fn comments_are_narrow() {
    let mut faults = Vec::new();
    for path in files_below(&repository().join("crates"), &["rs"]) {
        for (number, columns) in wide_comments(&read(&path)) {
            faults.push(format!("{}:{number}: {columns} columns, at most {MAX_COLUMNS}", path.display()));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    assert_eq!(wide_comments(&format!("let a = 1;\n    // {}", "ab ".repeat(33))), [(2, 106)]);
    assert_eq!(wide_comments(&format!("/// ```\n/// {0}\n/// ```\n/// |{0}", "ab ".repeat(40))), []);
}

#[test]
fn functions_are_short() {
    let mut faults = Vec::new();
    for path in files_below(&repository().join("crates"), &["rs"]) {
        for (name, lines) in long_functions(&read(&path)) {
            faults.push(format!("{}: `{name}` has {lines} lines, at most {MAX_FUNCTION_LINES}", path.display()));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    assert_eq!(long_functions(&format!("fn long() {{\n{}}}\n", "    a();\n".repeat(90))), [("long".into(), 92)]);
}

#[test]
fn the_architecture_page_holds_the_same_table() {
    let page = read(&repository().join("ARCHITECTURE.md"));
    let section = page.split("## ").find(|s| s.starts_with("Who may use whom")).expect("a section on who may use whom");
    let stated: Vec<(String, BTreeSet<String>)> = section.lines().filter_map(table_row).collect();
    let names: Vec<&str> = stated.iter().map(|(module, _)| module.as_str()).collect();
    let expected: Vec<&str> = MAY_USE.iter().map(|(module, _)| *module).collect();
    assert_eq!(names, expected, "modules in the table of ARCHITECTURE.md");
    for ((module, stated), (_, allowed)) in stated.iter().zip(MAY_USE) {
        let allowed: BTreeSet<String> = allowed.iter().map(|s| s.to_string()).collect();
        assert_eq!(*stated, allowed, "what `{module}` may use, in ARCHITECTURE.md (left) and in this test (right)");
    }
}

#[test]
fn every_module_is_in_the_table() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for path in files_below(&src, &["rs"]) {
        let module = module_of(path.strip_prefix(&src).expect("below src"));
        assert!(module == FACADE || allowed(&module).is_some(), "`{module}` is not in the dependency table");
    }
}

#[test]
fn nothing_names_a_path_of_one_machine() {
    let root = repository();
    let mut paths = vec![root.join("Cargo.toml"), root.join(".ci/run")];
    for folder in ["crates", "docs", "scripts"] {
        paths.extend(files_below(&root.join(folder), &["rs", "md", "toml", "py", "sh"]));
    }
    paths.extend(files_in(&root, &["md"]));
    let mut faults = Vec::new();
    for path in paths.iter().filter(|p| p.exists()) {
        for (number, line) in read(path).lines().enumerate() {
            if let Some(parts) = MACHINE_PATHS.iter().find(|parts| line.contains(&parts.concat())) {
                faults.push(format!("{}:{}: names {}", path.display(), number + 1, parts.concat()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// One line changes where the project is published.
#[test]
fn addresses_of_the_project_stand_in_one_manifest() {
    let root = repository();
    let of_workspace: toml::Table = read(&root.join("Cargo.toml")).parse().expect("TOML");
    let package = &of_workspace["workspace"]["package"];
    let keys = ["repository", "homepage", "documentation"];
    for key in keys {
        let address = package[key].as_str().expect("a string");
        assert!(names_an_address(address), "{key} = {address:?} is not what this test searches for");
    }
    let mut faults = Vec::new();
    for crates in fs::read_dir(root.join("crates")).expect("crates") {
        let path = crates.expect("an entry").path().join("Cargo.toml");
        let manifest: toml::Table = read(&path).parse().expect("TOML");
        for key in keys {
            let value = &manifest["package"].get(key);
            let inherits = value.and_then(|value| value.get("workspace")?.as_bool()) == Some(true);
            let is_docs_rs = value.and_then(|value| value.as_str()?.strip_prefix("https://docs.rs/"))
                == manifest["package"]["name"].as_str();
            if !(inherits || key == "documentation" && is_docs_rs) {
                faults.push(format!("{}: {key} = {value:?}, expected {key}.workspace = true", path.display()));
            }
        }
    }
    let kinds = ["rs", "md", "toml", "py", "pyi", "sh", "yml", "yaml", "cff", "xml", "html", "hpp", "rb", "in"];
    let mut paths = files_in(&root, &kinds);
    for folder in [".github", "bench", "crates", "docs", "fuzz", "packaging", "ros", "scripts"] {
        paths.extend(files_below(&root.join(folder), &kinds));
    }
    for path in paths.iter().filter(|path| **path != root.join("Cargo.toml")) {
        let lines = read(path);
        let named = lines.lines().enumerate().filter(|(_, line)| names_an_address(line));
        faults.extend(named.map(|(number, line)| format!("{}:{}: {line}", path.display(), number + 1)));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Returns whether a text has the address of a repository or a site with the name of the project.
fn names_an_address(text: &str) -> bool {
    [["github.", "com/"], ["gitlab.", "com/"], [".github.", "io/"]].iter().any(|host| {
        text.split(&host.concat())
            .skip(1)
            .any(|rest| rest.split(['/', '"', ' ']).take(2).any(|part| part.starts_with("extricate")))
    })
}

#[test]
fn a_forbidden_use_is_seen_in_every_spelling() {
    let faults = |text: &str| forbidden_uses(Path::new("cspace/sampling.rs"), &format!("//! x\n{text}")).len();
    assert_eq!(faults("use crate::math::Vec3;"), 0);
    assert_eq!(faults("use crate::{error::{Error, Result}, math::Pose};"), 0);
    assert_eq!(faults("use super::ConfigSpace;"), 0);
    assert_eq!(faults("/// See [`crate::scene::Scene`]."), 0);
    assert_eq!(faults("fn f() {}\n#[cfg(test)]\nmod tests {\n    use crate::scene::Scene;\n}"), 0);
    assert_eq!(faults("use crate::scene::Scene;"), 1);
    assert_eq!(faults("fn f(s: &crate::scene::Scene) {}"), 1);
    assert_eq!(faults("use crate::{math::{Pose, Vec3}, scene::Scene};"), 1);
    assert_eq!(faults("use crate::{\n    scene::Scene,\n    robot::Robot,\n};"), 2);
    assert_eq!(faults("use super::super::scene::Scene;"), 1);
    // The facade re-exports from every module; going through it would hide the dependency.
    assert_eq!(faults("use crate::Scene;"), 1);
    assert_eq!(faults("use crate::Error;"), 1);
}

/// Returns numbers and widths of lines of prose in comments that are too wide.
fn wide_comments(text: &str) -> Vec<(usize, usize)> {
    let (mut found, mut is_code) = (Vec::new(), false);
    for (at, line) in text.lines().enumerate() {
        let trimmed = line.trim_start();
        let Some(inside) = trimmed.strip_prefix("//") else {
            is_code = false;
            continue;
        };
        let inside = inside.trim_start_matches(['/', '!']).trim_start();
        is_code ^= inside.starts_with("```");
        let columns = line.chars().count();
        let is_prose = !is_code && !inside.starts_with('|') && inside.contains(' ');
        if is_prose && columns > MAX_COLUMNS {
            found.push((at + 1, columns));
        }
    }
    found
}

/// Returns names and lengths of too long functions, from `fn` to the brace at its indentation.
fn long_functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let words: Vec<&str> = line.split_whitespace().take_while(|word| !word.starts_with("//")).collect();
        let Some(place) = words.iter().position(|word| *word == "fn") else { continue };
        let is_signature = words[..place].iter().all(|word| {
            word.starts_with("pub") || word.starts_with("in") || ["const", "unsafe", "async"].contains(word)
        });
        let has_body = !line.trim_end().ends_with(';');
        let Some(name) = words.get(place + 1).filter(|_| is_signature && has_body) else { continue };
        let ends = |other: &&str| indent(other) == indent(line) && other.trim_start().starts_with('}');
        let Some(length) = lines[at..].iter().position(ends) else { continue };
        if length + 1 > MAX_FUNCTION_LINES {
            let name = name.split(['(', '<']).next().unwrap_or(name);
            found.push((name.to_string(), length + 1));
        }
    }
    found
}

fn forbidden_uses(path: &Path, text: &str) -> Vec<String> {
    let own = module_of(path);
    let Some(allowed) = allowed(&own) else {
        return Vec::new();
    };
    let mut faults = Vec::new();
    for used in names_from_the_root(&without_comments_and_tests(text)) {
        if used.starts_with(char::is_uppercase) {
            faults
                .push(format!("{}: uses `crate::{used}` of the facade, not the module it comes from", path.display()));
        } else if used != own && MAY_USE.iter().any(|(module, _)| *module == used) && !allowed.contains(&used.as_str())
        {
            faults.push(format!("{}: `{own}` must not use `{used}`", path.display()));
        }
    }
    faults
}

fn allowed(module: &str) -> Option<&'static [&'static str]> {
    MAY_USE.iter().find(|(name, _)| *name == module).map(|(_, allowed)| *allowed)
}

/// Returns the first component of a path below `src`, without the extension.
fn module_of(path: &Path) -> String {
    let first = path.iter().next().expect("not empty").to_str().expect("UTF-8");
    first.trim_end_matches(".rs").to_string()
}

/// Removes comments, and the tests at the end of a file, which may use anything to set up a case.
fn without_comments_and_tests(text: &str) -> String {
    let code = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or("");
    code.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Returns the first name of every path that starts at the crate's root: after `crate::`, each
/// branch of `crate::{..}`, and after two or more `super::`, which may reach the root.
fn names_from_the_root(code: &str) -> Vec<String> {
    let mut names = Vec::new();
    // After `super::super::` only modules count: a type there is one of the module's own, not one
    // of the facade.
    for (prefix, least, types) in [("crate::", 1, true), ("super::", 2, false)] {
        let mut rest = code;
        while let Some(at) = rest.find(prefix) {
            rest = &rest[at..];
            let mut repeats = 0;
            while let Some(after) = rest.strip_prefix(prefix) {
                rest = after;
                repeats += 1;
            }
            if repeats >= least {
                let mut found = Vec::new();
                branches(rest, &mut found);
                names.extend(found.into_iter().filter(|name| types || !name.starts_with(char::is_uppercase)));
            }
        }
    }
    names
}

fn names_after(code: &str, prefix: &str) -> Vec<String> {
    let mut names = Vec::new();
    code.split(prefix).skip(1).for_each(|rest| branches(rest, &mut names));
    names
}

/// Adds the name at the start of `text`, or the first name of each branch of the braces there.
fn branches(text: &str, names: &mut Vec<String>) {
    let Some(inside) = text.strip_prefix('{') else {
        names.extend(leading_name(text));
        return;
    };
    let (mut depth, mut at_start) = (0, true);
    for (i, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => return,
            '}' => depth -= 1,
            ',' if depth == 0 => at_start = true,
            c if at_start && !c.is_whitespace() => {
                names.extend(leading_name(&inside[i..]));
                at_start = false;
            }
            _ => {}
        }
    }
}

fn leading_name(text: &str) -> Option<String> {
    let name: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

/// Reads a row "| `module` | `a`, `b` |" of the page's table.
fn table_row(line: &str) -> Option<(String, BTreeSet<String>)> {
    let cells: Vec<&str> = line.strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim).collect();
    let [module, uses] = cells[..] else { return None };
    let quoted = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_string).collect::<Vec<_>>();
    let [module] = &quoted(module)[..] else { return None };
    Some((module.clone(), quoted(uses).into_iter().collect()))
}

pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = files_in(folder, extensions);
    for entry in entries(folder).into_iter().filter(|p| p.is_dir()) {
        found.extend(files_below(&entry, extensions));
    }
    found
}

pub fn files_in(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let fits = |path: &PathBuf| path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x));
    entries(folder).into_iter().filter(|p| p.is_file() && fits(p)).collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("readable folder").path()).collect();
    paths.sort();
    paths
}

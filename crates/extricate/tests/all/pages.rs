//! Checks that what the pages name exists: files, commands and their options, names of the
//! interfaces. It does not check whether their statements are true.

use std::collections::BTreeSet;
use std::fmt::Display;

use super::tidy::{files_below, files_in, read, repository};

/// Endings of files of the repository. Scenes (`.toml`) are left out: readers write their own.
const ENDINGS: &[&str] = &["rs", "py", "sh", "md", "h", "hpp"];
/// Folders whose files pages may name.
const FOLDERS: &[&str] = &["bench", "crates", "docs", "fuzz", "packaging", "ros", "scripts"];

#[test]
fn files_that_pages_name_exist() {
    let files = files();
    check(|code| missing_files(code, &files));
    let found = |code: &str| missing_files(code, &files).len();
    assert_eq!(found("query/search/mod.rs plan.rs docs/recipes/NAME.py ../x"), 0);
    assert_eq!(found("query/search.rs"), 1);
    assert_eq!(found("no_such_file.rs, scripts/no-such.sh"), 2);
}

#[test]
fn commands_that_pages_name_exist() {
    let reference = read(&repository().join("docs/reference/command-line.md"));
    check(|code| missing_commands(code, &reference));
    let found = |code: &str| missing_commands(code, &reference).len();
    assert_eq!(found("extricate query a.toml --input - | extricate info a.toml --json  # --no"), 0);
    assert_eq!(found("extricate --version"), 0);
    assert_eq!(found("extricate ask a.toml"), 1);
    assert_eq!(found("query --looks 3"), 1);
    assert_eq!(found("extricate sample a.toml -n 1 && extricate query a.toml --way"), 1);
}

#[test]
fn names_that_pages_name_exist() {
    let (python, cpp, rust) = (python_names(), cpp_names(), rust_names());
    check(|code| missing_names(code, &python, &cpp, &rust));
    let found = |code: &str| missing_names(code, &python, &cpp, &rust).len();
    assert_eq!(found("extricate.Scene.builtin(name) extricate.fleet extricate::Solver Solver::query"), 0);
    assert_eq!(found("extricate.hpp Eigen::VectorXd"), 0);
    assert_eq!(found("extricate.Model.ask extricate.Cell extricate::Cell Solver::ask"), 4);
}

/// Fails with every fault that `faults` finds in the code of the pages: file, line and words.
fn check<T: Display>(faults: impl Fn(&str) -> Vec<T>) {
    let (root, mut found) = (repository(), Vec::new());
    let mut pages: Vec<_> = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|name| root.join(name)).into();
    pages.extend(files_below(&root.join("docs"), &["md"]));
    for page in pages {
        for (line, code) in code(&read(&page)) {
            let name = page.strip_prefix(&root).expect("in the repository").display();
            found.extend(faults(&code).iter().map(|fault| format!("{name}:{line}: {fault}")));
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// Returns back-ticked words of a page, and lines of its code blocks that run the program.
fn code(page: &str) -> Vec<(usize, String)> {
    let (mut found, mut is_block) = (Vec::new(), false);
    for (at, line) in page.lines().enumerate() {
        let trimmed = line.trim_start();
        if trimmed.starts_with("```") {
            is_block = !is_block;
        } else if !is_block {
            found.extend(line.split('`').skip(1).step_by(2).map(|code| (at + 1, code.to_string())));
        } else if trimmed.starts_with("extricate ") {
            found.push((at + 1, trimmed.to_string()));
        }
    }
    found
}

/// Returns names of files in `code` that no path of the repository ends with. Words in capitals
/// stand for any name.
fn missing_files(code: &str, files: &BTreeSet<String>) -> Vec<String> {
    let is_file = |word: &&str| word.rsplit_once('.').is_some_and(|(_, ending)| ENDINGS.contains(&ending));
    let is_named = |word: &&str| word.contains('/') || word.ends_with(".rs");
    let stands_for_any = |word: &str| {
        let stem = word.rsplit('/').next().unwrap_or(word).split('.').next().unwrap_or(word);
        stem.chars().all(|c| c.is_uppercase()) || word.contains('*')
    };
    let exists = |word: &str| files.iter().any(|file| file == word || file.ends_with(&format!("/{word}")));
    let words = code.split([' ', ',', ';', '(', ')']).map(|word| word.trim_start_matches("./"));
    let missing = words.filter(is_file).filter(is_named).filter(|word| !stands_for_any(word) && !exists(word));
    missing.map(|word| format!("`{word}` is no file of the repository")).collect()
}

/// Returns commands and options in `code` that the page of the command line lacks, from `extricate
/// COMMAND ..` and `COMMAND --option`.
fn missing_commands(code: &str, reference: &str) -> Vec<String> {
    let mut missing = Vec::new();
    let code = code.split(" #").next().unwrap_or(code);
    for call in code.split(['|', '&', ';']).map(str::trim) {
        let full = call.strip_prefix("extricate ");
        let (command, rest) = full.unwrap_or(call).split_once(' ').unwrap_or((full.unwrap_or(call), ""));
        let is_word = !command.is_empty() && command.chars().all(|c| c.is_ascii_lowercase());
        if !is_word || (full.is_none() && !rest.starts_with("--")) {
            continue;
        }
        let heading = format!("\n## `extricate {command}`\n");
        match reference.split_once(&heading).map(|(_, after)| after.split("\n## ").next().unwrap_or(after)) {
            Some(section) => {
                let words = rest.split(|c: char| !(c.is_ascii_lowercase() || c == '-'));
                let unknown = words.filter(|word| word.len() > 2 && word.starts_with("--")).filter(|word| {
                    !section.split(|c: char| !(c.is_ascii_lowercase() || c == '-')).any(|other| other == *word)
                });
                missing.extend(unknown.map(|word| format!("`{command}` has no option `{word}`")));
            }
            None if full.is_some() => missing.push(format!("`{command}` is no command of the program")),
            None => {}
        }
    }
    missing
}

/// Returns names in `code` that no interface has: `extricate.NAME` and `extricate.NAME.NAME` of
/// Python, `extricate::NAME` of C++ and Rust, `Type::name` of public types of Rust.
fn missing_names(code: &str, python: &Names, cpp: &Names, rust: &Names) -> Vec<String> {
    let mut missing = Vec::new();
    for word in code.split(|c: char| !(c.is_alphanumeric() || "_.:/".contains(c))) {
        if let Some(name) = word.strip_prefix("extricate::") {
            let first = name.split("::").next().unwrap_or(name);
            if !cpp.has(first) && !rust.has(first) {
                missing.push(format!("`{word}` is no name of C++ or Rust"));
            }
        } else if let Some(name) = word.strip_prefix("extricate.").filter(|name| !["h", "hpp", "pc"].contains(name)) {
            let mut parts = name.trim_end_matches('.').split('.');
            let is_known = parts.next().is_some_and(|first| python.public.contains(first));
            if !is_known || parts.any(|part| !python.members.contains(part)) {
                missing.push(format!("`{word}` is no name of Python"));
            }
        } else if let Some((of, name)) = word.split_once("::") {
            // The list leaves out what derives and traits provide.
            if rust.public.contains(of) && !rust.members.contains(word) && name != "default" {
                missing.push(format!("`{word}` is no name of Rust"));
            }
        }
    }
    missing
}

/// Names of an interface, and of the members of its types.
struct Names {
    public: BTreeSet<String>,
    members: BTreeSet<String>,
}

impl Names {
    fn has(&self, name: &str) -> bool {
        self.public.contains(name) || self.members.contains(name)
    }
}

/// Returns the names of Python: `__all__`, and all that is defined in the package.
fn python_names() -> Names {
    let package = repository().join("crates/extricate-python/python/extricate");
    let quoted = |line: &str| Some(line.trim().strip_prefix('"')?.strip_suffix("\",")?.to_string());
    let mut members = BTreeSet::new();
    for file in files_below(&package, &["py", "pyi"]) {
        let text = read(&file);
        let defined = text.lines().map(str::trim).filter_map(|line| line.strip_prefix("def ").or(Some(line)));
        members.extend(defined.filter_map(|line| line.split_once(['(', ':'])).map(|(name, _)| name.to_string()));
    }
    Names { public: read(&package.join("__init__.py")).lines().filter_map(quoted).collect(), members }
}

/// Returns the names of C++: all words of the header.
fn cpp_names() -> Names {
    let header = read(&repository().join("crates/extricate-c/include/extricate.hpp"));
    let words = header.split(|c: char| !(c.is_alphanumeric() || c == '_')).map(str::to_string);
    Names { public: words.collect(), members: BTreeSet::new() }
}

/// Returns the names of Rust from the list of the test `public_api`, which has a line
/// `Type::name(..)` or `Type.field: ..` each.
fn rust_names() -> Names {
    let list = read(&repository().join("crates/extricate/tests/all/public_api.txt"));
    let word = |line: &str| {
        let name: String = line.chars().take_while(|c| c.is_alphanumeric() || "_.:".contains(*c)).collect();
        name.trim_end_matches(':').replace('.', "::")
    };
    let (members, public) = list.lines().map(word).partition(|name| name.contains("::"));
    Names { public, members }
}

/// Returns paths of the files that pages may name, from the root of the repository.
fn files() -> BTreeSet<String> {
    let root = repository();
    let mut found = files_in(&root, ENDINGS);
    for folder in FOLDERS {
        found.extend(files_below(&root.join(folder), ENDINGS));
    }
    let relative = |path: std::path::PathBuf| path.strip_prefix(&root).map(|p| p.to_string_lossy().replace('\\', "/"));
    found.into_iter().filter_map(|path| relative(path).ok()).collect()
}

//! Failures of the library, in one enum. Every message names the file, the element, the value and
//! what was expected.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Any failure of the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {}: {source}", shown(path))]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", shown(path))]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A scene, robot or mesh file holds something that cannot be used.
    #[error("{file}: {element}: {problem}")]
    Input {
        /// The file, as the user named it.
        file: String,
        /// The element inside it: `joint "elbow"`, `obstacle "box"`, `line 12`.
        element: String,
        /// The value found and what was expected instead.
        problem: String,
    },
    /// A file that a scene or robot file names could not be read.
    #[error("{file}: {element}: {problem}")]
    Named {
        /// The file that holds the name, as the user named that file.
        file: String,
        /// The element inside it: `robot 1: urdf`, `mesh "package://arm/a.stl"`.
        element: String,
        /// The files that were tried, and what was expected.
        problem: String,
        /// Kind of the error of the operating system.
        kind: std::io::ErrorKind,
    },
    /// A configuration is not a point of the configuration space.
    #[error("configuration: {element}: got {value}, expected {expected}")]
    Config {
        /// The coordinate or joint at fault.
        element: String,
        /// The value that was found.
        value: String,
        /// Description of the allowed values.
        expected: String,
    },
    /// A model file is truncated, altered, foreign or of another version.
    #[error("model {}: {problem}", shown(path))]
    Model {
        /// Path of the file.
        path: PathBuf,
        /// Description of what is wrong.
        problem: String,
    },
    /// An option has a value that makes no sense.
    #[error("option {name}: got {value}, expected {expected}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// The value that was found.
        value: String,
        /// Description of the allowed values.
        expected: String,
    },
    /// Uniform configurations of a wanted label are too rare to draw.
    #[error("{0}")]
    Unlikely(String),
    /// Learning ended without a single free configuration, so no query could be answered.
    #[error("no collision-free configuration among {labels} tried: {advice}")]
    NothingFree {
        /// Number of labels spent.
        labels: usize,
        /// Advice on what the user can change.
        advice: String,
    },
    /// The caller stopped a long job before anything usable existed.
    #[error("interrupted before a usable result existed")]
    Interrupted,
}

/// Limits of a name and of a problem in a message \[bytes\]: files may hold values of megabytes.
const MAX_ELEMENT_BYTES: usize = 400;
const MAX_PROBLEM_BYTES: usize = 1600;
/// Limits of one quoted value and of one warning \[bytes\].
const MAX_VALUE_BYTES: usize = 200;
const MAX_WARNING_BYTES: usize = 2000;
/// Limits on the names that a message lists, and on the warnings of one scene.
pub const MOST_LISTED: usize = 12;
const MAX_WARNINGS: usize = 1000;

/// Returns `text`, or its beginning and end if it is longer than `most` bytes. Every message that
/// repeats content of a file uses it.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    if text.len() <= most {
        return Cow::Borrowed(text);
    }
    let (mut head, mut tail) = (most * 2 / 3, text.len() - most / 4);
    while !text.is_char_boundary(head) {
        head -= 1;
    }
    while !text.is_char_boundary(tail) {
        tail += 1;
    }
    Cow::Owned(format!("{} .. {} bytes left out .. {}", &text[..head], tail - head, &text[tail..]))
}

/// Shortens a value of a file to the length that messages quote.
pub fn quoted(value: &str) -> Cow<'_, str> {
    shortened(value, MAX_VALUE_BYTES)
}

/// Shortens a path to the length that messages repeat.
pub fn shown(path: &Path) -> String {
    name(path.display().to_string())
}

/// Joins names with commas; of many names, it gives the first ones and the number of the others.
pub fn listed<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(MOST_LISTED).map(|name| quoted(name.as_ref()).into_owned()).collect();
    match names.count() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Shortens each warning to some kilobytes, and the list to a thousand.
pub fn bounded(mut warnings: Vec<String>) -> Vec<String> {
    let more = warnings.len().saturating_sub(MAX_WARNINGS);
    warnings.truncate(MAX_WARNINGS);
    for warning in &mut warnings {
        if let Cow::Owned(short) = shortened(warning, MAX_WARNING_BYTES) {
            *warning = short;
        }
    }
    if more > 0 {
        warnings.push(format!("{more} more warnings are left out"));
    }
    warnings
}

impl Error {
    /// Makes an [`Error::Input`] and leaves out what would make its message longer than some
    /// kilobytes.
    pub fn input(file: impl Into<String>, element: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Input {
            file: name(file),
            element: part(element, MAX_ELEMENT_BYTES),
            problem: part(problem, MAX_PROBLEM_BYTES),
        }
    }

    /// Makes an [`Error::Named`], shortened in the same way.
    pub fn named(
        file: impl Into<String>,
        element: impl Into<String>,
        problem: impl Into<String>,
        kind: std::io::ErrorKind,
    ) -> Self {
        let (element, problem) = (part(element, MAX_ELEMENT_BYTES), part(problem, MAX_PROBLEM_BYTES));
        Self::Named { file: name(file), element, problem, kind }
    }

    /// Makes an [`Error::Named`] for a file that does not exist.
    pub fn not_found(file: impl Into<String>, element: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::named(file, element, problem, std::io::ErrorKind::NotFound)
    }
}

fn part(text: impl Into<String>, most: usize) -> String {
    let text = text.into();
    match shortened(&text, most) {
        Cow::Owned(short) => short,
        Cow::Borrowed(_) => text,
    }
}

/// Shortens the name of a file, since files may name others by paths of any length.
fn name(file: impl Into<String>) -> String {
    part(file, MAX_ELEMENT_BYTES)
}

/// `Result` with the library's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_readable_whatever_files_hold() {
        let message =
            Error::input("r.urdf", "link".repeat(1000), format!("got \"{}\", expected 3", "\u{e4}1 ".repeat(1 << 20)));
        let message = message.to_string();
        assert!(message.len() < 4000 && message.ends_with("\", expected 3"), "{message}");
        assert!(message.starts_with("r.urdf: linklink") && message.contains("got \"\u{e4}1 "), "{message}");
        assert_eq!(shortened(&"x".repeat(400), 400), "x".repeat(400));
        let path = || PathBuf::from("p".repeat(1 << 20));
        let source = || std::io::Error::from(std::io::ErrorKind::NotFound);
        let named: [Error; 3] = [
            Error::Read { path: path(), source: source() },
            Error::Write { path: path(), source: source() },
            Error::Model { path: path(), problem: "truncated".into() },
        ];
        for message in named.map(|error| error.to_string()) {
            assert!(message.len() < 600 && message.contains("bytes left out"), "{message}");
        }
        assert!(Error::not_found("f".repeat(5000), "e", "p".repeat(5000)).to_string().len() < 4000);
    }

    #[test]
    fn lists_and_warnings_are_cut() {
        let many: Vec<String> = (0..20_000).map(|k| format!("{k}")).collect();
        assert_eq!(listed(&many[..3]), "0, 1, 2");
        assert!(listed(&many).ends_with("10, 11 and 19988 more"), "{}", listed(&many));
        assert!(listed(["x".repeat(1 << 20)]).len() < 300);
        let told = bounded(many.into_iter().map(|name| name.repeat(1000)).collect());
        assert!(told.len() == 1001 && told[1000] == "19000 more warnings are left out");
        assert!(told.iter().all(|warning| warning.len() < 2100));
    }
}

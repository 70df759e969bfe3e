//! What can go wrong, in one enum: every message names the file, the element, the value and what
//! was expected.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Any failure of the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {}: {source}", shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", shown(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A scene, robot or mesh file says something that cannot be used.
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
        /// The file that names it, as the user named that.
        file: String,
        /// The element inside it: `robot 1: urdf`, `mesh "package://arm/a.stl"`.
        element: String,
        /// The files that were looked for, and what was expected.
        problem: String,
        /// What the operating system said of them.
        kind: std::io::ErrorKind,
    },
    /// A configuration is not a point of the configuration space.
    #[error("configuration: {element}: got {value}, expected {expected}")]
    Config {
        /// The coordinate or joint.
        element: String,
        /// The value found.
        value: String,
        /// What was expected.
        expected: String,
    },
    /// A model file is truncated, altered, foreign or of another version.
    #[error("model {}: {problem}", shown(path))]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// An option has a value that makes no sense.
    #[error("option {name}: got {value}, expected {expected}")]
    Option {
        /// The option's name.
        name: &'static str,
        /// The value found.
        value: String,
        /// What was expected.
        expected: String,
    },
    /// Uniform configurations of a wanted label are too rare to draw.
    #[error("{0}")]
    Unlikely(String),
    /// Learning ended without a single free configuration, so no query could be answered.
    #[error("no collision-free configuration among {labels} tried: {advice}")]
    NothingFree {
        /// Labels spent.
        labels: usize,
        /// What the user can do.
        advice: String,
    },
    /// The caller stopped a long job before anything usable existed.
    #[error("interrupted before a usable result existed")]
    Interrupted,
}

/// Most of a name, and of what is wrong, that a message repeats \[bytes\]: files may hold values of
/// megabytes.
const LONGEST_ELEMENT: usize = 400;
const LONGEST_PROBLEM: usize = 1600;
/// Most of one value that a message quotes, and most of a warning \[bytes\].
pub const LONGEST_VALUE: usize = 200;
const LONGEST_WARNING: usize = 2000;
/// Most names that a message lists, and most warnings of one scene.
pub const MOST_LISTED: usize = 12;
const MOST_WARNINGS: usize = 1000;

/// `text`, or its beginning and its end where it is longer than `most` bytes. Every message that
/// repeats what a file says goes through it.
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

/// A value of a file, as long as messages quote values.
pub fn quoted(value: &str) -> Cow<'_, str> {
    shortened(value, LONGEST_VALUE)
}

/// A path, as long as messages repeat names.
pub fn shown(path: &Path) -> String {
    name(path.display().to_string())
}

/// Names between commas; where there are many, the first of them and how many more.
pub fn listed<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(MOST_LISTED).map(|name| quoted(name.as_ref()).into_owned()).collect();
    match names.count() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Warnings as they are told: none longer than some kilobytes, and not more than a thousand.
pub fn bounded(mut warnings: Vec<String>) -> Vec<String> {
    let more = warnings.len().saturating_sub(MOST_WARNINGS);
    warnings.truncate(MOST_WARNINGS);
    for warning in &mut warnings {
        if let Cow::Owned(short) = shortened(warning, LONGEST_WARNING) {
            *warning = short;
        }
    }
    if more > 0 {
        warnings.push(format!("{more} more warnings are left out"));
    }
    warnings
}

impl Error {
    /// Shorthand for [`Error::Input`]; what would make the message longer than some kilobytes is
    /// left out.
    pub fn input(file: impl Into<String>, element: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Input {
            file: name(file),
            element: part(element, LONGEST_ELEMENT),
            problem: part(problem, LONGEST_PROBLEM),
        }
    }

    /// Shorthand for [`Error::Named`], shortened in the same way.
    pub fn named(
        file: impl Into<String>,
        element: impl Into<String>,
        problem: impl Into<String>,
        kind: std::io::ErrorKind,
    ) -> Self {
        let (element, problem) = (part(element, LONGEST_ELEMENT), part(problem, LONGEST_PROBLEM));
        Self::Named { file: name(file), element, problem, kind }
    }

    /// [`Error::named`] where there is no such file.
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

/// The name of a file: files may name others by paths of any length.
fn name(file: impl Into<String>) -> String {
    part(file, LONGEST_ELEMENT)
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

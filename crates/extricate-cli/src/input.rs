//! Configurations from a file or standard input: JSON lines, each checked against the configuration space.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use anyhow::{Context, bail};
use extricate::{Config, ConfigSpace};
use serde::Serialize;
use serde_json::Value;

use crate::args::Limits;
use crate::notice;

/// Longest line that is read \[bytes\].
const LONGEST_LINE: usize = 1 << 24;
/// Pieces of [`LONGEST_LINE`] bytes that a longer line is skipped by; after them no end is to be expected.
const MOST_PIECES: usize = 64;

/// Configurations of one input, in order.
pub struct Configs {
    reader: Box<dyn BufRead>,
    name: String,
    line: usize,
    bytes_read: u64,
    bytes_total: Option<u64>,
    good: usize,
    bad: usize,
    limits: Limits,
}

/// A line that is no configuration of the scene.
#[derive(Debug, Serialize)]
pub struct BadLine {
    /// Its number, from 1.
    pub line: usize,
    /// What was found and what was expected.
    pub error: String,
}

/// A configuration and the number of its line.
pub type Entry = Result<(usize, Config), BadLine>;
/// The two ends of a segment and the number of its line.
pub type SegmentEntry = Result<(usize, [Config; 2]), BadLine>;

impl Configs {
    /// Opens a file, or standard input for `-`.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::new(Box::new(std::io::stdin().lock()), "standard input", None));
        }
        let name = path.display().to_string();
        let file = File::open(path).with_context(|| format!("cannot read {name}"))?;
        let metadata = file.metadata().with_context(|| format!("cannot read {name}"))?;
        if metadata.is_dir() {
            bail!("cannot read {name}: it is a directory, expected JSON lines");
        }
        let total = metadata.is_file().then_some(metadata.len());
        Ok(Self::new(Box::new(BufReader::new(file)), &name, total))
    }

    /// Configurations as they stand on the command line, their coordinates between commas.
    pub fn of_words(words: &[String]) -> Self {
        let lines: String = words.iter().map(|word| format!("[{word}]\n")).collect();
        Self::new(Box::new(Cursor::new(lines)), "--q", None)
    }

    fn new(reader: Box<dyn BufRead>, name: &str, bytes_total: Option<u64>) -> Self {
        Self { reader, name: name.into(), line: 0, bytes_read: 0, bytes_total, good: 0, bad: 0, limits: Limits::Refuse }
    }

    /// What becomes of configurations beyond the joint limits; they are refused where nothing is
    /// said.
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// The next line that is not empty, or `None` at the end.
    ///
    /// # Errors
    /// Where reading fails; a bad line is an [`Entry`], not an error.
    pub fn next(&mut self, space: &ConfigSpace) -> anyhow::Result<Option<Entry>> {
        let expected = format!("{} numbers", space.nq());
        let limits = self.limits;
        self.next_parsed(&expected, |text| parse_config(text, space, limits))
    }

    /// As [`Configs::next`], for pairs of configurations.
    ///
    /// # Errors
    /// Where reading fails.
    pub fn next_segment(&mut self, space: &ConfigSpace) -> anyhow::Result<Option<SegmentEntry>> {
        let expected = format!("two configurations of {} numbers", space.nq());
        self.next_parsed(&expected, |text| parse_segment(text, space))
    }

    fn next_parsed<T>(
        &mut self,
        expected: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> anyhow::Result<Option<Result<(usize, T), BadLine>>> {
        let mut raw = Vec::new();
        loop {
            let failed = || format!("cannot read {} after line {}", self.name, self.line);
            let is_cut = read_line(&mut *self.reader, &mut raw, &mut self.bytes_read).with_context(failed)?;
            if raw.is_empty() {
                return Ok(None);
            }
            self.line += 1;
            let parsed = match std::str::from_utf8(&raw) {
                _ if is_cut => Err(format!("got more than {LONGEST_LINE} bytes, expected {expected}")),
                // Editors on some systems begin a file with a byte order mark.
                Ok(text) => match text.trim_start_matches('\u{feff}').trim() {
                    "" => continue,
                    text => parse(text),
                },
                Err(_) => Err("not UTF-8 text, expected a line of JSON".into()),
            };
            let line = self.line;
            return Ok(Some(match parsed {
                Ok(parsed) => {
                    self.good += 1;
                    Ok((line, parsed))
                }
                Err(error) => {
                    self.bad += 1;
                    Err(BadLine { line, error })
                }
            }));
        }
    }

    /// Tells the user of a bad line, with the name of the input and the number.
    pub fn report(&self, bad: &BadLine) {
        notice::error(format_args!("{}: line {}: {}", self.name, bad.line, bad.error));
    }

    /// Share of the input that was read, where its length is known.
    pub fn fraction(&self) -> Option<f64> {
        self.bytes_total.map(|total| self.bytes_read as f64 / total.max(1) as f64)
    }

    /// Whether lines may come one at a time from a program that waits for each answer.
    pub fn is_stream(&self) -> bool {
        self.bytes_total.is_none()
    }

    /// Ends the run.
    ///
    /// # Errors
    /// Where any line was bad.
    pub fn conclude(&self) -> anyhow::Result<()> {
        if self.good + self.bad == 0 {
            notice::warning(format_args!("{}: no configurations in it", self.name));
        }
        if self.bad > 0 {
            let total = self.good + self.bad;
            let others = if self.good > 0 { "; the others were answered" } else { "" };
            bail!("{}: {} of {total} configurations could not be used{others}", self.name, self.bad);
        }
        Ok(())
    }
}

/// Reads a line into `raw`, with its end, counting its bytes. Where it is too long, the answer is `true` and the rest is
/// skipped.
fn read_line(reader: &mut dyn BufRead, raw: &mut Vec<u8>, bytes_read: &mut u64) -> std::io::Result<bool> {
    let mut piece = |raw: &mut Vec<u8>| -> std::io::Result<bool> {
        raw.clear();
        let read = reader.take(LONGEST_LINE as u64).read_until(b'\n', raw)?;
        *bytes_read += read as u64;
        Ok(read == LONGEST_LINE && raw.last() != Some(&b'\n'))
    };
    if !piece(raw)? {
        return Ok(false);
    }
    for _ in 0..MOST_PIECES {
        if !piece(raw)? {
            // What is left of it would be read as an end of the input.
            raw.push(b'\n');
            return Ok(true);
        }
    }
    Err(std::io::Error::other("the line does not end"))
}

/// One line: `{"q": [...]}` (other keys are ignored) or a bare array.
pub fn parse_config(text: &str, space: &ConfigSpace, limits: Limits) -> Result<Config, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| explain_syntax(text, &error, "\"q\""))?;
    let found = match value {
        Value::Object(mut map) => match map.remove("q") {
            Some(q) => q,
            None => return Err(format!("{}, expected one with \"q\"", list_keys(&map))),
        },
        other => other,
    };
    config_of(&found, space, limits)
}

/// One line: `{"from": [...], "to": [...]}` (other keys are ignored) or an array of two arrays.
pub fn parse_segment(text: &str, space: &ConfigSpace) -> Result<[Config; 2], String> {
    let keys = "\"from\" and \"to\"";
    let value: Value = serde_json::from_str(text).map_err(|error| explain_syntax(text, &error, keys))?;
    let ends = match value {
        Value::Object(mut map) => match (map.remove("from"), map.remove("to")) {
            (Some(from), Some(to)) => [from, to],
            (None, Some(_)) => return Err("got an object with \"to\" but without \"from\", expected both".into()),
            (Some(_), None) => return Err("got an object with \"from\" but without \"to\", expected both".into()),
            (None, None) => return Err(format!("{}, expected one with {keys}", list_keys(&map))),
        },
        Value::Array(ends) => <[Value; 2]>::try_from(ends)
            .map_err(|ends| format!("got an array of {}, expected one of two configurations", ends.len()))?,
        other => return Err(format!("got {}, expected two configurations", describe(&other))),
    };
    let [from, to] = ends;
    let from = config_of(&from, space, Limits::Refuse).map_err(|fault| format!("from: {fault}"))?;
    let to = config_of(&to, space, Limits::Refuse).map_err(|fault| format!("to: {fault}"))?;
    Ok([from, to])
}

fn config_of(found: &Value, space: &ConfigSpace, limits: Limits) -> Result<Config, String> {
    let Value::Array(elements) = found else {
        return Err(format!("got {}, expected an array of {} numbers", describe(found), space.nq()));
    };
    let mut numbers = Vec::with_capacity(elements.len());
    for (index, element) in elements.iter().enumerate() {
        match element.as_f64() {
            Some(number) => numbers.push(number),
            None => return Err(format!("coordinate {index}: got {}, expected a finite number", describe(element))),
        }
    }
    let config = match limits {
        Limits::Forgive => space.config_anywhere(&numbers),
        Limits::Refuse => space.config(&numbers),
    };
    config.map_err(|error| error.to_string())
}

fn list_keys(map: &serde_json::Map<String, Value>) -> String {
    let keys: Vec<_> = map.keys().map(|k| format!("\"{}\"", shorten(k))).take(MOST_KEYS).collect();
    let more = if map.len() > MOST_KEYS { " and more" } else { "" };
    let keys = if keys.is_empty() { "no keys".into() } else { keys.join(", ") + more };
    format!("got an object with {keys}")
}

/// Keys that a message lists.
const MOST_KEYS: usize = 4;

/// JSON has no NaN and no infinities; the parser only says that it expected a value.
fn explain_syntax(text: &str, error: &serde_json::Error, keys: &str) -> String {
    let word = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '+' && c != '-').find(|word| {
        matches!(word.trim_start_matches(['+', '-']).to_ascii_lowercase().as_str(), "nan" | "inf" | "infinity")
    });
    match word {
        Some(word) => format!("got {word}, expected a finite number"),
        None => format!("not JSON ({error}), got {}, expected an array or an object with {keys}", shorten(text)),
    }
}

fn describe(value: &Value) -> String {
    let kind = match value {
        Value::Null => return "null".into(),
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    };
    format!("{} ({kind})", shorten(&value.to_string()))
}

/// The beginning of a text, on one line.
fn shorten(text: &str) -> String {
    const MOST: usize = 40;
    let printed = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.into() };
    let cut = if text.chars().nth(MOST).is_some() { "..." } else { "" };
    text.chars().take(MOST).map(printed).chain([cut.into()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::Manifold;

    fn space() -> ConfigSpace {
        let mut space = ConfigSpace::default();
        space.push("shoulder", Manifold::Interval { lower: -1.0, upper: 2.0 }, 1.0);
        space.push("turn", Manifold::Circle, 1.0);
        space
    }

    #[test]
    fn both_spellings_are_read() {
        let space = space();
        assert_eq!(&*parse_config("[0.5, 1]", &space, Limits::Refuse).unwrap(), &[0.5, 1.0]);
        assert_eq!(&*parse_config(r#"{"id": 3, "q": [0.5, -1e-3]}"#, &space, Limits::Refuse).unwrap(), &[0.5, -1e-3]);
    }

    #[test]
    fn every_fault_names_the_value_and_what_was_expected() {
        let space = space();
        for (text, found, expected) in [
            ("[NaN, 0]", "got NaN", "finite number"),
            ("[0, -Infinity]", "got -Infinity", "finite number"),
            ("[1e999, 0]", "1e999", "not JSON"),
            ("[\"0.5\", 0]", "coordinate 0: got \"0.5\" (a string)", "finite number"),
            ("[0, [1]]", "coordinate 1: got [1] (an array)", "finite number"),
            ("[null, 0]", "got null", "finite number"),
            ("[true, 0]", "got true (a boolean)", "finite number"),
            ("[0]", "got 1", "2 coordinates"),
            ("[]", "got 0", "2 coordinates"),
            ("[2.5, 0]", "`shoulder` (coordinate 0): got 2.5", "[-1, 2]"),
            ("{\"p\": [0, 0]}", "an object with \"p\"", "one with \"q\""),
            ("{}", "no keys", "one with \"q\""),
            ("{\"q\": 7}", "got 7 (a number)", "array of 2 numbers"),
            ("\"q\"", "got \"q\" (a string)", "array of 2 numbers"),
            ("[0, 0] [1, 1]", "[0, 0] [1, 1]", "not JSON"),
            ("hello", "got hello", "expected an array or an object"),
            ("[0,0]\r[1,1]", "got [0,0]\\r[1,1]", "not JSON"),
            ("{\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1}", "\"c\", \"d\" and more", "one with \"q\""),
        ] {
            let message = parse_config(text, &space, Limits::Refuse).unwrap_err();
            assert!(message.contains(found), "{text}: {message}");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn segments_are_read_and_faults_name_the_end() {
        let space = space();
        for text in ["[[0.5, 1], [0, 2]]", r#"{"to": [0, 2], "id": 3, "from": [0.5, 1]}"#] {
            let [from, to] = parse_segment(text, &space).unwrap();
            assert_eq!((&*from, &*to), (&[0.5, 1.0][..], &[0.0, 2.0][..]));
        }
        for (text, found, expected) in [
            ("[[0, 0]]", "an array of 1", "two configurations"),
            ("[0, 0]", "from: got 0 (a number)", "array of 2 numbers"),
            ("[[0, 0], [9, 0]]", "to: ", "[-1, 2]"),
            ("{\"from\": [0, 0]}", "without \"to\"", "both"),
            ("{\"to\": [0, 0]}", "without \"from\"", "both"),
            ("{\"q\": [0, 0]}", "an object with \"q\"", "\"from\" and \"to\""),
            ("7", "7 (a number)", "two configurations"),
            ("[[0, 0], [NaN, 0]]", "got NaN", "finite number"),
            ("hello", "hello", "\"from\" and \"to\""),
        ] {
            let message = parse_segment(text, &space).unwrap_err();
            assert!(message.contains(found), "{text}: {message}");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn lines_keep_their_numbers_and_bad_ones_do_not_end_the_input() {
        let text = "\u{feff}[0, 0]\r\n\n  \n{\"q\": [9, 0]}\n[1, 1]";
        let mut configs = Configs::new(Box::new(text.as_bytes()), "x", Some(text.len() as u64));
        let space = space();
        let mut seen = Vec::new();
        while let Some(entry) = configs.next(&space).unwrap() {
            seen.push(match entry {
                Ok((line, _)) => (line, true),
                Err(bad) => (bad.line, false),
            });
        }
        assert_eq!(seen, [(1, true), (4, false), (5, true)]);
        assert_eq!(configs.fraction(), Some(1.0));
        assert!(configs.conclude().unwrap_err().to_string().contains("1 of 3"));
    }

    #[test]
    fn a_line_without_end_ends_the_input() {
        let mut configs = Configs::new(Box::new(BufReader::new(std::io::repeat(b' '))), "x", None);
        let error = format!("{:#}", configs.next(&space()).err().unwrap());
        assert_eq!(error, "cannot read x after line 0: the line does not end");
    }

    #[test]
    fn a_line_that_is_too_long_is_one_bad_line() {
        let text = format!("{}\n[0, 0]\n", " ".repeat(LONGEST_LINE + 3));
        let length = text.len() as u64;
        let mut configs = Configs::new(Box::new(std::io::Cursor::new(text)), "x", Some(length));
        assert!(configs.next(&space()).unwrap().unwrap().unwrap_err().error.contains("got more than 16777216 bytes"));
        assert_eq!(configs.next(&space()).unwrap().unwrap().unwrap().0, 2);
        assert_eq!(configs.fraction(), Some(1.0));
    }

    #[test]
    fn bytes_that_are_no_text_are_one_bad_line() {
        let mut configs = Configs::new(Box::new(&b"\xff\xfe\n[0, 0]\n"[..]), "x", None);
        let space = space();
        assert!(configs.next(&space).unwrap().unwrap().unwrap_err().error.contains("UTF-8"));
        assert!(configs.next(&space).unwrap().unwrap().is_ok());
        assert!(configs.next(&space).unwrap().is_none());
    }
}

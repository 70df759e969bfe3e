//! Configurations from a file, standard input or the command line, one a line, each checked against
//! the configuration space. What a line may say is in `line`, and of paths in `path`; which of the
//! bad lines are told is in `repeated`.

mod line;
mod path;
mod repeated;
mod unique;

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use anyhow::{Context, bail};
use extricate::{Config, Scene};
use serde::Serialize;

use crate::args::Limits;
use crate::{notice, report};
use line::{Reading, parse_config, parse_segment};
use repeated::Repeated;

/// Longest line that is read \[bytes\].
const LONGEST_LINE: usize = 1 << 24;
/// Pieces of [`LONGEST_LINE`] bytes that a longer line is skipped by; after them no end is to be
/// expected.
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
    reading: Reading,
    told: RefCell<Repeated>,
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

/// The first waypoint of a path, those behind it, and the number of the line.
pub type PathEntry = Result<(usize, (Config, Vec<Config>)), BadLine>;

/// The waypoints of a line, and its number.
pub type WaypointsEntry = Result<(usize, Vec<Config>), BadLine>;

/// A grasp, the file and the scale of its object, and the number of the line.
pub type GraspEntry = Result<(usize, (Config, Option<(String, f64)>)), BadLine>;

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
            bail!("cannot read {name}: it is a directory, expected lines of text");
        }
        let total = metadata.is_file().then_some(metadata.len());
        Ok(Self::new(Box::new(BufReader::new(file)), &name, total))
    }

    /// Configurations as they stand on the command line, one a word.
    pub fn of_words(words: &[String]) -> Self {
        let lines: String = words.iter().map(|word| word.replace('\n', " ") + "\n").collect();
        let mut configs = Self::new(Box::new(Cursor::new(lines)), "--q", None);
        configs.reading.may_be_heading = false;
        configs
    }

    /// One configuration as it stands on the command line; `name` is the option's.
    pub fn of_word(name: &str, word: &str) -> Self {
        let mut configs = Self::new(Box::new(Cursor::new(word.replace('\n', " "))), name, None);
        configs.reading.may_be_heading = false;
        configs
    }

    /// Configurations of any text; `name` is what messages call it.
    pub fn new(reader: Box<dyn BufRead>, name: &str, bytes_total: Option<u64>) -> Self {
        let (reading, told) = (Reading::default(), RefCell::default());
        Self { reader, name: name.into(), line: 0, bytes_read: 0, bytes_total, good: 0, bad: 0, reading, told }
    }

    /// What becomes of configurations beyond the joint limits; they are refused where nothing is
    /// said.
    pub fn with_limits(mut self, limits: Limits) -> Self {
        self.reading.limits = limits;
        self
    }

    /// The next line with a configuration, or `None` at the end.
    ///
    /// # Errors
    /// Where reading fails; a bad line is an [`Entry`], not an error.
    pub fn next(&mut self, scene: &Scene) -> anyhow::Result<Option<Entry>> {
        let expected = format!("{} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| parse_config(text, scene, reading))
    }

    /// As [`Configs::next`], for pairs of configurations.
    ///
    /// # Errors
    /// If the input cannot be read any further.
    pub fn next_segment(&mut self, scene: &Scene) -> anyhow::Result<Option<SegmentEntry>> {
        let expected = format!("two configurations of {} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| parse_segment(text, scene, reading).map(Some))
    }

    /// As [`Configs::next`], with the object that is held: a file and a scale, where a line has to
    /// name one.
    ///
    /// # Errors
    /// If the input cannot be read any further.
    pub fn next_grasp(&mut self, scene: &Scene, names_object: bool) -> anyhow::Result<Option<GraspEntry>> {
        let expected = format!("{} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| {
            let Some(q) = parse_config(text, scene, reading)? else { return Ok(None) };
            let object = if names_object { Some(line::parse_object(text)?) } else { None };
            Ok(Some((q, object)))
        })
    }

    /// As [`Configs::next`], for paths: the first waypoint and those behind it.
    ///
    /// # Errors
    /// If the input cannot be read any further.
    pub fn next_path(&mut self, scene: &Scene) -> anyhow::Result<Option<PathEntry>> {
        let expected = format!("configurations of {} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| path::parse_path(text, scene, reading).map(Some))
    }

    /// As [`Configs::next`], for one path: the waypoints of a line, a configuration as there, or a
    /// whole path as [`Configs::next_path`] takes it.
    ///
    /// # Errors
    /// If the input cannot be read any further.
    pub fn next_waypoints(&mut self, scene: &Scene) -> anyhow::Result<Option<WaypointsEntry>> {
        let expected = format!("configurations of {} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| path::parse_waypoints(text, scene, reading))
    }

    fn next_parsed<T>(
        &mut self,
        expected: &str,
        parse: impl Fn(&str, &mut Reading) -> Result<Option<T>, String>,
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
                    text if text.starts_with('#') => continue,
                    text => match parse(text, &mut self.reading).transpose() {
                        Some(parsed) => parsed,
                        None => continue,
                    },
                },
                Err(_) => Err("not UTF-8 text, expected a configuration a line".into()),
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

    /// What there is to say of the lines since it was asked last, each once in a run.
    pub fn take_notes(&mut self) -> Vec<String> {
        let notes = self.reading.take_notes();
        notes.into_iter().map(|note| format!("{}: line {}: {note}", self.name, self.line)).collect()
    }

    /// Tells the user of a bad line, with the name of the input and the number, unless one like it
    /// was told; [`Configs::conclude`] tells how many those are.
    pub fn report(&self, bad: &BadLine) {
        if self.told.borrow_mut().is_new(bad.line, &bad.error) {
            notice::error(format_args!("{}: line {}: {}", self.name, bad.line, bad.error));
        }
    }

    /// Share of the input that was read, where its length is known.
    pub fn fraction(&self) -> Option<f64> {
        self.bytes_total.map(|total| self.bytes_read as f64 / total.max(1) as f64)
    }

    /// Whether lines may come one at a time from a program that waits for each answer.
    pub fn is_stream(&self) -> bool {
        self.bytes_total.is_none()
    }

    /// Ends the run, and tells how many lines there were like those that were reported.
    ///
    /// # Errors
    /// Where any line was bad.
    pub fn conclude(&self) -> anyhow::Result<()> {
        for words in self.told.take().in_words() {
            notice::error(format_args!("{}: {words}", self.name));
        }
        if self.good + self.bad == 0 {
            notice::warning(format_args!("{}: no configurations in it", self.name));
        }
        if self.bad > 0 {
            let total = self.good + self.bad;
            let others = if self.good > 0 { "; the others were answered" } else { "" };
            let all = report::counted(total, "configuration", "configurations");
            bail!("{}: {} of {all} could not be used{others}", self.name, report::count(self.bad));
        }
        Ok(())
    }
}

/// Reads a line into `raw`, with its end, counting its bytes. Where it is too long, the answer is
/// `true` and the rest is skipped.
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

#[cfg(test)]
mod tests {
    use super::line::tests::scene;
    use super::*;

    #[test]
    fn lines_keep_their_numbers_and_bad_ones_do_not_end_the_input() {
        let text = "\u{feff}[0, 0]\r\n\n  \n{\"q\": [9, 0]}\n[1, 1]";
        let mut configs = Configs::new(Box::new(text.as_bytes()), "x", Some(text.len() as u64));
        let scene = scene();
        let mut seen = Vec::new();
        while let Some(entry) = configs.next(&scene).unwrap() {
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
        let error = format!("{:#}", configs.next(&scene()).err().unwrap());
        assert_eq!(error, "cannot read x after line 0: the line does not end");
    }

    #[test]
    fn a_line_that_is_too_long_is_one_bad_line() {
        let text = format!("{}\n[0, 0]\n", " ".repeat(LONGEST_LINE + 3));
        let length = text.len() as u64;
        let mut configs = Configs::new(Box::new(std::io::Cursor::new(text)), "x", Some(length));
        assert!(configs.next(&scene()).unwrap().unwrap().unwrap_err().error.contains("got more than 16777216 bytes"));
        assert_eq!(configs.next(&scene()).unwrap().unwrap().unwrap().0, 2);
        assert_eq!(configs.fraction(), Some(1.0));
    }

    #[test]
    fn bytes_that_are_no_text_are_one_bad_line() {
        let mut configs = Configs::new(Box::new(&b"\xff\xfe\n[0, 0]\n"[..]), "x", None);
        let scene = scene();
        assert!(configs.next(&scene).unwrap().unwrap().unwrap_err().error.contains("UTF-8"));
        assert!(configs.next(&scene).unwrap().unwrap().is_ok());
        assert!(configs.next(&scene).unwrap().is_none());
    }
}

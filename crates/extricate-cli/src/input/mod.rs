//! Reads configurations from a file, standard input or the command line, one per line, and checks
//! them against the configuration space. `line` and `path` parse a line; `repeated` decides which
//! bad lines are reported.

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
use crate::progress::Progress;
use crate::{notice, report};
use line::{Reading, parse_config, parse_segment};
use repeated::Repeated;

/// Longest line that is read \[bytes\].
const MAX_LINE_BYTES: usize = 1 << 24;
/// Pieces of [`MAX_LINE_BYTES`] bytes by which a longer line is skipped; a line that has not ended
/// then is an error.
const MAX_PIECES: usize = 64;

/// Lines that are read before several threads answer them.
const BLOCK_LINES: usize = 1024;

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

/// A line that contains no configuration of the scene.
#[derive(Debug, Serialize)]
pub struct BadLine {
    /// Number of the line, from 1.
    pub line: usize,
    /// Description of what was found and what was expected.
    pub error: String,
}

/// A configuration and the number of its line.
pub type Entry = Result<(usize, Config), BadLine>;
/// The two ends of a segment and the number of its line.
pub type SegmentEntry = Result<(usize, [Config; 2]), BadLine>;

/// The first waypoint of a path, those after it, and the number of the line.
pub type PathEntry = Result<(usize, (Config, Vec<Config>)), BadLine>;

/// The waypoints of a line and its number.
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

    /// Reads the configurations of the command line, one per word.
    pub fn of_words(words: &[String]) -> Self {
        let lines: String = words.iter().map(|word| word.replace('\n', " ") + "\n").collect();
        let mut configs = Self::new(Box::new(Cursor::new(lines)), "--q", None);
        configs.reading.may_be_heading = false;
        configs
    }

    /// Reads one configuration of the command line; `name` is its option.
    pub fn of_word(name: &str, word: &str) -> Self {
        let mut configs = Self::new(Box::new(Cursor::new(word.replace('\n', " "))), name, None);
        configs.reading.may_be_heading = false;
        configs
    }

    /// Reads configurations from any text; `name` identifies it in messages.
    pub fn new(reader: Box<dyn BufRead>, name: &str, bytes_total: Option<u64>) -> Self {
        let (reading, told) = (Reading::default(), RefCell::default());
        Self { reader, name: name.into(), line: 0, bytes_read: 0, bytes_total, good: 0, bad: 0, reading, told }
    }

    /// Sets how configurations beyond the joint limits are treated; they are refused by default.
    pub fn with_limits(mut self, limits: Limits) -> Self {
        self.reading.limits = limits;
        self
    }

    /// Reads the next line with a configuration; returns `None` at the end.
    ///
    /// # Errors
    /// Fails if reading fails; a bad line is an [`Entry`], not an error.
    pub fn next(&mut self, scene: &Scene) -> anyhow::Result<Option<Entry>> {
        let expected = format!("{} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| parse_config(text, scene, reading))
    }

    /// Reads the next lines that several threads answer together; none at the end. From a program
    /// that waits for each answer, or for one thread, it reads one. Notes and bad lines are
    /// reported beside the progress.
    ///
    /// # Errors
    /// Fails if reading fails; a bad line is an [`Entry`], not an error.
    pub fn next_block(&mut self, scene: &Scene, threads: usize, progress: &Progress) -> anyhow::Result<Vec<Entry>> {
        let size = if threads == 1 || self.is_stream() { 1 } else { BLOCK_LINES };
        let mut block = Vec::new();
        while block.len() < size {
            let entry = self.next(scene)?;
            for note in self.take_notes() {
                progress.aside(|| notice::warning(note));
            }
            let Some(entry) = entry else { break };
            if let Err(bad) = &entry {
                progress.aside(|| self.report(bad));
            }
            block.push(entry);
        }
        Ok(block)
    }

    /// Reads the next pair of configurations, as [`Configs::next`] does.
    ///
    /// # Errors
    /// Fails if the input cannot be read any further.
    pub fn next_segment(&mut self, scene: &Scene) -> anyhow::Result<Option<SegmentEntry>> {
        let expected = format!("two configurations of {} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| parse_segment(text, scene, reading).map(Some))
    }

    /// Reads the next grasp, as [`Configs::next`] does. With `names_object` a line has to name the
    /// file and the scale of the object that is held.
    ///
    /// # Errors
    /// Fails if the input cannot be read any further.
    pub fn next_grasp(&mut self, scene: &Scene, names_object: bool) -> anyhow::Result<Option<GraspEntry>> {
        let expected = format!("{} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| {
            let Some(q) = parse_config(text, scene, reading)? else { return Ok(None) };
            let object = if names_object { Some(line::parse_object(text)?) } else { None };
            Ok(Some((q, object)))
        })
    }

    /// Reads the next path, as [`Configs::next`] does: the first waypoint and those after it.
    ///
    /// # Errors
    /// Fails if the input cannot be read any further.
    pub fn next_path(&mut self, scene: &Scene) -> anyhow::Result<Option<PathEntry>> {
        let expected = format!("configurations of {} numbers", scene.space().nq());
        self.next_parsed(&expected, |text, reading| path::parse_path(text, scene, reading).map(Some))
    }

    /// Reads the waypoints of the next line: one configuration as in [`Configs::next`], or a whole
    /// path as in [`Configs::next_path`].
    ///
    /// # Errors
    /// Fails if the input cannot be read any further.
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
                _ if is_cut => Err(format!("got more than {MAX_LINE_BYTES} bytes, expected {expected}")),
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

    /// Returns the notes on lines since the last call, each once in a run.
    pub fn take_notes(&mut self) -> Vec<String> {
        let notes = self.reading.take_notes();
        notes.into_iter().map(|note| format!("{}: line {}: {note}", self.name, self.line)).collect()
    }

    /// Reports a bad line with the name of the input and the number, unless one like it was
    /// reported. [`Configs::conclude`] reports their number.
    pub fn report(&self, bad: &BadLine) {
        if self.told.borrow_mut().is_new(bad.line, &bad.error) {
            notice::error(format_args!("{}: line {}: {}", self.name, bad.line, bad.error));
        }
    }

    /// Share of the input that was read, if its length is known.
    pub fn fraction(&self) -> Option<f64> {
        self.bytes_total.map(|total| self.bytes_read as f64 / total.max(1) as f64)
    }

    /// Whether lines may come one at a time from a program that waits for each answer.
    pub fn is_stream(&self) -> bool {
        self.bytes_total.is_none()
    }

    /// Ends the run, and reports how many lines were like those that were reported.
    ///
    /// # Errors
    /// Fails if any line was bad.
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

/// Reads a line with its end into `raw` and counts its bytes. If it is too long, skips the rest and
/// returns `true`.
fn read_line(reader: &mut dyn BufRead, raw: &mut Vec<u8>, bytes_read: &mut u64) -> std::io::Result<bool> {
    let mut piece = |raw: &mut Vec<u8>| -> std::io::Result<bool> {
        raw.clear();
        let read = reader.take(MAX_LINE_BYTES as u64).read_until(b'\n', raw)?;
        *bytes_read += read as u64;
        Ok(read == MAX_LINE_BYTES && raw.last() != Some(&b'\n'))
    };
    if !piece(raw)? {
        return Ok(false);
    }
    for _ in 0..MAX_PIECES {
        if !piece(raw)? {
            // An empty rest would be taken for the end of the input.
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
        let text = format!("{}\n[0, 0]\n", " ".repeat(MAX_LINE_BYTES + 3));
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

//! Standard output: whole lines, as text or as JSON.

use std::fmt::Display;
use std::io::{self, BufWriter, StdoutLock, Write};

use anyhow::Context;
use serde::Serialize;

use crate::notice::printable;

/// Lines on standard output.
///
/// Non-finite numbers become `null` in JSON, which has no word for them.
pub struct Output {
    writer: BufWriter<StdoutLock<'static>>,
    flush_lines: bool,
}

impl Output {
    /// Buffers; with `flush_lines` each line leaves at once, for a program that waits for it at the
    /// other end of a pipe.
    pub fn new(flush_lines: bool) -> Self {
        Self { writer: BufWriter::new(io::stdout().lock()), flush_lines }
    }

    /// Writes a line, or several, of text for people.
    pub fn line(&mut self, text: impl Display) -> anyhow::Result<()> {
        self.write(&printable(&text.to_string(), &['\n', '\t']))
    }

    fn write(&mut self, text: &str) -> anyhow::Result<()> {
        let written = writeln!(self.writer, "{text}");
        let flushed = written.and_then(|()| if self.flush_lines { self.writer.flush() } else { Ok(()) });
        flushed.context("cannot write to standard output")
    }

    /// Writes one value as one line of JSON.
    pub fn json(&mut self, value: &impl Serialize) -> anyhow::Result<()> {
        self.write(&serde_json::to_string(value)?)
    }

    /// Sends what was written so far on its way.
    pub fn flush(&mut self) -> anyhow::Result<()> {
        self.writer.flush().context("cannot write to standard output")
    }

    /// Writes what is still buffered.
    pub fn finish(mut self) -> anyhow::Result<()> {
        self.flush()
    }
}

//! Standard output: whole lines, as text or as JSON.

use std::fmt::Display;
use std::io::{self, BufWriter, StdoutLock, Write};

use anyhow::Context;
use serde::Serialize;

use crate::notice::printable;

/// Writes lines to standard output.
///
/// Non-finite numbers become `null`, because JSON cannot represent them.
pub struct Output {
    writer: BufWriter<StdoutLock<'static>>,
    flush_lines: bool,
}

impl Output {
    /// Buffers the output. With `flush_lines` each line is sent at once, for a program that waits
    /// for it at the other end of a pipe.
    pub fn new(flush_lines: bool) -> Self {
        Self { writer: BufWriter::new(io::stdout().lock()), flush_lines }
    }

    /// Writes one or more lines of text for people.
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

    pub fn flush(&mut self) -> anyhow::Result<()> {
        self.writer.flush().context("cannot write to standard output")
    }

    /// Flushes and reports failures, which dropping the buffer would ignore.
    pub fn finish(mut self) -> anyhow::Result<()> {
        self.flush()
    }
}

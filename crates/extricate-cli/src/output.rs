//! Standard output: whole lines, as text or as JSON.

use std::fmt::Display;
use std::io::{self, BufWriter, StdoutLock, Write};

use serde::Serialize;

/// Lines on standard output.
///
/// Non-finite numbers become `null` in JSON, which has no word for them.
pub struct Output {
    writer: BufWriter<StdoutLock<'static>>,
    flush_lines: bool,
}

impl Output {
    /// Buffers; with `flush_lines` each line leaves at once, for a program that waits for it at the other end of a pipe.
    pub fn new(flush_lines: bool) -> Self {
        Self { writer: BufWriter::new(io::stdout().lock()), flush_lines }
    }

    /// Writes one line.
    pub fn line(&mut self, text: impl Display) -> io::Result<()> {
        writeln!(self.writer, "{text}")?;
        if self.flush_lines { self.writer.flush() } else { Ok(()) }
    }

    /// Writes one value as one line of JSON.
    pub fn json(&mut self, value: &impl Serialize) -> io::Result<()> {
        let text = serde_json::to_string(value).map_err(io::Error::other)?;
        self.line(text)
    }

    /// Writes what is still buffered.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

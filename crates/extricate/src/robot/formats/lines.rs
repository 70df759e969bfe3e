//! A reader that counts lines, for parsers whose errors do not say where they were. Knows no
//! format.

use std::io::{BufRead, Error, ErrorKind, Read, Result, Seek, SeekFrom};

/// Returns one line at a time, so that even a parser with a large buffer never reads ahead of its
/// line.
pub(crate) struct CountedLines<'a> {
    text: &'a [u8],
    at: usize,
    /// Number, from 1, of the line that was read last.
    pub line: usize,
}

impl<'a> CountedLines<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text: text.as_bytes(), at: 0, line: 0 }
    }
}

impl BufRead for CountedLines<'_> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        let rest = &self.text[self.at..];
        Ok(match rest.iter().position(|&byte| byte == b'\n') {
            Some(end) => &rest[..=end],
            None => rest,
        })
    }

    fn consume(&mut self, count: usize) {
        if count > 0 && (self.at == 0 || self.text[self.at - 1] == b'\n') {
            self.line += 1;
        }
        self.at += count;
    }
}

impl Read for CountedLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let line = self.fill_buf()?;
        let count = line.len().min(buffer.len());
        buffer[..count].copy_from_slice(&line[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl Seek for CountedLines<'_> {
    /// Seeks to the beginning only, as parsers do after reading the first line to detect the
    /// format.
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        if to != SeekFrom::Start(0) {
            return Err(Error::new(ErrorKind::Unsupported, "only back to the beginning"));
        }
        (self.at, self.line) = (0, 0);
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_through_any_buffer() {
        let text = "first\n\nthird is longer\nlast";
        for capacity in [1, 4, 7, 100] {
            let mut counted = CountedLines::new(text);
            let mut reader = std::io::BufReader::with_capacity(capacity, &mut counted);
            for (number, expected) in text.lines().enumerate() {
                let mut line = String::new();
                reader.read_line(&mut line).unwrap();
                assert_eq!((line.trim_end(), reader.get_ref().line), (expected, number + 1));
            }
        }
    }

    #[test]
    fn it_starts_over() {
        let mut counted = CountedLines::new("a\nb\n");
        let read_all = |counted: &mut CountedLines| counted.lines().map_while(Result::ok).collect::<Vec<_>>();
        assert_eq!((read_all(&mut counted), counted.line), (vec!["a".to_owned(), "b".to_owned()], 2));
        counted.seek(SeekFrom::Start(0)).unwrap();
        assert_eq!((read_all(&mut counted).len(), counted.line), (2, 2));
        assert!(counted.seek(SeekFrom::End(0)).is_err());
    }
}

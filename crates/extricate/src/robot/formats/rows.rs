//! Rows of numbers in a text file: one per line, separated by blanks, commas or semicolons.

use super::without_mark;
use crate::error::{Error, Result, quoted};

/// Passes every row of a text to `take`, with the number of its line, from 1. Skips empty lines,
/// text after a `#`, and a first line of words.
///
/// # Errors
/// [`Error::Input`] of `element` in `file`: text that is not UTF-8, a word that is no number, or a
/// number that `accepts` refuses for its column; errors of `take`.
pub fn for_each_row(
    file: &str,
    element: &str,
    bytes: &[u8],
    accepts: impl Fn(usize, f64) -> bool,
    mut take: impl FnMut(usize, &[f64]) -> Result<()>,
) -> Result<()> {
    let text = std::str::from_utf8(without_mark(bytes)).map_err(|error| {
        let problem = "not UTF-8, expected a text file with a row of numbers a line";
        Error::input(file, format!("{element}: byte {}", error.valid_up_to()), problem)
    })?;
    let (mut is_first, mut row) = (true, Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = || line.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|word| !word.is_empty());
        if words().next().is_none() {
            continue;
        }
        let is_heading = is_first && words().all(|word| word.parse::<f64>().is_err());
        is_first = false;
        if is_heading {
            continue;
        }
        row.clear();
        for (column, word) in words().enumerate() {
            row.push(word.parse::<f64>().ok().filter(|x| accepts(column, *x)).ok_or_else(|| {
                let problem = format!("got `{}`, expected finite numbers between blanks or commas", quoted(word));
                Error::input(file, format!("{element}: line {}", number + 1), problem)
            })?);
        }
        take(number + 1, &row)?;
    }
    Ok(())
}

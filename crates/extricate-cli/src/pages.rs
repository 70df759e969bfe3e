//! Pages of answers, as `view` and `demo` write them.

use std::path::Path;

use anyhow::Context;
use extricate::{Checker, Config};
use extricate_view::{AnswerData, Detail, Inspector, Live, Page};
use rayon::prelude::*;

use crate::commands::query::asker::Timed;
use crate::progress::busy;

/// Queries from which on slices have fewer cells.
const MANY_QUERIES: usize = 40;
/// Cells to each side of their slices.
const FEW_CELLS: usize = 64;

/// What a page says of itself, and what makes it live.
pub struct About<'a> {
    /// Its heading.
    pub title: &'a str,
    /// With which command the numbers are those of the program.
    pub command: &'a str,
    /// The library for the page.
    pub live: Option<&'a Live>,
}

/// The page of some answers; the exact checker is asked on all cores what else is shown of them.
pub fn html(checker: &Checker, answers: Vec<(Config, Timed)>, about: &About) -> anyhow::Result<String> {
    let cells = if answers.len() > MANY_QUERIES { FEW_CELLS } else { Detail::default().slice_cells };
    let inspector = Inspector::new(checker, Detail { slice_cells: cells });
    let shown: Vec<AnswerData> = busy("drawing the page", || {
        let inspect = |inspector: &mut Inspector, (q, (answer, seconds)): (Config, Timed)| {
            inspector.answer_data(&q, answer, (seconds > 0.0).then_some(seconds))
        };
        answers.into_par_iter().map_init(|| inspector.another(), inspect).collect()
    });
    let made = format!("extricate {}; numbers as in {} --json", env!("CARGO_PKG_VERSION"), about.command);
    let page = Page { title: about.title, made: &made, answers: &shown, live: about.live };
    page.html(checker.scene()).context("cannot write the page")
}

/// What a file is called on a page.
pub fn name_of(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

//! Pages of answers and of what is played back, as `view` and `demo` write them.

use std::path::Path;

use anyhow::Context;
use extricate::{Config, Solver};
use extricate_view::{AnswerData, Detail, GraspData, Inspector, Live, Page};
use rayon::prelude::*;

use crate::commands::query::Timed;
use crate::progress::busy;

/// Queries from which on slices have fewer cells.
const MANY_QUERIES: usize = 40;
/// Cells to each side of their slices.
const FEW_CELLS: usize = 64;

/// What a page says of itself, and what makes it live.
pub struct About<'a> {
    /// Its heading.
    pub title: &'a str,
    /// What has the same numbers: a command, or a file.
    pub source: &'a str,
    /// Whether the answers are frames of a motion.
    pub is_stream: bool,
    /// The library for the page.
    pub live: Option<&'a Live>,
}

/// What a page shows at a time.
pub enum Shown {
    /// A query and its answer.
    Answer(Config, Timed),
    /// The first waypoint of a path, and the others.
    Path(Config, Vec<Config>),
    /// A query, and the grasp that was released from it.
    Grasp(Config, GraspData),
}

/// The page; the exact checker is asked on all cores what else is shown.
///
/// # Errors
/// Where a grasp is of another hand, or the page cannot be written.
pub fn html(solver: &Solver, shown: Vec<Shown>, about: &About) -> anyhow::Result<String> {
    let cells = if shown.len() > MANY_QUERIES { FEW_CELLS } else { Detail::default().slice_cells };
    let inspector = || Inspector::new(solver, Detail { slice_cells: cells });
    let shown: Result<Vec<AnswerData>, String> = busy("drawing the page", || {
        let inspect = |inspector: &mut Inspector, shown: Shown| match shown {
            Shown::Answer(q, (answer, seconds)) => {
                Ok(inspector.answer_data(&q, answer, (seconds > 0.0).then_some(seconds)))
            }
            Shown::Path(first, rest) => Ok(inspector.path_data(&first, &rest)),
            Shown::Grasp(q, grasp) => inspector.grasp_data(&q, grasp),
        };
        shown.into_par_iter().map_init(inspector, inspect).collect()
    });
    let shown = shown.map_err(anyhow::Error::msg)?;
    let made = format!("extricate {}; numbers as in {}", env!("CARGO_PKG_VERSION"), about.source);
    let page = Page { title: about.title, made: &made, answers: &shown, is_stream: about.is_stream, live: about.live };
    page.html(solver.scene()).context("cannot write the page")
}

/// What a file is called on a page.
pub fn name_of(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

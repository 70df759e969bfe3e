//! Pages of answers, paths and grasps, as `view` and `demo` write them.

use std::path::Path;

use anyhow::Context;
use extricate::files::load_visuals;
use extricate::geometry::Body;
use extricate::parts::Visual;
use extricate::{Config, LoadOptions, Solver};
use extricate_view::{AnswerData, Detail, GraspData, Inspector, Live, Page};
use rayon::prelude::*;

use crate::commands::query::Timed;
use crate::progress::busy;

/// Number of queries above which slices have fewer cells.
const MANY_QUERIES: usize = 40;
/// Cells along each side of their slices.
const COARSE_CELLS: usize = 64;

/// Labels of a page, and the library that makes it live.
pub struct About<'a> {
    pub title: &'a str,
    /// The command or file that gives the same numbers.
    pub source: &'a str,
    /// Whether the answers are frames of a motion.
    pub is_stream: bool,
    /// How links look, or why that is not shown.
    pub visuals: Result<Vec<Visual>, String>,
    /// The library for a live page.
    pub live: Option<&'a Live>,
}

/// One entry of a page.
pub enum Shown {
    /// A query and its answer.
    Answer(Config, Timed),
    /// The first waypoint of a path, and the others.
    Path(Config, Vec<Config>),
    /// A query, the grasp that was released from it, and its object if that is no obstacle.
    Grasp(Config, GraspData, Option<Body>),
}

/// Renders the page. The exact checker computes the additional data on all cores.
///
/// # Errors
/// Fails if a grasp belongs to another hand, or if the page cannot be written.
pub fn html(solver: &Solver, shown: Vec<Shown>, about: &About) -> anyhow::Result<String> {
    let cells = if shown.len() > MANY_QUERIES { COARSE_CELLS } else { Detail::default().slice_cells };
    // The plot of a motion shows its frames, not the way from a query to its exit.
    let inspector = || Inspector::new(solver, Detail { slice_cells: cells, distances: !about.is_stream });
    let shown: Result<Vec<AnswerData>, String> = busy("drawing the page", || {
        let inspect = |inspector: &mut Inspector, shown: Shown| match shown {
            Shown::Answer(q, (answer, seconds)) => {
                Ok(inspector.answer_data(&q, answer, (seconds > 0.0).then_some(seconds)))
            }
            Shown::Path(first, rest) => Ok(inspector.path_data(&first, &rest)),
            Shown::Grasp(q, grasp, None) => inspector.grasp_data(&q, grasp),
            Shown::Grasp(q, grasp, Some(object)) => inspector.grasp_of_object_data(&q, grasp, object),
        };
        shown.into_par_iter().map_init(inspector, inspect).collect()
    });
    let shown = shown.map_err(anyhow::Error::msg)?;
    let mut made = format!("extricate {}; numbers as in {}", env!("CARGO_PKG_VERSION"), about.source);
    if let Err(why) = &about.visuals {
        made += &format!("; without visual meshes: {why}");
    }
    let visuals = about.visuals.as_deref().unwrap_or_default();
    let &About { title, is_stream, live, .. } = about;
    let page = Page { title, made: &made, answers: &shown, is_stream, visuals, live };
    page.html(solver).context("cannot write the page")
}

/// Reads how the links of a scene file or URDF look. A page is written without that too, so a fault
/// is a text.
pub fn visuals(file: &Path, options: &LoadOptions) -> Result<Vec<Visual>, String> {
    load_visuals(file, options).map_err(|error| error.to_string())
}

/// Name of a file as pages show it.
pub fn name_of(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

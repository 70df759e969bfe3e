//! Pages of answers: what `show` writes and opens.

use std::ops::ControlFlow;
use std::path::PathBuf;

use extricate::{Answer, Config, Effort, Label, QueryOptions, Termination};
use extricate_view::{Detail, Inspector, Live, Page};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Source;
use super::options::{Asked, QUERY, Weighted};
use crate::long_call;
use crate::rows::arrays::{bad_row, configs};
use crate::scene::sampling::sample;

/// Configurations that are drawn where none are given.
const DRAWN: usize = 5;
/// Exits of each query where nothing is said.
const USUAL_EXITS: usize = 3;
/// Most configurations of a page: it holds them all.
const MOST_QUERIES: usize = 1000;
/// Where the half of pages that is Python is.
const HOME: &str = "extricate._page";

/// How a page is shown.
pub struct Shown {
    /// Where it is written; a temporary file where nothing is said.
    pub path: Option<PathBuf>,
    /// Whether a browser is opened; `None` leaves it to whether this is a notebook.
    pub open: Option<bool>,
    /// Whether joints can be dragged in it.
    pub live: bool,
}

/// Writes the page of some configurations, random ones where none are given, and opens it.
pub fn show<'py>(
    py: Python<'py>,
    source: Source,
    queries: Option<&Bound<'py, PyAny>>,
    given: Option<&Bound<'py, PyDict>>,
    (shown, weighted): (Shown, &Weighted),
) -> PyResult<Bound<'py, PyAny>> {
    let scene = source.scene();
    let mut asked = Asked::read(given, scene, QUERY)?;
    let says_exits = given
        .is_some_and(|given| given.contains("exits").unwrap_or(false) || given.contains("options").unwrap_or(false));
    let finds_several = matches!(asked.options.effort, Effort::Quick | Effort::Refined | Effort::Exhaustive)
        && asked.options.gap.is_none();
    if !says_exits && finds_several && asked.options.toward.is_none() {
        asked.options.exits = USUAL_EXITS;
    }
    let other = asked.other_weights(py, source, weighted)?;
    let source = other.as_deref().map_or(source, Source::World);
    let configs = match queries {
        Some(queries) => read(queries, source, &asked)?,
        None => drawn(py, source)?,
    };
    if configs.len() > MOST_QUERIES {
        let found = configs.len();
        return Err(PyValueError::new_err(format!(
            "Q: got {found} configurations, expected at most {MOST_QUERIES}: a page holds them all"
        )));
    }
    let live = live(source, shown.live)?;
    let pool = long_call::pool(1)?;
    let html = long_call::run(py, silent, |line| {
        let termination = Termination { stop: Some(line.stop()), ..asked.options.termination.clone() };
        let options = QueryOptions { termination, ..asked.options };
        pool.install(|| html(source, &configs, &options, live.as_ref()))
    })?;
    let html = html.map_err(PyRuntimeError::new_err)?;
    py.import(HOME)?.call_method1("shown", (html, shown.path, shown.open))
}

/// There is no news of a page that is made.
fn silent(_: Python<'_>, (): ()) -> PyResult<()> {
    Ok(())
}

fn read(queries: &Bound<'_, PyAny>, source: Source, asked: &Asked) -> PyResult<Vec<Config>> {
    let scene = source.scene();
    let rows = configs("Q", queries, &scene.space)?;
    let row = |(at, values): (usize, &[f64])| {
        asked.config_of(values, scene).map_err(|error| bad_row("Q", at, rows.single, error))
    };
    rows.values().chunks_exact(scene.space.nq()).enumerate().map(row).collect()
}

fn drawn(py: Python<'_>, source: Source) -> PyResult<Vec<Config>> {
    let (checker, space) = (source.view().checker(), &source.scene().space);
    let pool = long_call::pool(1)?;
    let found = long_call::run(py, silent, |line| {
        pool.install(|| sample(checker, DRAWN, 0, Some(Label::Colliding), Vec::new(), || line.stopped()))
    })?;
    let rows = found.map_err(PyRuntimeError::new_err)?.unwrap_or_default();
    rows.chunks_exact(space.nq()).map(|q| space.config(q).map_err(crate::error::exception)).collect()
}

/// The library for the page, where it is asked for.
fn live(source: Source, wanted: bool) -> PyResult<Option<Live>> {
    if !wanted {
        return Ok(None);
    }
    let missing = "live: got True, expected False: this package was built without the library as WebAssembly";
    let program = Live::built_in().ok_or_else(|| PyValueError::new_err(missing))?;
    let live = match source {
        Source::Model(model) => Ok(Live::of_model(program, model)),
        Source::Changed(model, changed) => Live::of_model_in(program, model, changed.scene()),
        Source::World(world) => Live::of_scene(program, world.scene()),
    };
    live.map(Some).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

fn html(source: Source, configs: &[Config], options: &QueryOptions, live: Option<&Live>) -> Result<String, String> {
    let mut answers: Vec<(Option<Answer>, f64)> = Vec::with_capacity(configs.len());
    source.view().query_batch(configs.iter().cloned(), options, 1, &mut |answered| {
        answers.push((answered.answer, answered.seconds));
        ControlFlow::Continue(())
    });
    let mut inspector = Inspector::new(source.view().checker(), Detail::default());
    let inspect =
        |(q, (answer, seconds)): (&Config, (Option<Answer>, f64))| inspector.answer_data(q, answer, Some(seconds));
    let shown: Vec<_> = configs.iter().zip(answers).map(inspect).collect();
    let made = format!("extricate {}, from Python; effort {}", env!("CARGO_PKG_VERSION"), options.effort.name());
    let page = Page { title: "extricate", made: &made, answers: &shown, is_stream: false, live };
    page.html(source.scene()).map_err(|error| error.to_string())
}

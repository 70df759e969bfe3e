//! Makes the pages of answers that `show` writes and opens.

use std::ops::ControlFlow;
use std::path::PathBuf;

use extricate::{Answer, Config, Effort, Label, Sampler};
use extricate_view::{Detail, Inspector, Live, Page};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::options::{Call, CallOptions};
use crate::error::exception;
use crate::long_call;
use crate::rows::arrays::{bad_row, configs};
use crate::solver::handle::Handle;

/// Random configurations of a page if the caller gives none.
const RANDOM_QUERIES: usize = 5;
/// Exits of each query if the caller does not set them.
const DEFAULT_EXITS: usize = 3;
/// Most configurations of a page, which holds them all.
const MAX_QUERIES: usize = 1000;
/// Python module that writes pages and opens them.
const PYTHON_MODULE: &str = "extricate._page";

pub struct Shown {
    /// The file to write; a temporary one if `None`.
    pub path: Option<PathBuf>,
    /// Whether a browser opens the page; `None` opens it outside notebooks.
    pub open: Option<bool>,
    /// Whether users can drag joints in the page.
    pub live: bool,
}

/// Writes the page of some configurations, random ones if none are given, and opens it.
pub fn show<'py>(
    py: Python<'py>,
    handle: &Handle,
    queries: Option<&Bound<'py, PyAny>>,
    given: Option<&Bound<'py, PyDict>>,
    shown: Shown,
) -> PyResult<Bound<'py, PyAny>> {
    let mut call = handle.call_options(py, given, Call::Query)?;
    let finds_several = matches!(call.options.effort, Effort::Quick | Effort::Refined | Effort::Exhaustive)
        && call.options.gap.is_none();
    if !call.says_exits && finds_several && call.options.toward.is_none() {
        call.options.exits = DEFAULT_EXITS;
    }
    let solver = handle.solver_for(py, &call)?;
    let configs = match queries {
        Some(queries) => read(queries, handle.scene(), &call)?,
        None => drawn(py, &solver)?,
    };
    if configs.len() > MAX_QUERIES {
        let found = configs.len();
        return Err(PyValueError::new_err(format!(
            "Q: got {found} configurations, expected at most {MAX_QUERIES}: a page holds them all"
        )));
    }
    let live = if shown.live { Some(live(&solver)?) } else { None };
    let pool = long_call::pool(1)?;
    let html = long_call::run(py, silent, |line| {
        let solver = call.stopped_by(&solver, line.stop());
        pool.install(|| html(&solver, &configs, call.options.effort, live.as_ref()))
    })?;
    let html = html.map_err(PyRuntimeError::new_err)?;
    py.import(PYTHON_MODULE)?.call_method1("shown", (html, shown.path, shown.open))
}

/// Ignores news, because making a page sends none.
fn silent(_: Python<'_>, (): ()) -> PyResult<()> {
    Ok(())
}

fn read(queries: &Bound<'_, PyAny>, scene: &extricate::Scene, call: &CallOptions) -> PyResult<Vec<Config>> {
    let rows = configs("Q", queries, scene.space())?;
    let row = |(at, values): (usize, &[f64])| {
        call.config_of(values, scene).map_err(|error| bad_row("Q", at, rows.single, error))
    };
    rows.values().chunks_exact(scene.space().nq()).enumerate().map(row).collect()
}

fn drawn(py: Python<'_>, solver: &extricate::Solver) -> PyResult<Vec<Config>> {
    let pool = long_call::pool(1)?;
    let rows = long_call::run(py, silent, |line| {
        let mut sampler = Sampler::new(solver, Some(Label::Colliding), 0);
        pool.install(|| sampler.draw(RANDOM_QUERIES, &mut |_, _| line.flow()))
    })?;
    let config = |q: Vec<f64>| solver.scene().config(&q).map_err(exception);
    rows.map_err(exception)?.into_iter().map(config).collect()
}

/// Returns the library as WebAssembly, for a live page.
fn live(solver: &extricate::Solver) -> PyResult<Live> {
    let missing = "live: got True, expected False: this package was built without the library as WebAssembly";
    let program = Live::built_in().ok_or_else(|| PyValueError::new_err(missing))?;
    Ok(Live::new(program, solver))
}

fn html(solver: &extricate::Solver, configs: &[Config], effort: Effort, live: Option<&Live>) -> Result<String, String> {
    let mut answers: Vec<(Option<Answer>, f64)> = Vec::with_capacity(configs.len());
    solver.batch_each(configs.iter().cloned(), 1, &mut |answered| {
        answers.push((answered.answer, answered.seconds));
        ControlFlow::Continue(())
    });
    let mut inspector = Inspector::new(solver, Detail::default());
    let inspect =
        |(q, (answer, seconds)): (&Config, (Option<Answer>, f64))| inspector.answer_data(q, answer, Some(seconds));
    let shown: Vec<_> = configs.iter().zip(answers).map(inspect).collect();
    let made = format!("extricate {}, from Python; effort {effort}", env!("CARGO_PKG_VERSION"));
    let page = Page { title: "extricate", made: &made, answers: &shown, is_stream: false, visuals: &[], live };
    page.html(solver).map_err(|error| error.to_string())
}

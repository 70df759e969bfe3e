//! Pages of answers: what `show` writes and opens.

use std::ops::ControlFlow;
use std::path::PathBuf;

use extricate::{Answer, Config, Effort, Label, Sampler};
use extricate_view::{Detail, Inspector, Live, Page};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::options::{Asked, Call};
use crate::error::exception;
use crate::long_call;
use crate::rows::arrays::{bad_row, configs};
use crate::solver::handle::Handle;

/// Configurations that are drawn if none are given.
const DRAWN: usize = 5;
/// Exits of each query if nothing is said.
const USUAL_EXITS: usize = 3;
/// Most configurations of a page: it holds them all.
const MOST_QUERIES: usize = 1000;
/// Where the half of pages that is Python is.
const HOME: &str = "extricate._page";

/// How a page is shown.
pub struct Shown {
    /// Where it is written; a temporary file if nothing is said.
    pub path: Option<PathBuf>,
    /// Whether a browser is opened; `None` leaves it to whether this is a notebook.
    pub open: Option<bool>,
    /// Whether joints can be dragged in it.
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
    let mut asked = handle.asked(py, given, Call::Query)?;
    let finds_several = matches!(asked.options.effort, Effort::Quick | Effort::Refined | Effort::Exhaustive)
        && asked.options.gap.is_none();
    if !asked.says_exits && finds_several && asked.options.toward.is_none() {
        asked.options.exits = USUAL_EXITS;
    }
    let solver = handle.solver_for(py, &asked)?;
    let configs = match queries {
        Some(queries) => read(queries, handle.scene(), &asked)?,
        None => drawn(py, &solver)?,
    };
    if configs.len() > MOST_QUERIES {
        let found = configs.len();
        return Err(PyValueError::new_err(format!(
            "Q: got {found} configurations, expected at most {MOST_QUERIES}: a page holds them all"
        )));
    }
    let live = if shown.live { Some(live(&solver)?) } else { None };
    let pool = long_call::pool(1)?;
    let html = long_call::run(py, silent, |line| {
        let solver = asked.stopped_by(&solver, line.stop());
        pool.install(|| html(&solver, &configs, asked.options.effort, live.as_ref()))
    })?;
    let html = html.map_err(PyRuntimeError::new_err)?;
    py.import(HOME)?.call_method1("shown", (html, shown.path, shown.open))
}

/// There is no news of a page that is made.
fn silent(_: Python<'_>, (): ()) -> PyResult<()> {
    Ok(())
}

fn read(queries: &Bound<'_, PyAny>, scene: &extricate::Scene, asked: &Asked) -> PyResult<Vec<Config>> {
    let rows = configs("Q", queries, scene.space())?;
    let row = |(at, values): (usize, &[f64])| {
        asked.config_of(values, scene).map_err(|error| bad_row("Q", at, rows.single, error))
    };
    rows.values().chunks_exact(scene.space().nq()).enumerate().map(row).collect()
}

fn drawn(py: Python<'_>, solver: &extricate::Solver) -> PyResult<Vec<Config>> {
    let pool = long_call::pool(1)?;
    let rows = long_call::run(py, silent, |line| {
        let mut sampler = Sampler::new(solver, Some(Label::Colliding), 0);
        pool.install(|| sampler.draw(DRAWN, &mut |_, _| line.flow()))
    })?;
    let config = |q: Vec<f64>| solver.scene().config(&q).map_err(exception);
    rows.map_err(exception)?.into_iter().map(config).collect()
}

/// The library for the page.
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
    let page = Page { title: "extricate", made: &made, answers: &shown, is_stream: false, live };
    page.html(solver.scene()).map_err(|error| error.to_string())
}

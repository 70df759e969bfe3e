//! The function `learn`, and what it tells on the way.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use extricate::model::EndedBy;
use extricate::{LearnOptions, LearnProgress, Statistics};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::error::{count, exception};
use crate::long_call;
use crate::model::Model;
use crate::scene::Scene;

/// Where a learning run stands.
#[pyclass(frozen, get_all, module = "extricate._extricate")]
pub struct Progress {
    /// What is being done: "exploring", "training", "tracing the boundary", "solving", "measuring".
    stage: &'static str,
    /// Share of the budget spent, 0 to 1.
    fraction: f64,
    /// Labels (exact checks) spent.
    labels: usize,
    /// Boundary samples found.
    boundary_samples: usize,
    /// Held-out balanced accuracy of the last classifier; None before there is one.
    accuracy: Option<f64>,
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        let Self { stage, fraction, labels, boundary_samples, accuracy } = self;
        let accuracy = accuracy.map_or("None".into(), |accuracy| accuracy.to_string());
        format!(
            "Progress(stage={stage:?}, fraction={fraction}, labels={labels}, boundary_samples={boundary_samples}, accuracy={accuracy})"
        )
    }
}

impl From<LearnProgress> for Progress {
    fn from(state: LearnProgress) -> Self {
        let LearnProgress { stage, fraction, labels, boundary_samples, accuracy, .. } = state;
        Self { stage, fraction, labels, boundary_samples, accuracy }
    }
}

/// As `extricate.learn`; `progress` is a callable or None.
#[pyfunction]
#[pyo3(signature = (scene, *, labels = None, seconds = None, seed = 0, threads = 0, progress = None))]
pub fn learn(
    py: Python<'_>,
    scene: &Scene,
    labels: Option<i64>,
    seconds: Option<f64>,
    seed: u64,
    threads: i64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let default = LearnOptions::default();
    if let Some(bad) = seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
        return Err(PyValueError::new_err(format!("seconds: got {bad}, expected more than 0")));
    }
    let options = LearnOptions {
        // Who counts labels wants a model that another machine learns too; a silent time limit would break that.
        seconds: if labels.is_some() { seconds } else { seconds.or(default.seconds) },
        labels: labels.map_or(Ok(default.labels), |labels| count("labels", labels, 1))?,
        seed,
        threads: count("threads", threads, 0)?,
        ..default
    };
    let enough = AtomicBool::new(false);
    let hear = |py: Python<'_>, state: LearnProgress| -> PyResult<()> {
        if let Some(progress) = &progress {
            let said = progress.call1(py, (Progress::from(state),))?;
            if said.extract::<bool>(py).is_ok_and(|go_on| !go_on) {
                enough.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    };
    let copy = (**scene.inner()).clone();
    let model = long_call::run(py, hear, |line| {
        extricate::Model::learn(copy, &options, &mut |state| {
            line.tell(state.clone());
            let stop = line.stopped() || enough.load(Ordering::Relaxed);
            if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    })?;
    Ok(Model::of(model.map_err(exception)?))
}

/// As a dict, for `Model.statistics`.
pub fn statistics<'py>(py: Python<'py>, statistics: &Statistics) -> PyResult<Bound<'py, PyDict>> {
    let ended_by = match statistics.ended_by {
        EndedBy::Labels => "labels",
        EndedBy::Seconds => "seconds",
        EndedBy::Interruption => "interruption",
        EndedBy::Memory => "memory",
        EndedBy::Quality => "quality",
    };
    let all = PyDict::new(py);
    all.set_item("labels", statistics.labels)?;
    all.set_item("seed", statistics.seed)?;
    all.set_item("boundary_samples", statistics.boundary_samples)?;
    all.set_item("exits", statistics.exits)?;
    all.set_item("support_vectors", statistics.support_vectors)?;
    all.set_item("colliding_share", statistics.colliding_share)?;
    all.set_item("accuracy_free", statistics.accuracy_free)?;
    all.set_item("accuracy_free_interval", statistics.accuracy_free_interval)?;
    all.set_item("accuracy_colliding", statistics.accuracy_colliding)?;
    all.set_item("accuracy_colliding_interval", statistics.accuracy_colliding_interval)?;
    all.set_item("boundary_gap", statistics.boundary_gap)?;
    let density = statistics.density.map(|density| {
        [
            ("spacing_median", density.spacing_median),
            ("spacing_p95", density.spacing_p95),
            ("reach_median", density.reach_median),
            ("reach_p95", density.reach_p95),
        ]
        .into_py_dict(py)
    });
    all.set_item("density", density.transpose()?)?;
    let excess = statistics.excess.map(|excess| -> PyResult<_> {
        let of =
            [("median", excess.median), ("p95", excess.p95), ("within_5pct", excess.within_5pct)].into_py_dict(py)?;
        of.set_item("queries", excess.queries)?;
        of.set_item("within_5pct_interval", excess.within_5pct_interval)?;
        Ok(of)
    });
    all.set_item("excess", excess.transpose()?)?;
    all.set_item("measuring_checks", statistics.measuring_checks)?;
    all.set_item("ended_by", ended_by)?;
    Ok(all)
}

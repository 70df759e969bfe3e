//! `Model.statistics`: how a model was learned, as a dict.

use extricate::Statistics;
use extricate::internals::model::EndedBy;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// As a dict, for `Model.statistics`.
pub fn statistics<'py>(py: Python<'py>, statistics: &Statistics) -> PyResult<Bound<'py, PyDict>> {
    let ended_by = match statistics.ended_by {
        EndedBy::Labels => "labels",
        EndedBy::Seconds => "seconds",
        EndedBy::Interruption => "interruption",
    };
    let all = PyDict::new(py);
    all.set_item("labels", statistics.labels)?;
    all.set_item("seed", statistics.seed)?;
    all.set_item("boundary_samples", statistics.boundary_samples)?;
    all.set_item("solved_samples", statistics.solved_samples)?;
    all.set_item("stand_ins", statistics.stand_ins)?;
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
    let gap = statistics.gap.map(|gap| -> PyResult<_> {
        let of = [("median", gap.median), ("p95", gap.p95)].into_py_dict(py)?;
        of.set_item("queries", gap.queries)?;
        Ok(of)
    });
    all.set_item("gap", gap.transpose()?)?;
    all.set_item("measuring_checks", statistics.measuring_checks)?;
    all.set_item("ended_by", ended_by)?;
    Ok(all)
}

//! Implements `Scene.check_segments`, which proves whole segments free.

use extricate::{SegmentOptions, SegmentOutcome};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use super::POLL_ROWS;
use super::arrays::{Configs, bad_row, configs};
use crate::long_call;
use crate::scene::Scene;

/// Checks the segments from the rows of `from` to those of `to`; returns a structured array.
///
/// # Errors
/// `ValueError` that says what was expected; the exceptions of [`long_call::run`].
pub fn check<'py>(
    scene: &Scene,
    from: &Bound<'py, PyAny>,
    to: &Bound<'py, PyAny>,
    resolution: f64,
    threads: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let py = from.py();
    if !(resolution > 0.0 && resolution.is_finite()) {
        return Err(PyValueError::new_err(format!("resolution: got {resolution}, expected more than 0 m")));
    }
    let space = scene.inner().space();
    let (from, to) = (configs("A", from, space)?, configs("B", to, space)?);
    if from.rows != to.rows {
        let (a, b) = (from.rows, to.rows);
        return Err(PyValueError::new_err(format!("B: got {b} configurations, expected as many as in A, {a}")));
    }
    let (from, to) = (checked(py, "A", &from, scene.inner())?, checked(py, "B", &to, scene.inner())?);
    let options = SegmentOptions::default().resolution(resolution);
    let (solver, pool, nq) = (scene.handle().for_checks(py)?, long_call::pool(threads)?, space.nq());
    // Placeholder for segments that a stopped call skips; such a call raises.
    let unseen = SegmentOutcome::Undecided { free_until: 0.0, near_at: 0.0, pair: extricate::PairId::new(0) };
    let outcomes: Vec<SegmentOutcome> = long_call::run(
        py,
        |_, ()| Ok(()),
        |line| {
            let one = |(from, to): (&[f64], &[f64])| {
                if line.stopped() { unseen } else { solver.check_segment(from, to, &options) }
            };
            let ways = from.par_chunks_exact(nq).zip(to.par_chunks_exact(nq));
            pool.install(|| ways.map(one).collect())
        },
    )?;
    let rows: Vec<Row> = outcomes.into_iter().map(Row::of).collect();
    let fields = [("free", "?"), ("contact", "?"), ("free_until", "f8"), ("at", "f8"), ("pair", "i8")];
    let answers = py.import("numpy")?.call_method1("zeros", (rows.len(), fields.to_vec()))?;
    answers.set_item("free", PyArray1::from_iter(py, rows.iter().map(|row| row.free)))?;
    answers.set_item("contact", PyArray1::from_iter(py, rows.iter().map(|row| row.contact)))?;
    answers.set_item("free_until", PyArray1::from_iter(py, rows.iter().map(|row| row.free_until)))?;
    answers.set_item("at", PyArray1::from_iter(py, rows.iter().map(|row| row.at)))?;
    answers
        .set_item("pair", PyArray1::from_iter(py, rows.iter().map(|row| row.pair.map_or(-1, |pair| pair as i64))))?;
    Ok(answers)
}

struct Row {
    free: bool,
    contact: bool,
    free_until: f64,
    at: f64,
    pair: Option<usize>,
}

impl Row {
    fn of(outcome: SegmentOutcome) -> Self {
        let (contact, free_until, at, pair) = match outcome {
            SegmentOutcome::Free => (false, 1.0, f64::NAN, None),
            SegmentOutcome::Contact { free_until, colliding_at, pair } => (true, free_until, colliding_at, Some(pair)),
            SegmentOutcome::Undecided { free_until, near_at, pair } => (false, free_until, near_at, Some(pair)),
            // An outcome that is not known here proves nothing.
            _ => (false, 0.0, 0.0, None),
        };
        let free = outcome == SegmentOutcome::Free;
        Self { free, contact, free_until, at, pair: pair.map(extricate::PairId::index) }
    }
}

/// Checks the rows and returns them normalised: angles wrapped, quaternions of unit length.
fn checked(py: Python<'_>, name: &str, rows: &Configs<'_>, scene: &extricate::Scene) -> PyResult<Vec<f64>> {
    let mut all = Vec::with_capacity(rows.values().len());
    for (row, q) in rows.values().chunks_exact(scene.space().nq()).enumerate() {
        if row % POLL_ROWS == 0 {
            py.check_signals()?;
        }
        all.extend_from_slice(&scene.config(q).map_err(|error| bad_row(name, row, rows.single, error))?);
    }
    Ok(all)
}

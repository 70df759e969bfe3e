//! The handle through which the calls of `Scene`, `Model` and `Solver` reach the library.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use extricate::Hand;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Advice, exception};
use crate::long_call;
use crate::queries::options::{Call, CallOptions, Weights};

/// A solver of the library, and data that its calls keep for later ones. Clones share all of it.
#[derive(Clone)]
pub struct Handle {
    solver: extricate::Solver,
    /// Keywords that apply to calls which do not set them.
    defaults: Option<Arc<Py<PyDict>>>,
    kept: Arc<Kept>,
}

#[derive(Default)]
struct Kept {
    /// The last weights that a call gave, and the solver with them.
    weighted: Mutex<Option<(Weights, extricate::Solver)>>,
    /// The solver with the weights of a hand.
    of_hand: OnceLock<extricate::Solver>,
    advice: Advice,
}

impl Handle {
    /// Makes a handle on a solver, whose calls have the defaults of the package.
    pub fn new(solver: extricate::Solver) -> Self {
        Self { solver, defaults: None, kept: Arc::default() }
    }

    /// Sets the keywords that apply to calls which do not set them.
    pub fn with_defaults(self, defaults: Option<Arc<Py<PyDict>>>) -> Self {
        Self { defaults, ..self }
    }

    pub fn defaults(&self) -> Option<&Arc<Py<PyDict>>> {
        self.defaults.as_ref()
    }

    /// The solver, which may not be prepared yet, see [`Handle::ready`].
    pub fn solver(&self) -> &extricate::Solver {
        &self.solver
    }

    pub fn scene(&self) -> &Arc<extricate::Scene> {
        self.solver.scene()
    }

    /// Prepares the solver, and returns it.
    ///
    /// # Errors
    /// As [`long_call::aside`].
    pub fn ready(&self, py: Python<'_>) -> PyResult<&extricate::Solver> {
        prepare(py, &self.solver)?;
        Ok(&self.solver)
    }

    /// Reads the keywords of a call, completed by the defaults.
    ///
    /// # Errors
    /// As [`CallOptions::read`].
    pub fn call_options(&self, py: Python<'_>, given: Option<&Bound<'_, PyDict>>, call: Call) -> PyResult<CallOptions> {
        let defaults = self.defaults.as_ref().map(|defaults| defaults.bind(py));
        CallOptions::read(given, defaults, self.scene(), call)
    }

    /// Returns the solver with these weights of joints, prepared.
    ///
    /// # Errors
    /// `ValueError` for weights that make no sense; as [`long_call::aside`].
    pub fn with_weights(&self, py: Python<'_>, weights: &Weights) -> PyResult<extricate::Solver> {
        let solver = if weights.is_empty() { self.solver.clone() } else { self.weighted(weights)? };
        prepare(py, &solver)?;
        Ok(solver)
    }

    /// Returns the solver without a model and with the weights of a hand. It is kept: single calls
    /// would otherwise measure and prepare the hand each time.
    pub fn for_hands(&self, py: Python<'_>) -> extricate::Solver {
        let weighted = || {
            let solver = self.solver.without_model();
            Hand::weighted(self.scene()).and_then(|scene| solver.with_scene(scene).ok()).unwrap_or(solver)
        };
        py.detach(|| self.kept.of_hand.get_or_init(weighted).clone())
    }

    /// Checks that weights of joints make sense.
    ///
    /// # Errors
    /// `ValueError` that names the joint and what was expected.
    pub fn check_weights(&self, weights: &Weights) -> PyResult<()> {
        if weights.is_empty() { Ok(()) } else { self.weighted(weights).map(drop) }
    }

    /// Returns the solver with its checker prepared, which is all that checks need.
    ///
    /// # Errors
    /// As [`long_call::aside`].
    pub fn for_checks(&self, py: Python<'_>) -> PyResult<&extricate::Solver> {
        if !self.solver.has_checker() {
            let solver = self.solver.clone();
            long_call::aside(py, move || {
                solver.checker();
            })?;
        }
        Ok(&self.solver)
    }

    /// Returns the solver with the options and weights of a call, prepared.
    ///
    /// # Errors
    /// `ValueError` for options and weights that make no sense; as [`long_call::aside`].
    pub fn solver_for(&self, py: Python<'_>, call: &CallOptions) -> PyResult<extricate::Solver> {
        self.with_weights(py, &call.weights)?.options(call.options.clone()).map_err(exception)
    }

    /// Raises a `UserWarning` after a call that found nothing free, see [`Advice::warn`].
    ///
    /// # Errors
    /// As [`Advice::warn`].
    pub fn advise(&self, py: Python<'_>) -> PyResult<()> {
        self.kept.advice.warn(py, &self.solver)
    }

    /// Keeps the solver of the last weights: single calls with the same ones would otherwise
    /// prepare the scene each time.
    fn weighted(&self, weights: &Weights) -> PyResult<extricate::Solver> {
        let mut last = self.kept.weighted.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, solver)) = last.as_ref().filter(|(known, _)| known == weights) {
            return Ok(solver.clone());
        }
        let named = weights.iter().map(|(name, both)| (name.as_str(), *both));
        let solver = self.solver.weighted(named).map_err(exception)?;
        *last = Some((weights.clone(), solver.clone()));
        Ok(solver)
    }
}

/// Prepares a solver without the interpreter lock; after Ctrl-C, the preparation still goes on.
///
/// # Errors
/// As [`long_call::aside`].
pub fn prepare(py: Python<'_>, solver: &extricate::Solver) -> PyResult<()> {
    if solver.is_prepared() {
        return Ok(());
    }
    let solver = solver.clone();
    long_call::aside(py, move || solver.prepare())
}

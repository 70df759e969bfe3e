//! What is asked of a query: the keywords of `query`, `query_batch` and `stream`, read and checked
//! in one place.

use std::sync::{Arc, Mutex};

use extricate::internals::query::options::{MAX_EXITS, MAX_STARTS};
use extricate::internals::scene::units;
use extricate::{Config, Effort, QueryOptions, Scene, Termination, Toward, World};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyMapping, PyType};

use super::Source;
use super::answer::effort_name;
use crate::entries::lists::Names;
use crate::error::{count, exception, warn};
use crate::long_call;
use crate::rows::arrays::{bad_row, floats, one_config};

/// What each kind of call may be given beside [`COMMON`].
pub const QUERY: &[&str] = &["exits", "toward", "toward_share"];
/// The same of many queries.
pub const BATCH: &[&str] = &["exits", "toward", "toward_share", "threads", "errors"];
/// The same of a stream.
pub const STREAM: &[&str] = &["hysteresis", "starts_per_frame", "continuous"];

/// The keyword that may hold values of most others.
const OPTIONS: &str = "options";
static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// What every call may be given.
const COMMON: [&str; 13] = [
    "effort",
    "gap",
    "starts",
    "max_checks",
    "max_seconds",
    "segment",
    "contacts",
    "clearance",
    "locked",
    "free",
    "weights",
    "free_radius",
    "limits",
];

/// Everything that was given, checked.
pub struct Asked {
    pub options: QueryOptions,
    /// Whether configurations beyond the limits are refused.
    pub refuses: bool,
    /// Whether a row that is no configuration is answered as such.
    pub masks: bool,
    pub threads: i64,
    pub hysteresis: f64,
    pub starts_per_frame: i64,
    pub continuous: bool,
    /// By joint, of translations and rotation; empty where none were given.
    pub weights: Vec<(String, [f64; 2])>,
}

impl Asked {
    /// Reads the keywords of a call.
    ///
    /// # Errors
    /// `TypeError` for keywords that the call does not take, and values of a wrong kind;
    /// `ValueError` that says what was expected.
    pub fn read(given: Option<&Bound<'_, PyDict>>, scene: &Scene, call: &[&str]) -> PyResult<Self> {
        let given = Given { given, call };
        given.check_names()?;
        let mut options = given.effort_and_budget()?;
        options.segment = given.or("segment", false)?;
        options.contacts = given.or("contacts", false)?;
        options.free_radius = given.or("free_radius", false)?;
        options.clearance = given.get("clearance")?;
        if let Some(bad) = options.clearance.filter(|length| !(0.0..=1e9).contains(length)) {
            return Err(PyValueError::new_err(format!("clearance: got {bad}, expected 0 to 1e9 [m]")));
        }
        options.locked = given.locked(scene)?;
        options.toward = given.toward(scene)?;
        if options.toward.is_some() && (options.gap.is_some() || options.effort == Effort::Proved) {
            let message = "toward: got a goal with a gap to prove, expected None: the search stops at the nearest";
            return Err(PyValueError::new_err(message));
        }
        Ok(Self {
            options,
            refuses: given.either("limits", ["forgive", "refuse"])?,
            masks: given.either("errors", ["raise", "mask"])?,
            threads: given.or("threads", 0)?,
            hysteresis: given.or("hysteresis", 0.0)?,
            starts_per_frame: given.or("starts_per_frame", 2)?,
            continuous: given.or("continuous", false)?,
            weights: given.weights()?,
        })
    }

    /// The scene with the weights, where some were given.
    ///
    /// # Errors
    /// As [`Weighted::of`].
    pub fn other_weights(&self, py: Python<'_>, source: Source, weighted: &Weighted) -> PyResult<Option<Arc<World>>> {
        let of = || py.detach(|| weighted.of(source.world(), &self.weights));
        if self.weights.is_empty() { Ok(None) } else { of().map(Some) }
    }

    /// The configuration of one query.
    ///
    /// # Errors
    /// `ValueError` for a wrong shape, values that are not finite, or beyond a limit where that is
    /// refused.
    pub fn config(&self, q: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<Config> {
        let values = one_config("q", q, &scene.space)?;
        if let Some(hint) = units::degrees_hint(scene, values.values()).filter(|_| !self.refuses) {
            warn(q.py(), &format!("q: {hint}"))?;
        }
        self.config_of(values.values(), scene).map_err(|error| bad_row("q", 0, true, error))
    }

    /// The same of numbers.
    pub fn config_of(&self, values: &[f64], scene: &Scene) -> extricate::Result<Config> {
        if self.refuses { units::config(scene, values) } else { scene.space.config_anywhere(values) }
    }
}

struct Given<'a, 'py> {
    given: Option<&'a Bound<'py, PyDict>>,
    call: &'a [&'a str],
}

impl<'py> Given<'_, 'py> {
    fn check_names(&self) -> PyResult<()> {
        for name in self.given.iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if name != OPTIONS && !COMMON.contains(&name.as_str()) && !self.call.contains(&name.as_str()) {
                return Err(PyTypeError::new_err(format!("got an unexpected keyword argument '{name}'")));
            }
        }
        self.check_options()
    }

    /// `options=`, where it was given.
    fn options(&self) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.given.map_or(Ok(None), |given| given.get_item(OPTIONS))?;
        Ok(value.filter(|value| !value.is_none()))
    }

    /// Whether it is an object of its class, and holds nothing that the call does not take.
    fn check_options(&self) -> PyResult<()> {
        let Some(options) = self.options()? else { return Ok(()) };
        let class = CLASS.import(options.py(), "extricate._options", "QueryOptions")?;
        if !options.is_instance(class)? {
            let found = options.get_type().name()?;
            return Err(PyTypeError::new_err(format!("options: got {found}, expected extricate.QueryOptions")));
        }
        let is_set = |name: &str| -> PyResult<bool> { Ok(!options.getattr(name)?.eq(class.getattr(name)?)?) };
        for name in QUERY.iter().filter(|name| !self.call.contains(name)) {
            if is_set(name)? {
                let message = format!("options: got {name}, expected none: a stream answers with the nearest exit");
                return Err(PyValueError::new_err(message));
            }
        }
        Ok(())
    }

    /// A value that was given and is not None: as a keyword, or else among the options.
    fn value(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.given.map_or(Ok(None), |given| given.get_item(name))?;
        let value = match (value, self.options()?) {
            (None, Some(options)) if options.hasattr(name)? => Some(options.getattr(name)?),
            (value, _) => value,
        };
        Ok(value.filter(|value| !value.is_none()))
    }

    fn get<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str) -> PyResult<Option<T>> {
        let named = |value: Bound<'py, PyAny>| {
            let wrong = |error: PyErr| {
                let message = format!("argument '{name}': {}", error.value(value.py()));
                match error.is_instance_of::<PyTypeError>(value.py()) {
                    true => PyTypeError::new_err(message),
                    false => PyValueError::new_err(message),
                }
            };
            value.extract::<T>().map_err(|error| wrong(error.into()))
        };
        self.value(name)?.map(named).transpose()
    }

    fn or<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str, default: T) -> PyResult<T> {
        Ok(self.get(name)?.unwrap_or(default))
    }

    /// Whether it is the second of two words; the first is the default.
    fn either(&self, name: &str, words: [&str; 2]) -> PyResult<bool> {
        match self.get::<String>(name)? {
            None => Ok(false),
            Some(word) if words.contains(&word.as_str()) => Ok(word == words[1]),
            Some(word) => {
                let [a, b] = words;
                Err(PyValueError::new_err(format!("{name}: got \"{word}\", expected \"{a}\" or \"{b}\"")))
            }
        }
    }

    fn effort_and_budget(&self) -> PyResult<QueryOptions> {
        let effort: String = self.or("effort", "refined".into())?;
        let found = Effort::ALL.into_iter().find(|known| effort_name(*known) == effort).ok_or_else(|| {
            PyValueError::new_err(format!(
                "effort: got \"{effort}\", expected \"nearest\", \"refined\", \"exhaustive\" or \"proved\""
            ))
        })?;
        let exits: i64 = self.or("exits", 1)?;
        let wanted = usize::try_from(exits).ok().filter(|wanted| (1..=MAX_EXITS).contains(wanted));
        let wrong = || PyValueError::new_err(format!("exits: got {exits}, expected 1 to {MAX_EXITS}"));
        let exits = wanted.ok_or_else(wrong)?;
        if exits > 1 && found == Effort::Nearest {
            let message =
                format!("exits: got {exits} with effort \"nearest\", expected 1: others are found by refinement");
            return Err(PyValueError::new_err(message));
        }
        let seconds: Option<f64> = self.get("max_seconds")?;
        if let Some(bad) = seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return Err(PyValueError::new_err(format!("max_seconds: got {bad}, expected more than 0")));
        }
        let starts = self.get("starts")?.map(|starts| count("starts", starts, 1)).transpose()?;
        if let Some(starts) = starts.filter(|starts| *starts > MAX_STARTS) {
            return Err(PyValueError::new_err(format!("starts: got {starts}, expected 1 to {MAX_STARTS}")));
        }
        if let Some(starts) = starts.filter(|_| found == Effort::Nearest) {
            let message = format!("starts: got {starts} with effort \"nearest\", expected None: it refines nothing");
            return Err(PyValueError::new_err(message));
        }
        let checks = self.get("max_checks")?.map(|checks| count("max_checks", checks, 0)).transpose()?;
        let gap: Option<f64> = self.get("gap")?;
        if let Some(bad) = gap.filter(|gap| !(0.0..1.0).contains(gap)) {
            return Err(PyValueError::new_err(format!("gap: got {bad}, expected 0 or more, and less than 1")));
        }
        if let Some(gap) = gap.filter(|_| found == Effort::Nearest) {
            let message = format!("gap: got {gap} with effort \"nearest\", expected None: it searches nothing");
            return Err(PyValueError::new_err(message));
        }
        if exits > 1 && (gap.is_some() || found == Effort::Proved) {
            let message = format!("exits: got {exits} with a gap to prove, expected 1: the search stops at one");
            return Err(PyValueError::new_err(message));
        }
        let termination = Termination { max_checks: checks, max_seconds: seconds, stop: None };
        Ok(QueryOptions { effort: found, exits, starts, gap, termination, ..QueryOptions::default() })
    }

    /// Those of `locked`, or all but those of `free`.
    fn locked(&self, scene: &Scene) -> PyResult<Vec<usize>> {
        let joints = |name: &str, names: Names| {
            let names = names.of(name)?;
            scene.joints_named(name, names.iter().map(String::as_str)).map_err(exception)
        };
        match (self.get::<Names>("locked")?, self.get::<Names>("free")?) {
            (Some(_), Some(_)) => Err(PyValueError::new_err("locked, free: got both, expected one of them")),
            (Some(locked), None) => joints("locked", locked),
            (None, Some(free)) => {
                let free = joints("free", free)?;
                Ok((0..scene.joints.len()).filter(|joint| !free.contains(joint)).collect())
            }
            (None, None) => Ok(Vec::new()),
        }
    }

    fn toward(&self, scene: &Scene) -> PyResult<Option<Toward>> {
        let share: f64 = self.or("toward_share", 0.25)?;
        if !(0.0..=1e9).contains(&share) {
            return Err(PyValueError::new_err(format!("toward_share: got {share}, expected 0 or more")));
        }
        let Some(goal) = self.value("toward")? else { return Ok(None) };
        let values = one_config("toward", &goal, &scene.space)?;
        let goal = scene.space.config(values.values()).map_err(|error| bad_row("toward", 0, true, error))?;
        Ok(Some(Toward { goal: goal.to_vec(), share }))
    }

    fn weights(&self) -> PyResult<Vec<(String, [f64; 2])>> {
        let Some(weights) = self.value("weights")? else { return Ok(Vec::new()) };
        let weights =
            weights.cast_into::<PyMapping>().map_err(|_| PyTypeError::new_err("weights: expected a dict by joint"))?;
        weights_of(&weights)
    }
}

/// By joint, of translations and rotation.
type Weights = Vec<(String, [f64; 2])>;

/// Weights as they are given: a number, or one of translations and one of the rotation, by joint.
///
/// # Errors
/// `TypeError` for what is no number; `ValueError` for more than two.
pub fn weights_of(weights: &Bound<'_, PyMapping>) -> PyResult<Weights> {
    let read = |item: Bound<'_, PyAny>| {
        let (name, value): (String, Bound<'_, PyAny>) = item.extract()?;
        let element = format!("weights[\"{name}\"]");
        match floats(&element, &value)?[..] {
            [all] => Ok((name, [all; 2])),
            [translation, rotation] => Ok((name, [translation, rotation])),
            _ => Err(PyValueError::new_err(format!("{element}: expected a number or (translation, rotation)"))),
        }
    };
    weights.items()?.iter().map(read).collect()
}

/// The last scene with other weights that was asked.
#[derive(Default)]
pub struct Weighted(Mutex<Option<(Weights, Arc<World>)>>);

impl Weighted {
    /// `world` with the weights; made anew where others were asked for last.
    ///
    /// # Errors
    /// `ValueError` for weights that mean nothing.
    pub fn of(&self, world: &World, weights: &Weights) -> PyResult<Arc<World>> {
        let mut last = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, known)) = last.as_ref().filter(|(known, _)| known == weights) {
            return Ok(Arc::clone(known));
        }
        let named = weights.iter().map(|(name, both)| (name.as_str(), *both));
        let scene = world.scene().weighted(named).map_err(exception)?;
        let made = Arc::new(long_call::pool(0)?.install(|| world.with_scene(scene)));
        *last = Some((weights.clone(), Arc::clone(&made)));
        Ok(made)
    }
}

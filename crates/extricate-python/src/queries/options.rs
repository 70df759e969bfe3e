//! Reads the keywords of `query`, `batch` and `stream` in one place. The library checks the values.

use extricate::entries::PoseEntry;
use extricate::{
    Config, Error, KeptLink, PairId, QUERY_OPTIONS, QueryOptions, Scene, Stop, StreamOptions, Termination, Toward,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList, PyMapping, PyString, PyType};

use crate::entries::lists::Names;
use crate::entries::pose::pose;
use crate::error::{Whole, count, exception, warn};
use crate::rows::arrays::{bad_row, floats, one_config};

/// The keywords that every call takes beside those of [`QUERY_OPTIONS`].
const EXTRA_KEYWORDS: [&str; 4] = ["options", "free", "weights", "limits"];
/// The options that a stream does not take, because each of its answers is the nearest exit.
const NOT_OF_STREAMS: [&str; 3] = ["exits", "toward", "toward_share"];
/// The keyword whose object may set most of the others.
const OPTIONS_KEYWORD: &str = "options";
static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Returns the library's options of queries: (name, default, expected), the default as Python
/// writes it.
#[pyfunction]
pub fn _query_options() -> Vec<(&'static str, &'static str, &'static str)> {
    QUERY_OPTIONS.iter().map(|option| (option.name, option.default, option.expected)).collect()
}

/// The kind of a call, which decides what keywords it takes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Call {
    Query,
    Batch,
    Stream,
}

impl Call {
    fn takes(self, name: &str) -> bool {
        let is_of_queries = EXTRA_KEYWORDS.contains(&name) || QUERY_OPTIONS.iter().any(|option| option.name == name);
        match self {
            Self::Query => is_of_queries,
            Self::Batch => is_of_queries || ["errors", "threads"].contains(&name),
            Self::Stream => {
                let is_own = ["hysteresis", "starts_per_frame", "continuous"].contains(&name);
                is_own || is_of_queries && !NOT_OF_STREAMS.contains(&name)
            }
        }
    }
}

/// The keywords of a call.
pub struct CallOptions {
    /// Options for the solver, which checks them.
    pub options: QueryOptions,
    /// Whether the call or its defaults set the number of exits.
    pub says_exits: bool,
    /// Whether configurations beyond the limits are refused.
    pub refuses: bool,
    /// Whether a row that is no configuration gets an answer that says so.
    pub masks: bool,
    pub threads: i64,
    pub stream: StreamOptions,
    /// The weights in place of the scene's; empty if none were given.
    pub weights: Weights,
}

impl CallOptions {
    /// Reads the keywords of a call; `defaults` apply to those that it does not set.
    ///
    /// # Errors
    /// `TypeError` for keywords that the call does not take, and values of a wrong type;
    /// `ValueError` for values that cannot be options.
    pub fn read<'py>(
        given: Option<&Bound<'py, PyDict>>,
        defaults: Option<&Bound<'py, PyDict>>,
        scene: &Scene,
        call: Call,
    ) -> PyResult<Self> {
        let given = Given::new(given, defaults, call)?;
        let mut options = QueryOptions::default();
        if let Some(word) = given.get::<String>("effort")? {
            options.effort = word.parse().map_err(exception)?;
        }
        options.exits = given.whole("exits")?.unwrap_or(options.exits);
        options.starts = given.whole("starts")?;
        options.gap = given.get("gap")?;
        options.clearance = given.get("clearance")?;
        options.locked = given.locked(scene)?;
        options.keep = given.keep(scene)?;
        options.touch = given.touch(scene)?;
        options.toward = given.toward(scene)?;
        options.termination.max_checks = given.whole("max_checks")?;
        options.termination.max_seconds = given.get("max_seconds")?;
        options.segment = given.or("segment", options.segment)?;
        options.contacts = given.or("contacts", options.contacts)?;
        options.free_radius = given.or("free_radius", options.free_radius)?;
        let mut stream = StreamOptions::default();
        stream.hysteresis = given.or("hysteresis", stream.hysteresis)?;
        if let Some(starts) = given.get("starts_per_frame")? {
            stream.starts_per_frame = count("starts_per_frame", starts, 0)?;
        }
        stream.continuous = given.or("continuous", stream.continuous)?;
        Ok(Self {
            options,
            says_exits: given.find("exits")?.is_some(),
            refuses: given.either("limits", ["forgive", "refuse"])?,
            masks: given.either("errors", ["raise", "mask"])?,
            threads: given.or("threads", 0)?,
            stream,
            weights: given.weights()?,
        })
    }

    /// Returns `solver`, which must have these options, with `stop` to end its queries.
    pub fn stopped_by(&self, solver: &extricate::Solver, stop: Stop) -> extricate::Solver {
        let mut options = self.options.clone();
        options.termination.stop = Some(stop);
        solver.clone().options(options).expect("the solver has them but for the stop")
    }

    /// Reads the configuration of one query.
    ///
    /// # Errors
    /// `ValueError` for a wrong shape, values that are not finite, or beyond a limit if that is
    /// refused.
    pub fn config(&self, q: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<Config> {
        let values = one_config("q", q, scene.space())?;
        if let Some(hint) = scene.degrees_hint(values.values()).filter(|_| !self.refuses) {
            warn(q.py(), &format!("q: {hint}"))?;
        }
        self.config_of(values.values(), scene).map_err(|error| bad_row("q", 0, true, error))
    }

    /// Reads a configuration from plain numbers; the call decides about those beyond limits.
    pub fn config_of(&self, values: &[f64], scene: &Scene) -> extricate::Result<Config> {
        if self.refuses { scene.config(values) } else { scene.space().config_anywhere(values) }
    }
}

/// Reads the budget of a motion or grasp.
///
/// # Errors
/// `ValueError` for a budget that makes no sense.
pub fn termination(max_checks: Option<Whole>, max_seconds: Option<f64>) -> PyResult<Termination> {
    let mut termination = Termination::default();
    termination.max_checks = max_checks.map(|checks| whole("max_checks", checks)).transpose()?;
    termination.max_seconds = max_seconds;
    QueryOptions::default().termination(termination.clone()).check().map_err(exception)?;
    Ok(termination)
}

/// Reads the count of an option; the library checks how large it may be.
fn whole(name: &'static str, value: Whole) -> PyResult<usize> {
    match value {
        Whole::Number(number) if number < 0 => {
            let expected = QUERY_OPTIONS.iter().find(|option| option.name == name).map_or("", |option| option.expected);
            Err(exception(Error::Option { name, value: number.to_string(), expected: expected.into() }))
        }
        value => count(name, value, 0),
    }
}

/// The keywords of a call, then its defaults. The first layer that has a name decides.
struct Given<'py> {
    call: Call,
    layers: Vec<Layer<'py>>,
}

enum Layer<'py> {
    Keywords(Bound<'py, PyDict>),
    /// An object of the class `QueryOptions`.
    Options(Bound<'py, PyAny>),
}

impl<'py> Layer<'py> {
    /// Returns the value of a name, which may be Python's None.
    fn find(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        match self {
            Self::Keywords(keywords) => keywords.get_item(name),
            Self::Options(options) => options.getattr_opt(name),
        }
    }
}

impl<'py> Given<'py> {
    fn new(given: Option<&Bound<'py, PyDict>>, defaults: Option<&Bound<'py, PyDict>>, call: Call) -> PyResult<Self> {
        for name in given.iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if !call.takes(&name) {
                return Err(PyTypeError::new_err(format!("got an unexpected keyword argument '{name}'")));
            }
        }
        let mut layers = Vec::new();
        for (keywords, is_of_call) in given.iter().map(|given| (given, true)).chain(defaults.iter().map(|d| (d, false)))
        {
            layers.push(Layer::Keywords((*keywords).clone()));
            if let Some(options) = keywords.get_item(OPTIONS_KEYWORD)?.filter(|options| !options.is_none()) {
                check_options(&options, is_of_call.then_some(call))?;
                layers.push(Layer::Options(options));
            }
        }
        Ok(Self { call, layers })
    }

    fn find(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        if self.call == Call::Stream && NOT_OF_STREAMS.contains(&name) {
            return Ok(None);
        }
        for layer in &self.layers {
            if let Some(found) = layer.find(name)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Returns a value that was given and is not None.
    fn value(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.find(name)?.filter(|value| !value.is_none()))
    }

    fn get<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str) -> PyResult<Option<T>> {
        self.value(name)?.map(|value| extracted(name, &value)).transpose()
    }

    fn or<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str, default: T) -> PyResult<T> {
        Ok(self.get(name)?.unwrap_or(default))
    }

    fn whole(&self, name: &'static str) -> PyResult<Option<usize>> {
        self.get(name)?.map(|value| whole(name, value)).transpose()
    }

    /// Whether the keyword is the second of two words; the first is the default.
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

    /// Returns the joints that `locked` names, or all but those that `free` names. The first layer
    /// that has one of the two decides.
    fn locked(&self, scene: &Scene) -> PyResult<Vec<usize>> {
        let joints = |name: &str, value: &Bound<'py, PyAny>| {
            let names = extracted::<Names>(name, value)?.of(name)?;
            scene.joints_named(name, names.iter().map(String::as_str)).map_err(exception)
        };
        for layer in &self.layers {
            let both = [layer.find("locked")?, layer.find("free")?];
            if both.iter().all(Option::is_none) {
                continue;
            }
            return match both.map(|value| value.filter(|value| !value.is_none())) {
                [Some(_), Some(_)] => Err(PyValueError::new_err("locked, free: got both, expected one of them")),
                [Some(locked), None] => joints("locked", &locked),
                [None, Some(free)] => {
                    let free = joints("free", &free)?;
                    Ok((0..scene.joints().len()).filter(|joint| !free.contains(joint)).collect())
                }
                [None, None] => Ok(Vec::new()),
            };
        }
        Ok(Vec::new())
    }

    /// Reads the pairs of bodies that have to touch.
    fn touch(&self, scene: &Scene) -> PyResult<Vec<PairId>> {
        let Some(value) = self.value("touch")? else { return Ok(Vec::new()) };
        let pairs: Vec<(String, String)> = extracted("touch", &value)?;
        let named = |(a, b): &(String, String)| scene.pair_named("touch", [a, b]).map_err(exception);
        pairs.iter().map(named).collect()
    }

    fn keep(&self, scene: &Scene) -> PyResult<Vec<KeptLink>> {
        kept_links(self.value("keep")?, scene)
    }

    fn toward(&self, scene: &Scene) -> PyResult<Option<Toward>> {
        let share = self.or("toward_share", 0.25)?;
        let Some(goal) = self.value("toward")? else { return Ok(None) };
        let values = one_config("toward", &goal, scene.space())?;
        let goal = scene.config(values.values()).map_err(|error| bad_row("toward", 0, true, error))?;
        Ok(Some(Toward::new(goal, share)))
    }

    fn weights(&self) -> PyResult<Weights> {
        let Some(weights) = self.value("weights")? else { return Ok(Vec::new()) };
        let weights =
            weights.cast_into::<PyMapping>().map_err(|_| PyTypeError::new_err("weights: expected a dict by joint"))?;
        weights_of(&weights)
    }
}

/// Checks that `options` is a `QueryOptions`, and sets nothing that `call` does not take.
fn check_options(options: &Bound<'_, PyAny>, call: Option<Call>) -> PyResult<()> {
    let class = CLASS.import(options.py(), "extricate._options", "QueryOptions")?;
    if !options.is_instance(class)? {
        let found = options.get_type().name()?;
        return Err(PyTypeError::new_err(format!("options: got {found}, expected extricate.QueryOptions")));
    }
    for name in NOT_OF_STREAMS.iter().filter(|_| call == Some(Call::Stream)) {
        if !options.getattr(name)?.eq(class.getattr(name)?)? {
            let message = format!("options: got {name}, expected none: a stream answers with the nearest exit");
            return Err(PyValueError::new_err(message));
        }
    }
    Ok(())
}

/// Converts the value of a keyword; errors name the keyword.
fn extracted<'py, T: for<'a> FromPyObject<'a, 'py>>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T> {
    let wrong = |error: PyErr| {
        let message = format!("argument '{name}': {}", error.value(value.py()));
        match error.is_instance_of::<PyTypeError>(value.py()) {
            true => PyTypeError::new_err(message),
            false => PyValueError::new_err(message),
        }
    };
    value.extract::<T>().map_err(|error| wrong(error.into()))
}

/// Weights of the translations and of the rotation, by joint.
pub type Weights = Vec<(String, [f64; 2])>;

/// Reads weights by joint: one number, or one of translations and one of the rotation.
///
/// # Errors
/// `TypeError` for values that are no numbers; `ValueError` for more than two.
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

/// Reads kept links: a name or a mapping, a sequence of these, or none.
///
/// # Errors
/// `TypeError` for values of other types; `ValueError` for what is not in the scene or makes no
/// sense.
pub fn kept_links(value: Option<Bound<'_, PyAny>>, scene: &Scene) -> PyResult<Vec<KeptLink>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let is_one = value.is_instance_of::<PyString>() || value.cast::<PyMapping>().is_ok();
    let entries: Vec<Bound<'_, PyAny>> = if is_one { vec![value] } else { extracted("keep", &value)? };
    entries.iter().map(|entry| kept_link(entry, scene)).collect()
}

/// Reads a kept link: its name or a mapping, whose pose may have any form that `Box` takes.
fn kept_link(entry: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<KeptLink> {
    let copy = PyDict::new(entry.py());
    let items = match entry.cast::<PyMapping>() {
        Ok(mapping) => mapping.items()?,
        Err(_) => {
            copy.set_item("link", extracted::<String>("keep", entry)?)?;
            PyList::empty(entry.py())
        }
    };
    for item in items {
        let (key, value): (String, Bound<'_, PyAny>) = extracted("keep", &item)?;
        if key == "pose" && !value.is_none() {
            let PoseEntry { xyz, rpy, quat_xyzw, quat_wxyz } = pose("keep[\"pose\"]", &value)?;
            let pose = PyDict::new(entry.py());
            pose.set_item("xyz", xyz)?;
            rpy.map_or(Ok(()), |rpy| pose.set_item("rpy", rpy))?;
            quat_xyzw.map_or(Ok(()), |quaternion| pose.set_item("quat_xyzw", quaternion))?;
            quat_wxyz.map_or(Ok(()), |quaternion| pose.set_item("quat_wxyz", quaternion))?;
            copy.set_item(key, pose)?;
        } else if key == "axis" && !value.is_none() {
            copy.set_item(key, floats("keep[\"axis\"]", &value)?)?;
        } else {
            copy.set_item(key, value)?;
        }
    }
    let json: String = entry.py().import("json")?.call_method1("dumps", (copy,))?.extract()?;
    KeptLink::from_text(scene, &json)
        .map_err(exception)?
        .pop()
        .ok_or_else(|| PyValueError::new_err("keep: got nothing"))
}

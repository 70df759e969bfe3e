//! `release`: hands that hold an object and penetrate nothing.

use extricate::entries::{SceneFile, read_obstacles};
use extricate::{Config, Grasp, Hand, QueryOptions, ReleaseOptions, Released};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyMapping, PyType};
use rayon::prelude::*;

use crate::entries;
use crate::entries::lists::Names;
use crate::error::{Whole, exception, threads as thread_count};
use crate::long_call;
use crate::queries::options::{termination, weights_of};
use crate::rows::POLL_ROWS;
use crate::rows::arrays::{Configs, bad_row, configs, floats};
use crate::solver::handle::{Handle, prepare};

const PYTHON_MODULE: &str = "extricate._grasp";
static GRASP: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONTACT: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The keywords `touch`, `friction` and `clearance`.
type Lengths = (f64, Option<f64>, Option<f64>);

/// Keywords of `release`, in the order of its signature.
pub type Keywords<'a, 'py> = (
    &'a str,
    Lengths,
    Option<&'a Bound<'py, PyAny>>,
    Names,
    Option<&'a Bound<'py, PyAny>>,
    Option<Whole>,
    Option<f64>,
    i64,
);

pub fn release<'py>(
    handle: &Handle,
    queries: &Bound<'py, PyAny>,
    object: &Bound<'py, PyAny>,
    keywords: Keywords<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, scene) = (queries.py(), handle.scene());
    let (keep, lengths, open, locked, weights, max_checks, max_seconds, threads) = keywords;
    let mut query = QueryOptions::default().termination(termination(max_checks, max_seconds)?);
    let locked = locked.of("locked")?;
    query.locked = scene.joints_named("locked", locked.iter().map(String::as_str)).map_err(exception)?;
    let mut options = options_of(keep, lengths, query)?;
    options.open = open.map(|open| posture(open, scene)).transpose()?;
    let q = configs("Q", queries, scene.space())?;
    let rows = configs_of(py, &q, scene)?;
    let held = HeldObjects::of(object, scene, rows.len())?;
    let solver = weighted(py, weights, handle)?;
    prepare(py, &solver)?;
    let pool = long_call::pool(thread_count(threads)?)?;
    let found = long_call::run(
        py,
        |_, ()| Ok(()),
        |line| {
            options.query.termination.stop = Some(line.stop());
            pool.install(|| held.release(&solver, rows, &options))
        },
    )?;
    let grasp = |(row, released): (usize, Released)| match released {
        Ok(grasp) => grasp.map(|grasp| object_of(py, &grasp)).transpose(),
        Err(message) => Err(PyValueError::new_err(format!("object[{row}]: {message}"))),
    };
    let grasps = found.into_iter().enumerate().map(grasp).collect::<PyResult<Vec<_>>>()?;
    if q.single {
        Ok(grasps.into_iter().next().flatten().into_pyobject(py)?)
    } else {
        Ok(grasps.into_pyobject(py)?.into_any())
    }
}

fn options_of(keep: &str, (touch, friction, clearance): Lengths, mut query: QueryOptions) -> PyResult<ReleaseOptions> {
    for (name, value) in [("touch", Some(touch)), ("friction", friction)] {
        if let Some(bad) = value.filter(|value| !(0.0..=1e9).contains(value)) {
            return Err(PyValueError::new_err(format!("{name}: got {bad}, expected a number, 0 or more")));
        }
    }
    query.clearance = clearance;
    query.check().map_err(exception)?;
    let keep = keep.parse().map_err(exception)?;
    let mut options = ReleaseOptions::default().keep(keep).touch(touch).query(query);
    options.friction = friction.filter(|friction| *friction > 0.0);
    Ok(options)
}

fn configs_of(py: Python<'_>, q: &Configs, scene: &extricate::Scene) -> PyResult<Vec<Config>> {
    let config = |(row, values): (usize, &[f64])| {
        if row % POLL_ROWS == 0 {
            py.check_signals()?;
        }
        scene.space().config_anywhere(values).map_err(|error| bad_row("Q", row, q.single, error))
    };
    q.values().chunks_exact(scene.space().nq()).enumerate().map(config).collect()
}

/// The objects that the rows hold.
enum HeldObjects {
    /// All rows hold the same obstacle of the scene.
    Named(Hand),
    /// Obstacles that are not in the scene, and the index of the one that each row holds.
    Given(Box<SceneFile>, Vec<usize>),
}

impl HeldObjects {
    fn of(object: &Bound<'_, PyAny>, scene: &extricate::Scene, rows: usize) -> PyResult<Self> {
        if let Ok(name) = object.extract::<String>() {
            return Ok(Self::Named(Hand::new(scene, &name).map_err(exception)?));
        }
        let given: Vec<Bound<'_, PyAny>> = match object.extract() {
            Ok(given) => given,
            Err(_) => vec![object.clone(); rows],
        };
        if given.len() != rows {
            let message = format!("object: got {} obstacles for {rows} rows, expected one each", given.len());
            return Err(PyValueError::new_err(message));
        }
        // A Python object that occurs several times is prepared once.
        let (mut unlike, mut places): (Vec<Bound<'_, PyAny>>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut known = std::collections::HashMap::new();
        for object in given {
            if object.extract::<String>().is_ok() {
                let message = "object: got a sequence with a name, expected obstacles, such as Mesh(\"cup.obj\")";
                return Err(PyTypeError::new_err(message));
            }
            let place = *known.entry(object.as_ptr() as usize).or_insert_with(|| {
                unlike.push(object.clone());
                unlike.len() - 1
            });
            places.push(place);
        }
        let taken = scene.bodies().iter().map(|body| body.name.clone()).collect();
        let obstacle = entries::obstacle_entries(&unlike, taken)?;
        Ok(Self::Given(Box::new(SceneFile { obstacle, ..SceneFile::default() }), places))
    }

    fn release(self, solver: &extricate::Solver, rows: Vec<Config>, options: &ReleaseOptions) -> Vec<Released> {
        match self {
            Self::Named(hand) => rows.par_iter().map(|q| Ok(solver.release(&hand, q, options))).collect(),
            Self::Given(entries, places) => {
                let grasps: Vec<(usize, Config)> = places.into_iter().zip(rows).collect();
                let object_of = |number: usize| {
                    let own = SceneFile { obstacle: vec![entries.obstacle[number].clone()], ..SceneFile::default() };
                    let (mut bodies, _) = read_obstacles(entries::NAME, &own)?;
                    bodies
                        .pop()
                        .ok_or_else(|| extricate::Error::input(entries::NAME, "object", "got no shape, expected one"))
                };
                solver.release_batch(&grasps, &object_of, options)
            }
        }
    }
}

fn posture(open: &Bound<'_, PyAny>, scene: &extricate::Scene) -> PyResult<Vec<f64>> {
    let values = floats("open", open)?;
    let found = scene.space().config_anywhere(values.as_slice());
    found.map(Vec::from).map_err(|error| bad_row("open", 0, true, error))
}

/// Returns a solver without a model, with the weights of the hand, the scene or the caller.
fn weighted(py: Python<'_>, weights: Option<&Bound<'_, PyAny>>, handle: &Handle) -> PyResult<extricate::Solver> {
    let Some(given) = weights else { return Ok(handle.for_hands(py)) };
    if given.extract::<String>().is_ok_and(|word| word == "scene") {
        return Ok(handle.ready(py)?.without_model());
    }
    let weights = given
        .cast::<PyMapping>()
        .map_err(|_| PyTypeError::new_err("weights: expected weights by name of a joint, \"scene\" or None"))?;
    Ok(handle.with_weights(py, &weights_of(weights)?)?.without_model())
}

/// Converts a grasp to the Python class `Grasp`.
fn object_of<'py>(py: Python<'py>, grasp: &Grasp) -> PyResult<Bound<'py, PyAny>> {
    let contact = |contact: &extricate::GraspContact| {
        let [point, normal] = [contact.point, contact.normal].map(|v| PyArray1::from_slice(py, &v));
        CONTACT.import(py, PYTHON_MODULE, "GraspContact")?.call1((&contact.link, contact.distance, point, normal))
    };
    let contacts = grasp.contacts.iter().map(contact).collect::<PyResult<Vec<_>>>()?;
    let quality = grasp.quality;
    GRASP.import(py, PYTHON_MODULE, "Grasp")?.call1((
        PyArray1::from_slice(py, &grasp.config),
        grasp.moved,
        grasp.verified,
        contacts,
        &grasp.touched,
        &grasp.kept,
        (grasp.fingers[0], grasp.fingers[1]),
        grasp.kept_sides,
        grasp.depth_before,
        quality.map(|quality| quality.epsilon),
        quality.map(|quality| quality.force_closure),
        grasp.checks,
    ))
}

//! Hands that hold an object and penetrate nothing.

use extricate::internals::grasp::{Released, release_batch};
use extricate::internals::io;
use extricate::internals::scene::file::SceneFile;
use extricate::{Config, Grasp, Hand, Keep, QueryOptions, ReleaseOptions, Termination, World};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyMapping, PyType};
use rayon::prelude::*;

use super::Scene;
use crate::entries;
use crate::entries::lists::Names;
use crate::error::{Whole, count, exception, threads as thread_count};
use crate::long_call;
use crate::queries::options::weights_of;
use crate::rows::LOOK;
use crate::rows::arrays::{bad_row, configs, floats};

const HOME: &str = "extricate._grasp";
static GRASP: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONTACT: PyOnceLock<Py<PyType>> = PyOnceLock::new();

#[pymethods]
impl Scene {
    /// The nearest hands to Q at which nothing penetrates and what touched the object still does,
    /// each finger on its side of it. No model is needed.
    ///
    /// Q: float64 (n, nq), or (nq,) for one; may lie beyond limits.
    /// object: what is held: the name of an obstacle; an obstacle that is not in the scene, such as
    ///     a `Mesh`; or a sequence of n obstacles, one a row (equal ones are prepared once).
    /// keep: "contacts", or "pose": the nearest free hand, whatever it touches.
    /// touch: a link touches where it is nearer than this [m] beyond the clearance.
    /// friction: coefficient, for `Grasp.epsilon` and `Grasp.force_closure`; None leaves them out.
    /// open: a configuration with open fingers (nq,), which tells on which side of the object each
    ///     is; None takes 0 for every joint, or the limit nearest to it.
    /// clearance: to aim at in place of the scene's [m].
    /// locked: names of joints that stay; "base" is the base of a floating hand.
    /// weights: as in `Model.query`. None: moving a floating base is about as dear as moving
    ///     fingers, where the scene gives it no weights. "scene": those of the scene.
    /// max_checks: end each after about this many checks and contact evaluations.
    /// max_seconds: end each after about this many seconds.
    /// threads: 0 for one per core; the answers are the same.
    ///
    /// Returns a `Grasp` for one, else a list; None where nothing free was found.
    ///
    /// Raises ValueError for wrong shapes, names and values, and objects that cannot be used.
    #[pyo3(signature = (Q, *, object, keep = "contacts", touch = 2e-3, friction = Some(0.8), open = None, clearance = None, locked = Names::default(), weights = None, max_checks = None, max_seconds = None, threads = 0), text_signature = "($self, Q, *, object, keep='contacts', touch=2e-3, friction=0.8, open=None, clearance=None, locked=(), weights=None, max_checks=None, max_seconds=None, threads=0)")]
    #[allow(non_snake_case)]
    fn release<'py>(
        &self,
        Q: &Bound<'py, PyAny>,
        object: &Bound<'py, PyAny>,
        keep: &str,
        touch: f64,
        friction: Option<f64>,
        open: Option<&Bound<'py, PyAny>>,
        clearance: Option<f64>,
        locked: Names,
        weights: Option<&Bound<'py, PyAny>>,
        max_checks: Option<Whole>,
        max_seconds: Option<f64>,
        threads: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = Q.py();
        let scene = self.inner();
        for (name, value) in [("touch", Some(touch)), ("friction", friction), ("clearance", clearance)] {
            if let Some(bad) = value.filter(|value| !(0.0..=1e9).contains(value)) {
                return Err(PyValueError::new_err(format!("{name}: got {bad}, expected a number, 0 or more")));
            }
        }
        if let Some(bad) = max_seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return Err(PyValueError::new_err(format!("max_seconds: got {bad}, expected more than 0")));
        }
        let max_checks = max_checks.map(|checks| count("max_checks", checks, 0)).transpose()?;
        let locked = locked.of("locked")?;
        let locked = scene.joints_named("locked", locked.iter().map(String::as_str)).map_err(exception)?;
        let mut options = ReleaseOptions {
            keep: match keep {
                "contacts" => Keep::Contacts,
                "pose" => Keep::Pose,
                _ => {
                    return Err(PyValueError::new_err(format!(
                        "keep: got {keep:?}, expected \"contacts\" or \"pose\""
                    )));
                }
            },
            touch,
            friction: friction.filter(|friction| *friction > 0.0),
            open: open.map(|open| posture(open, scene)).transpose()?,
            query: QueryOptions { clearance, locked, ..QueryOptions::default() },
        };
        let q = configs("Q", Q, &scene.space)?;
        let (nq, single) = (scene.space.nq(), q.single);
        let rows = q.values().chunks_exact(nq).enumerate();
        let config = |(row, q): (usize, &[f64])| {
            if row % LOOK == 0 {
                py.check_signals()?;
            }
            scene.space.config_anywhere(q).map_err(|error| bad_row("Q", row, single, error))
        };
        let rows: Vec<Config> = rows.map(config).collect::<PyResult<_>>()?;
        let held = Held::of(object, self, rows.len())?;
        let own = weighted(weights, scene)?;
        let pool = long_call::pool(thread_count(threads)?)?;
        let found = long_call::run(
            py,
            |_, ()| Ok(()),
            |line| {
                options.query.termination = Termination { max_checks, max_seconds, stop: Some(line.stop()) };
                let world = self.world()?;
                pool.install(|| {
                    let other = own.map(|scene| world.with_scene(scene));
                    held.release(other.as_ref().unwrap_or(world), rows, &options)
                })
            },
        )??;
        let grasp = |(row, released): (usize, Released)| match released {
            Ok(grasp) => grasp.map(|grasp| object_of(py, &grasp)).transpose(),
            Err(message) => Err(PyValueError::new_err(format!("object[{row}]: {message}"))),
        };
        let grasps = found.into_iter().enumerate().map(grasp).collect::<PyResult<Vec<_>>>()?;
        if single {
            Ok(grasps.into_iter().next().flatten().into_pyobject(py)?)
        } else {
            Ok(grasps.into_pyobject(py)?.into_any())
        }
    }
}

/// What is held.
enum Held {
    /// An obstacle of the scene.
    Named(Hand),
    /// Obstacles of their own, and which of them each row holds.
    Given(Box<SceneFile>, Vec<usize>),
}

impl Held {
    fn of(object: &Bound<'_, PyAny>, scene: &Scene, rows: usize) -> PyResult<Self> {
        if let Ok(name) = object.extract::<String>() {
            return Ok(Self::Named(Hand::new(scene.inner(), &name).map_err(exception)?));
        }
        let given: Vec<Bound<'_, PyAny>> = match object.extract() {
            Ok(given) => given,
            Err(_) => vec![object.clone(); rows],
        };
        if given.len() != rows {
            let message = format!("object: got {} obstacles for {rows} rows, expected one each", given.len());
            return Err(PyValueError::new_err(message));
        }
        // Objects of Python that are one and the same are prepared once.
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
        let taken = scene.inner().bodies.iter().map(|body| body.name.clone()).collect();
        let obstacle = entries::obstacle_entries(&unlike, taken)?;
        Ok(Self::Given(Box::new(SceneFile { obstacle, ..SceneFile::default() }), places))
    }

    fn release(self, world: &World, rows: Vec<Config>, options: &ReleaseOptions) -> PyResult<Vec<Released>> {
        match self {
            Self::Named(hand) => {
                let view = world.view();
                let release = |scratch: &mut _, q: &Config| Ok(hand.release(&view, q, options, scratch));
                Ok(rows.par_iter().map_init(Default::default, release).collect())
            }
            Self::Given(entries, places) => {
                let grasps: Vec<(usize, Config)> = places.into_iter().zip(rows).collect();
                let object_of = |number: usize| {
                    let own = SceneFile { obstacle: vec![entries.obstacle[number].clone()], ..SceneFile::default() };
                    let (mut bodies, _) = io::read_obstacles(entries::NAME, &own)?;
                    bodies
                        .pop()
                        .ok_or_else(|| extricate::Error::input(entries::NAME, "object", "got no shape, expected one"))
                };
                Ok(release_batch(world, &grasps, &object_of, options))
            }
        }
    }
}

fn posture(open: &Bound<'_, PyAny>, scene: &extricate::Scene) -> PyResult<Vec<f64>> {
    let values = floats("open", open)?;
    let found = scene.space.config_anywhere(values.as_slice());
    found.map(|q| q.to_vec()).map_err(|error| bad_row("open", 0, true, error))
}

/// The scene with other weights, where it gets some.
fn weighted(weights: Option<&Bound<'_, PyAny>>, scene: &extricate::Scene) -> PyResult<Option<extricate::Scene>> {
    let Some(given) = weights else { return Ok(Hand::weighted(scene)) };
    if given.extract::<String>().is_ok_and(|word| word == "scene") {
        return Ok(None);
    }
    let weights = given
        .cast::<PyMapping>()
        .map_err(|_| PyTypeError::new_err("weights: expected weights by name of a joint, \"scene\" or None"))?;
    let weights = weights_of(weights)?;
    let named = weights.iter().map(|(name, weights)| (name.as_str(), *weights));
    scene.weighted(named).map(Some).map_err(exception)
}

/// A grasp as an object of Python's class.
fn object_of<'py>(py: Python<'py>, grasp: &Grasp) -> PyResult<Bound<'py, PyAny>> {
    let contact = |contact: &extricate::GraspContact| {
        let [point, normal] = [contact.point, contact.normal].map(|v| PyArray1::from_iter(py, v.iter().copied()));
        CONTACT.import(py, HOME, "GraspContact")?.call1((&contact.link, contact.distance, point, normal))
    };
    let contacts = grasp.contacts.iter().map(contact).collect::<PyResult<Vec<_>>>()?;
    let quality = grasp.quality;
    GRASP.import(py, HOME, "Grasp")?.call1((
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

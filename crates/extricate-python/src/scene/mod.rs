//! The class `Scene`, whose calls need no model.

pub mod check;
pub mod contacts;
pub mod edit;
pub mod geometry;
pub mod import;
pub mod joint;
pub mod load_limits;
pub mod positions;

use std::path::PathBuf;
use std::sync::Arc;

use extricate::entries::assemble_scene;
use extricate::{LoadOptions, Manifold, builtin, load_scene_with};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyMapping};

use crate::entries::clearance::Clearance;
use crate::entries::lists::Folders;
use crate::entries::{self, Obstacles, Options};
use crate::error::{exception, warned};
use crate::long_call;
use crate::solver::handle::Handle;
use joint::Joint;
use load_limits::{Limits, limits_of};

/// Robots, obstacles, the pairs of bodies that must stay apart, and the metric, which measures the
/// distance of two configurations.
///
/// Configurations are rows of `nq` numbers in the order of `joints` (angles in rad, lengths in m,
/// quaternions x, y, z, w). A scene is immutable: threads may share it. It pickles.
///
/// Scene(robot, obstacles=(), *, clearance=1e-4, metric="joint", weights=None, disable=(),
/// enable=(), padding=None, pair_clearance=(), packages=())
///
/// robot: a URDF, as path or as text, a `Robot` with more options, or a list of them.
/// obstacles: `Box`, `Sphere`, `Cylinder`, `Capsule`, `Mesh`, `Fixture`, `Points`, `Voxels`,
///     `HalfSpace` and `HeightField` objects.
/// clearance: least distance [m] that every checked pair of a free configuration keeps; or
///     {"world": .., "self": ..}: one for pairs with an obstacle and one for others, 1e-4 if one is
///     missing.
/// metric: "joint" [rad], "object-norm" [m] or "max-displacement" [m].
/// weights: by joint, weights of squared displacements in the joint metric; 1 for joints that are
///     not named.
/// disable: pairs of names of bodies that need not stay apart.
/// enable: pairs of names of bodies that must stay apart although one joint joins them or an SRDF
///     disables them.
/// padding: by name, what a link adds to its clearance toward obstacles, or an obstacle to that of
///     all its pairs [m].
/// pair_clearance: (name, name, clearance [m]) of pairs with a clearance of their own, whatever the
///     other arguments are.
/// packages: folders in which `package://NAME/...` is looked up first, as `FOLDER/NAME/...`. Then
///     come `packages` of a `Robot`, the folders that contain its URDF, and those of
///     AMENT_PREFIX_PATH and ROS_PACKAGE_PATH.
#[pyclass(frozen, module = "extricate._extricate")]
pub struct Scene {
    handle: Handle,
}

impl Scene {
    pub fn of(scene: Arc<extricate::Scene>) -> Self {
        Self::of_solver(extricate::Solver::new(scene))
    }

    /// Makes the scene of a solver that has no model.
    pub fn of_solver(solver: extricate::Solver) -> Self {
        Self { handle: Handle::new(solver) }
    }

    /// Wraps a changed `scene`, which shares prepared data of equal bodies with this one.
    ///
    /// # Errors
    /// None: a solver without a model takes every scene.
    pub fn changed(&self, scene: extricate::Scene) -> PyResult<Self> {
        self.handle.solver().with_scene(scene).map(Self::of_solver).map_err(exception)
    }

    pub fn inner(&self) -> &Arc<extricate::Scene> {
        self.handle.scene()
    }

    /// The handle for calls without a model.
    pub fn handle(&self) -> &Handle {
        &self.handle
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (robot, obstacles = Obstacles::default(), *, clearance = Clearance::default(), metric = "joint", weights = None, disable = Vec::new(), enable = Vec::new(), padding = None, pair_clearance = Vec::new(), packages = Folders::default()), text_signature = "(robot, obstacles=(), *, clearance=1e-4, metric='joint', weights=None, disable=(), enable=(), padding=None, pair_clearance=(), packages=())")]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, PyAny>,
        obstacles: Obstacles<'_>,
        clearance: Clearance,
        metric: &str,
        weights: Option<Bound<'_, PyMapping>>,
        disable: Vec<[String; 2]>,
        enable: Vec<[String; 2]>,
        padding: Option<Bound<'_, PyMapping>>,
        pair_clearance: Vec<(String, String, f64)>,
        packages: Folders,
    ) -> PyResult<Self> {
        let metric = metric.into();
        let options = Options {
            clearance,
            metric,
            weights,
            disable,
            enable,
            padding,
            pair_clearance,
            packages: packages.of("packages")?,
        };
        let described = entries::describe(robot, &obstacles.0, options)?;
        let assemble = move || assemble_scene(entries::NAME, &described.entries, &described.texts);
        let assembled = long_call::apart(py, assemble)?;
        warned(py, assembled.map_err(exception)?).map(Self::of)
    }

    /// Loads a scene file (TOML) and all files that it names.
    ///
    /// load_limits: limits of what the files may hold, by name, in place of the default ones, such
    ///     as {"triangles": 50_000_000}; docs/reference/limits.md lists them.
    /// packages: folders in which `package://NAME/...` is looked up first.
    #[staticmethod]
    #[pyo3(signature = (path, *, load_limits = None, packages = Folders::default()), text_signature = "(path, *, load_limits=None, packages=())")]
    fn load(py: Python<'_>, path: PathBuf, load_limits: Option<Limits>, packages: Folders) -> PyResult<Self> {
        let options = LoadOptions::default().limits(limits_of(load_limits)?).packages(packages.of("packages")?);
        let loaded = long_call::apart(py, move || load_scene_with(&path, &options))?;
        warned(py, loaded.map_err(exception)?).map(Self::of)
    }

    /// Returns joints, bodies and settings as a table of HTML, for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("extricate._page")?.call_method1("scene_table", (slf,))
    }

    /// Makes a built-in scene: "shelf-arm", "planar-arm", "free-box", "dual-arm", "hand" or
    /// "four-legs".
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> PyResult<Self> {
        Ok(Self::of(Arc::new(long_call::pooled(py, || builtin::scene(name))?.map_err(exception)?)))
    }

    /// Returns the files of a built-in scene: contents by path, the scene file first, then its URDF
    /// and meshes.
    #[staticmethod]
    fn builtin_files<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let unknown = || PyValueError::new_err(format!("name: got \"{name}\", expected one of {:?}", builtin::NAMES));
        let all = PyDict::new(py);
        for (path, contents) in builtin::files(name).ok_or_else(unknown)? {
            all.set_item(path, PyBytes::new(py, &contents))?;
        }
        Ok(all)
    }

    /// Number of coordinates of a configuration.
    #[getter]
    fn nq(&self) -> usize {
        self.inner().space().nq()
    }

    /// Number of degrees of freedom; less than `nq` if there are quaternions.
    #[getter]
    fn nv(&self) -> usize {
        self.inner().space().nv()
    }

    /// Least distance [m] that every checked pair of a free configuration keeps.
    #[getter]
    fn clearance(&self) -> f64 {
        self.inner().clearance()
    }

    /// Name of the metric: "joint", "object-norm" or "max-displacement".
    #[getter]
    fn metric(&self) -> &'static str {
        self.inner().metric().name()
    }

    /// The joints that have coordinates, in order.
    #[getter]
    fn joints(&self) -> Vec<Joint> {
        self.inner().joints().iter().map(Joint::of).collect()
    }

    /// Least value of each coordinate [rad or m], shape (nq,): -pi for full turns, -1 in
    /// quaternions.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.limits(|lower, _| lower))
    }

    /// Greatest value of each coordinate [rad or m], shape (nq,): pi for full turns, 1 in
    /// quaternions.
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.limits(|_, upper| upper))
    }

    /// Names of the bodies that have geometry: links, then obstacles.
    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.inner().bodies().iter().map(|body| body.name.as_str()).collect()
    }

    /// The pairs of bodies that are checked.
    #[getter]
    fn pairs(&self) -> Vec<(&str, &str)> {
        let scene = self.inner();
        (0..scene.pairs().len()).map(|pair| scene.pair_names(extricate::PairId::new(pair)).into()).collect()
    }

    /// Warnings about the scene: meshes that are not closed, defaults that were taken.
    #[getter]
    fn warnings(&self) -> Vec<&str> {
        self.inner().warnings().iter().map(String::as_str).collect()
    }

    fn __repr__(&self) -> String {
        let scene = self.inner();
        let (nq, bodies, pairs) = (scene.space().nq(), scene.bodies().len(), scene.pairs().len());
        format!("<Scene of {nq} coordinates, {bodies} bodies, {pairs} checked pairs, metric {}>", self.metric())
    }

    /// Makes a scene from its pickled bytes.
    #[staticmethod]
    fn _from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let scene = long_call::pooled(py, || extricate::Scene::from_bytes(data))?;
        Ok(Self::of(Arc::new(scene.map_err(exception)?)))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = py.detach(|| self.inner().to_bytes());
        Ok((py.get_type::<Self>().getattr("_from_bytes")?, (PyBytes::new(py, &bytes),)))
    }
}

impl Scene {
    fn limits(&self, pick: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.inner().space().nq());
        for factor in self.inner().space().factors() {
            match factor.manifold {
                Manifold::Interval { lower, upper } => all.push(pick(lower, upper)),
                Manifold::Circle => all.push(pick(-std::f64::consts::PI, std::f64::consts::PI)),
                Manifold::Rotation => all.extend([pick(-1.0, 1.0); 4]),
            }
        }
        all
    }
}

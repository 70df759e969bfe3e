//! Methods of `Scene` that derive a changed scene. The new one shares all that did not change.

use extricate::entries::{SceneFile, read_obstacles};
use extricate::geometry::{Body, Pose};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use super::Scene;
use crate::entries::lists::Names;
use crate::entries::{self, Obstacles};
use crate::error::{exception, warn};
use crate::long_call;

/// Returns `scene` with more obstacles, given as Python objects.
///
/// # Errors
/// As [`entries::obstacle_entries`] and [`extricate::Scene::with_obstacles`].
pub fn with_obstacles(
    py: Python<'_>,
    scene: &extricate::Scene,
    obstacles: &Bound<'_, PyAny>,
) -> PyResult<extricate::Scene> {
    let given: Obstacles<'_> = obstacles.extract()?;
    let taken: Vec<String> = scene.bodies().iter().map(|body| body.name.clone()).collect();
    let entries = SceneFile { obstacle: entries::obstacle_entries(&given.0, taken)?, ..SceneFile::default() };
    let (bodies, told) = read(py, entries)?;
    let made = long_call::pooled(py, || scene.with_obstacles(bodies))?.map_err(exception)?.with_warnings(told);
    warn_of_new(py, scene, &made)?;
    Ok(made)
}

/// Reads obstacles and the files that they name; returns bodies and warnings.
fn read(py: Python<'_>, entries: SceneFile) -> PyResult<(Vec<Body>, Vec<String>)> {
    long_call::apart(py, move || read_obstacles(entries::NAME, &entries))?.map_err(exception)
}

/// Raises a `UserWarning` for each warning of `after` that `before` does not have.
///
/// # Errors
/// The warning, if warnings are errors.
pub fn warn_of_new(py: Python<'_>, before: &extricate::Scene, after: &extricate::Scene) -> PyResult<()> {
    let mut came = after.warnings().iter().filter(|warning| !before.warnings().contains(warning));
    came.try_for_each(|warning| warn(py, warning))
}

fn pose(element: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    crate::entries::pose::pose(element, value)?.pose(entries::NAME, element).map_err(exception)
}

#[pymethods]
impl Scene {
    /// Returns this scene with obstacles moved. It shares all other prepared data, so that the call
    /// costs only as much as what moved.
    ///
    /// poses: new pose by name of an obstacle: position (3,) [m], position and roll, pitch, yaw
    ///     (6,) [m, rad], or a transform (4, 4).
    ///
    /// Raises ValueError for names that no obstacle has.
    fn moved(&self, poses: &Bound<'_, PyMapping>) -> PyResult<Self> {
        let read = |item: Bound<'_, PyAny>| {
            let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let wrong = |_| PyTypeError::new_err(format!("poses: got the key {name}, expected names of obstacles"));
            let name: String = name.extract().map_err(wrong)?;
            let pose = pose(&format!("poses[\"{name}\"]"), &value)?;
            Ok((name, pose))
        };
        let poses = poses.items()?.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        let moved = self.inner().moved(poses.iter().map(|(name, pose)| (name.as_str(), *pose)));
        self.changed(moved.map_err(exception)?)
    }

    /// Returns this scene with more obstacles. It shares prepared data of the rest.
    ///
    /// obstacles: as in `Scene`.
    ///
    /// Raises ValueError for names that are taken, and for what `Scene` refuses.
    fn with_obstacles(&self, obstacles: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.changed(with_obstacles(obstacles.py(), self.inner(), obstacles)?)
    }

    /// Returns this scene without some obstacles or attached objects. It shares prepared data of
    /// the rest.
    ///
    /// names: names of obstacles and of attached objects.
    ///
    /// Raises ValueError for names that none of them has.
    fn without(&self, py: Python<'_>, names: Names) -> PyResult<Self> {
        let names = names.of("names")?;
        let rest = self.inner().without(names.iter().map(String::as_str));
        self.told(py, rest.map_err(exception)?)
    }

    /// Returns this scene with some pairs of bodies no longer checked. It shares prepared data.
    ///
    /// pairs: pairs of names of bodies; pairs that are not checked anyway stay so.
    ///
    /// Raises ValueError for names that no body has.
    fn disabled(&self, py: Python<'_>, pairs: Vec<[String; 2]>) -> PyResult<Self> {
        let pairs = pairs.iter().map(|[a, b]| [a.as_str(), b.as_str()]);
        self.told(py, self.inner().disabled(pairs).map_err(exception)?)
    }

    /// Returns this scene with an object that a link holds, such as a can in a gripper. The object
    /// moves with the link, and is checked against everything but `touch` and what is fixed to the
    /// link.
    ///
    /// shape: an obstacle as in `Scene`; its pose is in the link's coordinates.
    /// link: name of the link, which need not have geometry.
    /// pose: pose in the link's coordinates, in place of the shape's own.
    /// touch: names of links, obstacles and attached objects that it may touch.
    ///
    /// Raises ValueError for names that are taken or that nothing has.
    #[pyo3(signature = (shape, *, link, pose = None, touch = Names::default()), text_signature = "($self, shape, *, link, pose=None, touch=())")]
    fn attach(
        &self,
        shape: &Bound<'_, PyAny>,
        link: &str,
        pose: Option<&Bound<'_, PyAny>>,
        touch: Names,
    ) -> PyResult<Self> {
        let taken: Vec<String> = self.inner().bodies().iter().map(|body| body.name.clone()).collect();
        let mut entries = entries::obstacle_entries(std::slice::from_ref(shape), taken)?;
        if let Some(pose) = pose {
            entries[0].pose = crate::entries::pose::pose("pose", pose)?;
        }
        let entries = SceneFile { obstacle: entries, ..SceneFile::default() };
        let touch = touch.of("touch")?;
        let touch: Vec<&str> = touch.iter().map(String::as_str).collect();
        let (mut bodies, told) = read(shape.py(), entries)?;
        let attached = self.inner().attached(bodies.remove(0), link, &touch).map_err(exception)?;
        self.told(shape.py(), attached.with_warnings(told))
    }
}

impl Scene {
    /// Calls [`Scene::changed`], after a `UserWarning` for each new warning.
    ///
    /// # Errors
    /// As [`warn_of_new`].
    pub fn told(&self, py: Python<'_>, scene: extricate::Scene) -> PyResult<Self> {
        warn_of_new(py, self.inner(), &scene)?;
        self.changed(scene)
    }
}

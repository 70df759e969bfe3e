//! Scenes with something changed. Each is another one; what did not change is shared.

use extricate::geometry::{Body, Pose};
use extricate::internals::io;
use extricate::internals::scene::file::SceneFile;
use extricate::internals::scene::units;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use super::Scene;
use crate::entries::{self, Obstacles};
use crate::error::{exception, warn};

/// `scene` with more obstacles, as Python describes them.
///
/// # Errors
/// As [`entries::obstacle_entries`] and [`extricate::Scene::with_obstacles`].
pub fn with_obstacles(
    py: Python<'_>,
    scene: &extricate::Scene,
    obstacles: &Bound<'_, PyAny>,
) -> PyResult<extricate::Scene> {
    let given: Obstacles<'_> = obstacles.extract()?;
    let taken: Vec<String> = scene.bodies.iter().map(|body| body.name.clone()).collect();
    let entries = SceneFile { obstacle: entries::obstacle_entries(&given.0, taken)?, ..SceneFile::default() };
    let made = || scene.with_obstacles(io::read_obstacles(entries::NAME, &entries)?);
    let made = py.detach(made).map_err(exception)?;
    warn_of_sizes(py, &made, scene.bodies.len())?;
    Ok(made)
}

/// Raises a warning for each body that came and looks like one in millimetres.
fn warn_of_sizes(py: Python<'_>, scene: &extricate::Scene, before: usize) -> PyResult<()> {
    let mut warnings = Vec::new();
    units::warn_of_sizes(scene, &scene.bodies[before..], &mut warnings);
    warnings.iter().try_for_each(|warning| warn(py, warning))
}

fn pose(element: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    crate::entries::pose::pose(element, value)?.pose(entries::NAME, element).map_err(exception)
}

#[pymethods]
impl Scene {
    /// This scene with obstacles elsewhere; the rest of what is prepared is shared, so that it
    /// costs as much as what moved.
    ///
    /// poses: by name of an obstacle, where it stands now: position (3,) [m], position and roll,
    ///     pitch, yaw (6,) [m, rad], or a transform (4, 4).
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
        Ok(self.changed(moved.map_err(exception)?))
    }

    /// This scene with more obstacles; what is prepared of the rest is shared.
    ///
    /// obstacles: as `Scene` takes them.
    ///
    /// Raises ValueError for names that are taken, and what `Scene` refuses.
    fn with_obstacles(&self, obstacles: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(self.changed(with_obstacles(obstacles.py(), self.inner(), obstacles)?))
    }

    /// This scene without some obstacles, or objects that links hold; what is prepared of the rest
    /// is shared.
    ///
    /// names: of obstacles and of attached objects.
    ///
    /// Raises ValueError for names that none of them has.
    fn without(&self, names: Vec<String>) -> PyResult<Self> {
        let rest = self.inner().without(names.iter().map(String::as_str));
        Ok(self.changed(rest.map_err(exception)?))
    }

    /// This scene with some pairs of bodies no longer checked; what is prepared is shared.
    ///
    /// pairs: of names of bodies; pairs that are not checked anyway stay so.
    ///
    /// Raises ValueError for names that no body has.
    fn disabled(&self, pairs: Vec<[String; 2]>) -> PyResult<Self> {
        let pairs = pairs.iter().map(|[a, b]| [a.as_str(), b.as_str()]);
        Ok(self.changed(self.inner().disabled(pairs).map_err(exception)?))
    }

    /// This scene with an object that a link holds, such as a can in a gripper: it moves with the
    /// link, and is checked against everything but what is fixed to the link and `touch`.
    ///
    /// shape: as an obstacle of `Scene`; its pose is in the link's coordinates.
    /// link: its name; it need not have geometry.
    /// pose: in place of the shape's own, in the link's coordinates.
    /// touch: names of links, obstacles and attached objects that it may touch.
    ///
    /// Raises ValueError for names that are taken or that nothing has.
    #[pyo3(signature = (shape, *, link, pose = None, touch = Vec::new()), text_signature = "($self, shape, *, link, pose=None, touch=())")]
    fn attach(
        &self,
        shape: &Bound<'_, PyAny>,
        link: &str,
        pose: Option<&Bound<'_, PyAny>>,
        touch: Vec<String>,
    ) -> PyResult<Self> {
        let taken: Vec<String> = self.inner().bodies.iter().map(|body| body.name.clone()).collect();
        let mut entries = entries::obstacle_entries(std::slice::from_ref(shape), taken)?;
        if let Some(pose) = pose {
            entries[0].pose = crate::entries::pose::pose("pose", pose)?;
        }
        let entries = SceneFile { obstacle: entries, ..SceneFile::default() };
        let touch: Vec<&str> = touch.iter().map(String::as_str).collect();
        let attached = || {
            let mut bodies: Vec<Body> = io::read_obstacles(entries::NAME, &entries)?;
            self.inner().attached(bodies.remove(0), link, &touch)
        };
        let attached = shape.py().detach(attached).map_err(exception)?;
        warn_of_sizes(shape.py(), &attached, self.inner().bodies.len())?;
        Ok(self.changed(attached))
    }
}

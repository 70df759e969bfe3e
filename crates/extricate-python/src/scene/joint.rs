//! The class `Joint`, which describes the coordinates of a configuration.

use extricate::parts::SceneJoint;
use pyo3::prelude::*;

/// A joint, or the moving base of a robot, that has coordinates.
#[pyclass(frozen, get_all, module = "extricate._extricate")]
pub struct Joint {
    /// Name as in the URDF; `robot/joint` if two robots share a name.
    name: String,
    /// Type of the joint, as URDF spells it.
    kind: String,
    /// Index of its first coordinate in a configuration.
    start: usize,
    /// Index after its last coordinate.
    stop: usize,
}

impl Joint {
    pub fn of(joint: &SceneJoint) -> Self {
        let SceneJoint { name, kind, q } = joint.clone();
        Self { name, kind, start: q.start, stop: q.end }
    }
}

#[pymethods]
impl Joint {
    fn __repr__(&self) -> String {
        format!("Joint(name={:?}, kind={:?}, start={}, stop={})", self.name, self.kind, self.start, self.stop)
    }
}

//! The elements of a file that messages point to, and how their attributes are read.

use std::sync::Arc;

use roxmltree::Node;

use crate::error::{Error, Result};
use crate::math::{Pose, quaternion_matrix};
use crate::robot::TriangleMesh;
use crate::robot::formats::xml::{child, numbers, numbers_or, own_attribute, required};

/// The link or joint that messages point to.
pub struct ElementReader<'a> {
    pub file: &'a str,
    pub element: String,
}

impl ElementReader<'_> {
    pub fn error(&self, problem: impl Into<String>) -> Error {
        Error::input(self.file, &self.element, problem)
    }

    /// Returns the value of an attribute, or an error if it is missing.
    pub fn required<'n>(&self, node: Node<'n, '_>, name: &str) -> Result<&'n str> {
        required(self.file, &self.element, node, name)
    }

    /// Returns the `N` finite numbers of an attribute that has to exist.
    pub fn numbers<const N: usize>(&self, node: Node, name: &str) -> Result<[f64; N]> {
        numbers(self.file, &self.element, name, self.required(node, name)?)
    }

    /// As [`ElementReader::numbers`], but `default` if the attribute is missing.
    pub fn numbers_or<const N: usize>(&self, node: Option<Node>, name: &str, default: [f64; N]) -> Result<[f64; N]> {
        numbers_or(self.file, &self.element, node, name, default)
    }

    /// Returns the pose in the `<origin>` of a joint, or of a collision or visual element.
    pub fn origin(&self, parent: Node) -> Result<Pose> {
        let node = child(parent, "origin");
        let xyz = self.numbers_or(node, "xyz", [0.0; 3])?;
        let Some(value) = node.and_then(|node| own_attribute(node, "quat_xyzw")) else {
            return Ok(Pose::from_xyz_rpy(xyz, self.numbers_or(node, "rpy", [0.0; 3])?));
        };
        let quaternion = nalgebra::Vector4::from(numbers::<4>(self.file, &self.element, "quat_xyzw", value)?);
        let Some(unit) = quaternion.try_normalize(1e-9) else {
            return Err(self.error(format!("got quat_xyzw=\"{value}\", expected a quaternion that is not zero")));
        };
        Ok(Pose { rotation: quaternion_matrix(unit.as_slice()), translation: xyz.into() })
    }
}

/// Loads a mesh by the `filename` of a `<mesh>` element, and scales its axes.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str, [f64; 3]) -> Result<Arc<TriangleMesh>>;

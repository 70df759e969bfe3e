//! Where in a file messages point to, and attributes that are read there.

use std::sync::Arc;

use roxmltree::Node;

use crate::error::{Error, Result};
use crate::math::{Pose, quaternion_matrix};
use crate::robot::TriangleMesh;
use crate::robot::formats::xml::{child, numbers, numbers_or, own_attribute, required};

/// Where a message points to.
pub struct Place<'a> {
    /// Its name in messages.
    pub file: &'a str,
    /// The link or joint.
    pub element: String,
}

impl Place<'_> {
    /// An error of this place.
    pub fn error(&self, problem: impl Into<String>) -> Error {
        Error::input(self.file, &self.element, problem)
    }

    /// An attribute that must be there.
    pub fn required<'n>(&self, node: Node<'n, '_>, name: &str) -> Result<&'n str> {
        required(self.file, &self.element, node, name)
    }

    /// An attribute that must be there and hold `N` finite numbers.
    pub fn numbers<const N: usize>(&self, node: Node, name: &str) -> Result<[f64; N]> {
        numbers(self.file, &self.element, name, self.required(node, name)?)
    }

    /// As [`Place::numbers`]; `default` where the attribute is missing.
    pub fn numbers_or<const N: usize>(&self, node: Option<Node>, name: &str, default: [f64; N]) -> Result<[f64; N]> {
        numbers_or(self.file, &self.element, node, name, default)
    }

    /// The `<origin>` of a joint, or of a collision or visual element.
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

/// Loads an unscaled mesh by the `filename` attribute of a `<mesh>` element.
pub type LoadMesh<'a> = &'a mut dyn FnMut(&str, [f64; 3]) -> Result<Arc<TriangleMesh>>;

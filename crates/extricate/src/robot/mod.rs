//! A robot as its files describe it: links, joints and collision geometry. No configuration, no
//! world, no checks.

pub mod formats;
pub mod geometry;
pub mod load_limits;
pub mod mesh;
pub mod packages;
pub mod scenery;
mod sound;
pub mod srdf;
mod tree;
pub mod urdf;

pub use geometry::Geometry;
pub use load_limits::{LoadLimit, LoadLimits};
pub use mesh::TriangleMesh;
pub use mesh::moments::Moments;
pub use scenery::{HeightField, PointCloud, Voxels};

use crate::math::{Pose, Vec3};

/// A tree of links joined by joints, from one URDF file.
#[derive(Debug, Clone)]
pub struct Robot {
    /// The `name` attribute.
    pub name: String,
    /// In document order.
    pub links: Vec<Link>,
    /// In document order: the order of coordinates in a configuration.
    pub joints: Vec<Joint>,
    /// Index of the one link that no joint has as child.
    pub root: usize,
}

/// A rigid body and its collision geometry.
#[derive(Debug, Clone)]
pub struct Link {
    /// Unique within the robot.
    pub name: String,
    /// Every `<collision>` element, in the link's frame.
    pub collision: Vec<LinkGeometry>,
}

/// One `<collision>` element.
#[derive(Debug, Clone)]
pub struct LinkGeometry {
    /// Maps geometry coordinates to link coordinates.
    pub pose_link_geometry: Pose,
    /// The shape.
    pub geometry: Geometry,
}

/// What a joint lets its child link do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Nothing.
    Fixed,
    /// Turn about the axis within limits \[rad\].
    Revolute,
    /// Turn about the axis without limits.
    Continuous,
    /// Slide along the axis within limits \[m\].
    Prismatic,
    /// Slide in the plane normal to the axis, and turn about the axis. Coordinates: two \[m\], one
    /// angle \[rad\].
    Planar,
    /// Turn about any axis (the ball-joint extension of URDF). Coordinates: unit quaternion x, y,
    /// z, w.
    Spherical,
    /// Move freely. Coordinates: position x, y, z \[m\], unit quaternion x, y, z, w.
    Floating,
}

/// A joint between two links.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Unique within the robot.
    pub name: String,
    /// What it allows.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Maps child coordinates to parent coordinates at the zero position.
    pub pose_parent_joint: Pose,
    /// Unit axis in the joint's frame; for `Planar` the normal of the plane.
    pub axis: Vec3,
    /// Lower and upper limit \[rad or m\]; for `Planar` and `Floating` they hold for each
    /// translation.
    pub limits: Option<(f64, f64)>,
    /// Set where the joint follows another one.
    pub mimic: Option<Mimic>,
}

/// `position = multiplier * position(joint) + offset`.
#[derive(Debug, Clone, Copy)]
pub struct Mimic {
    /// Index of the joint that is followed.
    pub joint: usize,
    /// Factor.
    pub multiplier: f64,
    /// Offset \[rad or m\].
    pub offset: f64,
}

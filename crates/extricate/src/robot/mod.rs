//! Robots as their files describe them: links, joints and collision geometry, without
//! configurations, scenes and checks.

pub mod formats;
pub mod geometry;
mod link_tree;
pub mod load_limits;
pub mod mesh;
pub mod packages;
pub mod scenery;
mod sound;
pub mod srdf;
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
    /// Value of the `name` attribute, or `robot` if there is none.
    pub name: String,
    /// All links, in document order.
    pub links: Vec<Link>,
    /// All joints, in document order, which is the order of coordinates in a configuration.
    pub joints: Vec<Joint>,
    /// Index of the only link that is no joint's child.
    pub root: usize,
}

/// A rigid body and its collision geometry.
#[derive(Debug, Clone)]
pub struct Link {
    /// Unique within the robot.
    pub name: String,
    /// Shapes that collide, in the link's frame.
    pub collision: Vec<LinkGeometry>,
}

/// A shape of a link, from one `<collision>` or `<visual>` element.
#[derive(Debug, Clone)]
pub struct LinkGeometry {
    /// Maps geometry coordinates to link coordinates.
    pub pose_link_geometry: Pose,
    /// The shape in its own frame.
    pub geometry: Geometry,
    /// Red, green, blue and opacity, each from 0 to 1, of the material of a `<visual>` element.
    pub rgba: Option<[f64; 4]>,
}

/// The motion that a joint allows its child link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// No motion at all.
    Fixed,
    /// Rotation about the axis within limits \[rad\].
    Revolute,
    /// Rotation about the axis without limits.
    Continuous,
    /// Translation along the axis within limits \[m\].
    Prismatic,
    /// Translation in the plane normal to the axis, and rotation about the axis. Coordinates: two
    /// \[m\], one angle \[rad\].
    Planar,
    /// Rotation about any axis (the ball-joint extension of URDF). Coordinates: unit quaternion x,
    /// y, z, w.
    Spherical,
    /// Free motion. Coordinates: position x, y, z \[m\], unit quaternion x, y, z, w.
    Floating,
}

/// A joint between two links.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Unique within the robot.
    pub name: String,
    /// The motion that it allows.
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
    /// Set if the joint follows another one.
    pub mimic: Option<Mimic>,
}

/// Makes a joint follow another: `position = multiplier * position(joint) + offset`.
#[derive(Debug, Clone, Copy)]
pub struct Mimic {
    /// Index of the joint to follow.
    pub joint: usize,
    /// Factor on the position of the joint to follow.
    pub multiplier: f64,
    /// Offset of the position \[rad or m\].
    pub offset: f64,
}

//! The resolved scene: a kinematic tree of frames, the bodies on them, and the checked pairs.
//!
//! [`Scene`] holds everything that a query needs to know about the robot and its surroundings. It
//! is plain data without references to files, and model files store it whole. `kinematics` computes
//! positions at a configuration.

pub mod assemble;
pub mod builtin;
pub mod clearances;
pub mod correspondence;
pub mod drawing;
mod edit;
pub mod file;
#[cfg(feature = "moveit")]
pub mod import;
pub mod mesh_counts;
pub mod metric_kind;
pub mod named_configs;
mod names;
pub mod suspicious_units;

use serde::{Deserialize, Serialize};

use crate::cspace::ConfigSpace;
use crate::error::{Error, Result};
use crate::math::{Pose, Vec3};
use crate::robot::Geometry;
use clearances::{Clearances, PairClearance};
pub use metric_kind::MetricKind;

/// Robots, obstacles, checked pairs, clearance and metric.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Scene {
    /// Least distance \[m\] that a checked pair of a free configuration keeps, unless
    /// `clearances` holds another for it.
    pub(crate) clearance: f64,
    pub(crate) metric: MetricKind,
    /// One entry for each moving joint, in configuration order.
    pub(crate) joints: Vec<SceneJoint>,
    /// The configuration space that `joints` spans.
    pub(crate) space: ConfigSpace,
    /// Kinematic tree; `frames[0]` is the world, and a parent precedes its children.
    pub(crate) frames: Vec<Frame>,
    /// Links that have geometry, then obstacles, then objects attached to links. Bodies that are
    /// added later ([`Scene::with_obstacles`], [`Scene::attached`]) are at the end.
    pub(crate) bodies: Vec<Body>,
    /// Checked pairs in ascending order.
    pub(crate) pairs: Vec<BodyPair>,
    pub(crate) warnings: Vec<String>,
    /// Every link of every robot, with or without geometry.
    pub(crate) links: Vec<LinkAttachment>,
    pub(crate) clearances: Clearances,
    pub(crate) rigid: Vec<RigidJoint>,
}

/// A joint that does not move: it is fixed or locked, or follows one that is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigidJoint {
    /// Name as in the URDF, or `robot/joint` if two robots share it.
    pub name: String,
    /// Type of the joint as URDF spells it.
    pub kind: String,
    /// Position \[rad or m\]; 0 if the joint is fixed or has several coordinates.
    pub position: f64,
}

/// A link and its pose on a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinkAttachment {
    /// Name as in the URDF, or `robot/link` if two robots share it.
    pub name: String,
    /// Index of the frame that it is fixed to.
    pub frame: usize,
    /// Maps link coordinates to frame coordinates.
    pub pose_frame_link: Pose,
}

/// Identifies a checked pair within one scene; [`Scene::pair_names`] returns its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PairId(usize);

impl PairId {
    /// Identifies the pair at `index` of [`Scene::pairs`].
    pub fn new(index: usize) -> Self {
        Self(index)
    }

    /// Returns its index into [`Scene::pairs`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// A joint (or the base of a robot) that has coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneJoint {
    /// Name as in the URDF, or `base` for a base; `robot/joint` if two robots share the name.
    pub name: String,
    /// Type of the joint as URDF spells it.
    pub kind: String,
    /// Its coordinates in a configuration.
    pub q: std::ops::Range<usize>,
}

/// How a frame moves, as [`Frame::motion_record`] returns it. The position of a joint is `factor`
/// times coordinate `q`, plus `offset`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "motion", rename_all = "lowercase")]
#[non_exhaustive]
pub enum MotionRecord {
    /// The world, which does not move.
    World,
    /// A rotation \[rad\] about a fixed axis.
    Revolute {
        /// Unit axis in the joint's frame.
        axis: [f64; 3],
        /// Index of its coordinate in a configuration.
        q: usize,
        /// Factor of the coordinate; 1 except for mimic joints.
        factor: f64,
        /// Offset of the position \[rad\]; 0 except for mimic joints.
        offset: f64,
    },
    /// A translation \[m\] along a fixed axis.
    Prismatic {
        /// Unit axis in the joint's frame.
        axis: [f64; 3],
        /// Index of its coordinate in a configuration.
        q: usize,
        /// Factor of the coordinate; 1 except for mimic joints.
        factor: f64,
        /// Offset of the position \[m\]; 0 except for mimic joints.
        offset: f64,
    },
    /// A rotation by the unit quaternion x, y, z, w at four coordinates.
    Ball {
        /// Index of the first of the four coordinates.
        q: usize,
    },
}

/// A rigid frame, moved relative to its parent by one elementary joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Name of the joint that moves it; composite joints make several frames with one name.
    pub name: String,
    /// Index of the parent frame; 0 for the world itself.
    pub parent: usize,
    /// Maps joint coordinates (before the motion) to parent coordinates.
    pub pose_parent_joint: Pose,
    /// Its motion relative to the parent.
    #[doc(hidden)]
    pub motion: Motion,
}

impl Frame {
    /// Returns its motion relative to the parent.
    pub fn motion_record(&self) -> MotionRecord {
        match &self.motion {
            Motion::World => MotionRecord::World,
            Motion::Ball { q, .. } => MotionRecord::Ball { q: *q },
            Motion::Revolute { axis, coordinate: Coordinate { q, multiplier, offset, .. } } => {
                MotionRecord::Revolute { axis: (*axis).into(), q: *q, factor: *multiplier, offset: *offset }
            }
            Motion::Prismatic { axis, coordinate: Coordinate { q, multiplier, offset, .. } } => {
                MotionRecord::Prismatic { axis: (*axis).into(), q: *q, factor: *multiplier, offset: *offset }
            }
        }
    }
}

/// An elementary joint. A planar joint is two prismatic ones and a revolute one, a floating joint
/// three prismatic ones and a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// The world, which does not move.
    World,
    /// A rotation about `axis` by the coordinate \[rad\].
    Revolute {
        /// Unit axis in the joint's frame.
        axis: Vec3,
        /// Coordinate of the angle \[rad\].
        coordinate: Coordinate,
    },
    /// A translation along `axis` by the coordinate \[m\].
    Prismatic {
        /// Unit axis in the joint's frame.
        axis: Vec3,
        /// Coordinate of the length \[m\].
        coordinate: Coordinate,
    },
    /// A rotation by the unit quaternion at `q..q + 4`; its tangent (rotation vector in the body
    /// frame) is at `v..v + 3`.
    Ball {
        /// Index of the first of four coordinates: x, y, z, w.
        q: usize,
        /// Index of the first of three tangent coordinates.
        v: usize,
    },
}

/// `position = multiplier * config[q] + offset`; the multiplier and offset differ from 1 and 0 for
/// mimic joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coordinate {
    /// Index into a configuration.
    pub q: usize,
    /// Index into a tangent vector.
    pub v: usize,
    /// Factor of the configuration's coordinate.
    pub multiplier: f64,
    /// Offset of the position \[rad or m\].
    pub offset: f64,
}

/// A link, an obstacle, or an object attached to a link: shapes fixed to one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Name as in the URDF or scene file, or `robot/link` if two robots share it.
    pub name: String,
    /// Index of the robot whose link it is; `None` for an obstacle or an attached object.
    pub robot: Option<usize>,
    /// Index of the frame that it is fixed to; frame 0 does not move.
    pub frame: usize,
    /// Shapes that make up the body.
    pub parts: Vec<Part>,
}

/// One shape of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Maps shape coordinates to frame coordinates.
    pub pose_frame_part: Pose,
    /// The shape in its own coordinates.
    pub geometry: Geometry,
}

/// Two bodies that must keep the clearance; `first < second`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct BodyPair {
    /// Smaller index into [`Scene::bodies`].
    pub first: usize,
    /// Larger index into [`Scene::bodies`].
    pub second: usize,
}

impl Scene {
    /// Returns the clearance of every checked pair, in the order of `pairs`.
    pub(crate) fn pair_clearances(&self) -> Vec<PairClearance> {
        let bodies = self.index(|_| true);
        let named = |name: &str| bodies.get(name).copied();
        let mut padding = vec![0.0; self.bodies.len()];
        for (name, added) in &self.clearances.padding {
            named(name).into_iter().for_each(|body| padding[body] += added);
        }
        let of_pair = |pair: &BodyPair| {
            let is_of_world = [pair.first, pair.second].iter().any(|body| self.bodies[*body].is_obstacle());
            if is_of_world {
                return PairClearance { own: None, padding: padding[pair.first] + padding[pair.second] };
            }
            PairClearance { own: self.clearances.own, padding: 0.0 }
        };
        let mut all: Vec<PairClearance> = self.pairs.iter().map(of_pair).collect();
        for ([a, b], clearance) in &self.clearances.pairs {
            let (Some(a), Some(b)) = (named(a), named(b)) else { continue };
            let pair = BodyPair { first: a.min(b), second: a.max(b) };
            if let Ok(at) = self.pairs.binary_search(&pair) {
                all[at] = PairClearance { own: Some(*clearance), padding: 0.0 };
            }
        }
        all
    }

    /// Returns the names of a pair's bodies, in the order of the scene.
    pub fn pair_names(&self, pair: PairId) -> [&str; 2] {
        let BodyPair { first, second } = self.pairs[pair.index()];
        [&self.bodies[first].name, &self.bodies[second].name]
    }

    /// Returns the checked pair of two bodies with these names, in either order.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no such checked pair; the message calls the names `what`.
    pub fn pair_named(&self, what: &str, [a, b]: [&str; 2]) -> Result<PairId> {
        let is_meant = |pair: &PairId| [[a, b], [b, a]].contains(&self.pair_names(*pair));
        (0..self.pairs.len()).map(PairId::new).find(is_meant).ok_or_else(|| {
            let unknown = [a, b].into_iter().find(|name| self.bodies.iter().all(|body| body.name != **name));
            let bodies: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
            let unchecked = || format!("got `{a}` and `{b}`, expected two bodies of a checked pair");
            Error::input("query", what, unknown.map_or_else(unchecked, |name| names::unknown(name, &bodies)))
        })
    }

    /// Yields frame and shapes of every body that moves; metrics measure displacements of these.
    pub fn moving_bodies(&self) -> impl Iterator<Item = (usize, &[Part])> {
        self.bodies.iter().filter(|body| body.frame != 0).map(|body| (body.frame, &*body.parts))
    }

    /// Returns the indices of the joints with these names.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no joint has; the message calls the names `element`.
    pub fn joints_named<'a>(&self, element: &str, names: impl IntoIterator<Item = &'a str>) -> Result<Vec<usize>> {
        let find = |name: &str| {
            let found = self.joints.iter().position(|joint| joint.name == name);
            found.ok_or_else(|| {
                let all: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
                Error::input("query", element, names::unknown(name, &all))
            })
        };
        names.into_iter().map(find).collect()
    }

    /// Returns the index of the body with this name.
    ///
    /// # Errors
    /// [`Error::Input`] if no body has it; the message calls the name `element`.
    pub fn body_named(&self, element: &str, name: &str) -> Result<usize> {
        let found = self.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| {
            let all: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
            Error::input("scene", element, names::unknown(name, &all))
        })
    }

    /// Returns the index of the link with this name.
    ///
    /// # Errors
    /// [`Error::Input`] if no link has it; the message calls the name `element`.
    pub(crate) fn link_named(&self, element: &str, name: &str) -> Result<usize> {
        let found = self.links.iter().position(|link| link.name == name);
        found.ok_or_else(|| {
            let all: Vec<&str> = self.links.iter().map(|link| link.name.as_str()).collect();
            Error::input("query", element, names::unknown(name, &all))
        })
    }

    /// Returns the names of the joints that have any of these coordinates, each once.
    pub fn joints_of(&self, coordinates: &[usize]) -> Vec<&str> {
        let has_one = |joint: &&SceneJoint| coordinates.iter().any(|at| joint.q.contains(at));
        self.joints.iter().filter(has_one).map(|joint| joint.name.as_str()).collect()
    }
}

impl Scene {
    /// Returns whether both scenes are equal apart from their warnings.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let Self { clearance, metric, joints, space, frames, bodies, pairs, warnings: _, links, clearances, rigid } =
            self;
        (*clearance, *metric) == (other.clearance, other.metric)
            && (joints, space, frames) == (&other.joints, &other.space, &other.frames)
            && (pairs, links, clearances, rigid) == (&other.pairs, &other.links, &other.clearances, &other.rigid)
            && *bodies == other.bodies
    }

    /// Returns the clearance of one checked pair \[m\].
    pub fn clearance_of(&self, pair: PairId) -> f64 {
        self.pair_clearances()[pair.index()].over(self.clearance)
    }

    /// Returns the joints that do not move.
    pub fn rigid_joints(&self) -> &[RigidJoint] {
        &self.rigid
    }

    /// Returns the least distance \[m\] that a checked pair of a free configuration keeps, unless
    /// the pair has a clearance of its own.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Returns the metric that measures distances between configurations.
    pub fn metric(&self) -> MetricKind {
        self.metric
    }

    /// Returns one entry for each moving joint, in the order of coordinates.
    pub fn joints(&self) -> &[SceneJoint] {
        &self.joints
    }

    /// Returns the configuration space that the joints span.
    pub fn space(&self) -> &ConfigSpace {
        &self.space
    }

    /// Returns the kinematic tree: frame 0 is the world, and a parent precedes its children.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Returns links that have geometry, then obstacles, then objects attached to links. Bodies
    /// that were added later are at the end.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the checked pairs in ascending order.
    pub fn pairs(&self) -> &[BodyPair] {
        &self.pairs
    }

    /// Returns what the user should know, such as open meshes and defaults that were taken.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Returns every link of every robot, with or without geometry.
    pub fn links(&self) -> &[LinkAttachment] {
        &self.links
    }
}

#[cfg(test)]
mod testing;

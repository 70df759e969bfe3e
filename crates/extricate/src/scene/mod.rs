//! The resolved world: a kinematic tree of frames, bodies with geometry on them, and which pairs
//! are checked.
//!
//! Everything a query needs to know of the robot and its surroundings is in [`Scene`]; it is plain
//! data, free of files, and is stored whole in the model file. Not here: positions of anything at a
//! configuration (`kinematics`).

pub mod assemble;
pub mod builtin;
pub mod clearances;
pub mod correspondence;
pub mod drawing;
mod edit;
pub mod file;
pub mod import;
pub mod mesh_counts;
pub mod metric_kind;
pub mod named_configs;
mod names;
pub mod units;

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
    /// Least distance \[m\] that every checked pair of a free configuration keeps.
    pub(crate) clearance: f64,
    /// How far two configurations are from each other.
    pub(crate) metric: MetricKind,
    /// The coordinates: one entry per moving joint, in configuration order.
    pub(crate) joints: Vec<SceneJoint>,
    /// The configuration space that `joints` spans.
    pub(crate) space: ConfigSpace,
    /// Kinematic tree; `frames[0]` is the world, and a parent precedes its children.
    pub(crate) frames: Vec<Frame>,
    /// Links that have geometry, then obstacles, then objects attached to links; what came later
    /// ([`Scene::with_obstacles`], [`Scene::attached`]) at the end.
    pub(crate) bodies: Vec<Body>,
    /// Checked pairs, sorted.
    pub(crate) pairs: Vec<BodyPair>,
    /// What the user should know: open meshes, defaults taken, pairs that always collide.
    pub(crate) warnings: Vec<String>,
    /// Every link of every robot, those without geometry too.
    pub(crate) links: Vec<LinkAttachment>,
    /// Pairs that keep another distance than `clearance`.
    pub(crate) clearances: Clearances,
    /// Joints that do not move: fixed ones, and those that are locked.
    pub(crate) rigid: Vec<RigidJoint>,
}

/// A joint without coordinates that follows no other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigidJoint {
    /// As in the URDF; `robot/joint` where two robots share a name.
    pub name: String,
    /// What it would allow, as URDF spells it.
    pub kind: String,
    /// Where it stands \[rad or m\]; 0 where it is fixed, or has several coordinates.
    pub position: f64,
}

/// Where a link sits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinkAttachment {
    /// As in the URDF; `robot/link` where two robots share a name.
    pub name: String,
    /// Index of the frame that it is fixed to.
    pub frame: usize,
    /// Maps link coordinates to frame coordinates.
    pub pose_frame_link: Pose,
}

/// A checked pair of a scene, of that scene alone: [`Scene::pair_names`] has its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PairId(usize);

impl PairId {
    /// The pair at `index` of the scene's pairs.
    pub fn new(index: usize) -> Self {
        Self(index)
    }

    /// Its place among the scene's pairs.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A joint (or the base of a robot) that has coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneJoint {
    /// As in the URDF; `robot/joint` where two robots share a name; `base` or `robot/base` for a
    /// base.
    pub name: String,
    /// What it allows, as URDF spells it.
    pub kind: String,
    /// Its coordinates in a configuration.
    pub q: std::ops::Range<usize>,
}

/// How a frame moves, as [`Frame::motion_record`] says it. The position of a joint is `factor`
/// times coordinate `q`, plus `offset`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "motion", rename_all = "lowercase")]
#[non_exhaustive]
pub enum MotionRecord {
    /// The world, which does not move.
    World,
    /// A turn \[rad\] about a unit axis of the joint's frame.
    Revolute {
        /// The axis.
        axis: [f64; 3],
        /// The coordinate.
        q: usize,
        /// The factor.
        factor: f64,
        /// The offset \[rad\].
        offset: f64,
    },
    /// A slide \[m\] along a unit axis of the joint's frame.
    Prismatic {
        /// The axis.
        axis: [f64; 3],
        /// The coordinate.
        q: usize,
        /// The factor.
        factor: f64,
        /// The offset \[m\].
        offset: f64,
    },
    /// A turn by the unit quaternion x, y, z, w at four coordinates.
    Ball {
        /// The first of the four.
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
    /// How it moves.
    #[doc(hidden)]
    pub motion: Motion,
}

impl Frame {
    /// How it moves.
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

/// An elementary joint. Planar joints are two prismatic ones and a revolute one, floating ones
/// three prismatic and a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// The world, which does not move.
    World,
    /// Turn about `axis` (unit, joint frame) by the coordinate \[rad\].
    Revolute {
        /// Unit, in the joint's frame.
        axis: Vec3,
        /// The angle \[rad\].
        coordinate: Coordinate,
    },
    /// Slide along `axis` (unit, joint frame) by the coordinate \[m\].
    Prismatic {
        /// Unit, in the joint's frame.
        axis: Vec3,
        /// The length \[m\].
        coordinate: Coordinate,
    },
    /// Turn by the unit quaternion at `q..q + 4`; its tangent (body frame rotation vector) is at
    /// `v..v + 3`.
    Ball {
        /// First of four coordinates: x, y, z, w.
        q: usize,
        /// First of three tangent coordinates.
        v: usize,
    },
}

/// `position = multiplier * config[q] + offset`; the factor and offset differ from 1 and 0 for
/// mimic joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coordinate {
    /// Index into a configuration.
    pub q: usize,
    /// Index into a tangent vector.
    pub v: usize,
    /// Factor.
    pub multiplier: f64,
    /// \[rad or m\]
    pub offset: f64,
}

/// A link, an obstacle, or an object attached to a link: shapes fixed to one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// As in the URDF or scene file; `robot/link` where two robots share a name.
    pub name: String,
    /// Which robot it belongs to; `None` for an obstacle or an object attached to a link.
    pub robot: Option<usize>,
    /// Index of the frame that it is fixed to; 0 does not move.
    pub frame: usize,
    /// Its shapes.
    pub parts: Vec<Part>,
}

/// One shape of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Maps shape coordinates to frame coordinates.
    pub pose_frame_part: Pose,
    /// The shape.
    pub geometry: Geometry,
}

/// Two bodies that must keep the clearance; `first < second`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct BodyPair {
    /// Index into [`Scene::bodies`].
    pub first: usize,
    /// Index into [`Scene::bodies`].
    pub second: usize,
}

impl Scene {
    /// What every checked pair keeps, in order.
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

    /// Names of a checked pair, in the order of the scene.
    pub fn pair_names(&self, pair: PairId) -> [&str; 2] {
        let BodyPair { first, second } = self.pairs[pair.index()];
        [&self.bodies[first].name, &self.bodies[second].name]
    }

    /// Frames and shapes of the bodies that move, which distances are measured by.
    pub fn moving_bodies(&self) -> impl Iterator<Item = (usize, &[Part])> {
        self.bodies.iter().filter(|body| body.frame != 0).map(|body| (body.frame, &*body.parts))
    }

    /// Indices of the joints of these names.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no joint has; `element` is what messages call the names.
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

    /// Index of the body of that name.
    ///
    /// # Errors
    /// [`Error::Input`] where no body has it; `element` is what messages call the name.
    pub fn body_named(&self, element: &str, name: &str) -> Result<usize> {
        let found = self.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| {
            let all: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
            Error::input("scene", element, names::unknown(name, &all))
        })
    }

    /// Names of the joints that have any of these coordinates, each once.
    pub fn joints_of(&self, coordinates: &[usize]) -> Vec<&str> {
        let has_one = |joint: &&SceneJoint| coordinates.iter().any(|at| joint.q.contains(at));
        self.joints.iter().filter(has_one).map(|joint| joint.name.as_str()).collect()
    }
}

impl Scene {
    /// Whether another scene is the same but for its warnings.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let Self { clearance, metric, joints, space, frames, bodies, pairs, warnings: _, links, clearances, rigid } =
            self;
        (*clearance, *metric) == (other.clearance, other.metric)
            && (joints, space, frames) == (&other.joints, &other.space, &other.frames)
            && (pairs, links, clearances, rigid) == (&other.pairs, &other.links, &other.clearances, &other.rigid)
            && *bodies == other.bodies
    }

    /// What a checked pair keeps \[m\].
    pub fn clearance_of(&self, pair: PairId) -> f64 {
        self.pair_clearances()[pair.index()].over(self.clearance)
    }

    /// Joints that do not move: fixed ones, and those that are locked.
    pub fn rigid_joints(&self) -> &[RigidJoint] {
        &self.rigid
    }

    /// The least distance \[m\] that every checked pair of a free configuration keeps, but for
    /// pairs that have their own.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// How far two configurations are from each other.
    pub fn metric(&self) -> MetricKind {
        self.metric
    }

    /// One entry for each moving joint, in the order of coordinates.
    pub fn joints(&self) -> &[SceneJoint] {
        &self.joints
    }

    /// The configuration space that the joints span.
    pub fn space(&self) -> &ConfigSpace {
        &self.space
    }

    /// The kinematic tree: the first frame is the world, and a parent precedes its children.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Links that have geometry, then obstacles, then objects attached to links; what came later is
    /// at the end.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The checked pairs, sorted.
    pub fn pairs(&self) -> &[BodyPair] {
        &self.pairs
    }

    /// What the user should know: open meshes, defaults taken, pairs that always collide.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Every link of every robot, those without geometry too.
    pub fn links(&self) -> &[LinkAttachment] {
        &self.links
    }
}

#[cfg(test)]
mod testing;

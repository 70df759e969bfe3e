//! Links that a query keeps in place: where they may be, and how far off they are.
//!
//! A kept link is an equality between poses up to a tolerance. Descents move along the
//! configurations that keep it: their programs have a row for each kept coordinate
//! ([`super::descent::subproblem`]), and each configuration that they reach is projected back
//! (`project`). Lower bounds ignore it, which only loosens them.

mod edge;
mod project;
mod read;
mod rows;

pub use edge::{EdgeScratch, keeps_edge};
pub use project::Projection;
pub use rows::{KeptRows, Span};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::interface::setters;
use crate::kinematics::forward;
use crate::math::{Mat3, Pose, Vec3, elementary};
use crate::scene::Scene;

/// Usual tolerances of a kept link \[m\] and \[rad\].
const POSITION_M: f64 = 1e-4;
const ROTATION_RAD: f64 = 1e-3;
/// No tolerance is less \[m\] or \[rad\]: poses are not more accurate.
const LEAST_TOLERANCE: f64 = 1e-9;
/// Largest deviation of a rotation from an orthonormal matrix.
const RIGID_TOLERANCE: f64 = 1e-5;
/// Searches aim at this share of a tolerance, so that rounding does not matter.
const AIM_SHARE: f64 = 0.9;

/// Share of a small tolerance that is left to points, so that edges between them may bend by the
/// rest.
const NARROW_SHARE: f64 = 0.1;
/// Most that edges may bend \[m\] and \[rad\]: with this much they are some 0.2 rad long.
const ROOM_M: f64 = 5e-3;
const ROOM_RAD: f64 = 5e-2;

/// A link that a query keeps in place ([`super::QueryOptions::keep`]): where it is at the query, or
/// at a given pose.
///
/// Several links may be kept, and a link may be kept relative to another one: two hands on a box,
/// or a closed chain.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KeptLink {
    /// The link, as an index into [`Scene::links`].
    pub link: usize,
    /// The link whose frame `pose` is in, as an index into [`Scene::links`]; `None` for the world.
    pub relative_to: Option<usize>,
    /// Pose of the link; `None` for its pose at the query.
    pub pose: Option<Pose>,
    /// Most that the link's origin may be off \[m\], at least 1e-9; `None` if it may be anywhere.
    pub position: Option<f64>,
    /// Most that the link may be rotated \[rad\], at least 1e-9; `None` if it may rotate freely.
    pub rotation: Option<f64>,
    /// An axis of the link, in its coordinates, not zero. Then `rotation` limits the angle of this
    /// axis alone, and the link may rotate about it.
    pub axis: Option<[f64; 3]>,
}

setters! {
    KeptLink {
        relative_to: usize = Some,
        pose: Pose = Some,
        position: Option<f64>,
        rotation: Option<f64>,
        axis: [f64; 3] = Some,
    }
}

impl KeptLink {
    /// Keeps a link (an index into [`Scene::links`]) where it is at the query, to 1e-4 m and 1e-3
    /// rad.
    pub fn link(link: usize) -> Self {
        let (position, rotation) = (Some(POSITION_M), Some(ROTATION_RAD));
        Self { link, relative_to: None, pose: None, position, rotation, axis: None }
    }

    /// Checks that the tolerances and the axis make sense.
    ///
    /// # Errors
    /// [`Error::Option`], which names the value and what was expected.
    pub(super) fn check(&self) -> Result<()> {
        let refuse =
            |value: String, expected: &str| Err(Error::Option { name: "keep", value, expected: expected.into() });
        let is_tolerance = |tolerance: &f64| (LEAST_TOLERANCE..=1e9).contains(tolerance);
        if let Some(bad) = self.position.filter(|tolerance| !is_tolerance(tolerance)) {
            return refuse(format!("position {bad}"), "a position tolerance of 1e-9 to 1e9 [m]");
        }
        if let Some(bad) = self.rotation.filter(|tolerance| !is_tolerance(tolerance)) {
            return refuse(format!("rotation {bad}"), "a rotation tolerance of 1e-9 to 1e9 [rad]");
        }
        if self.position.is_none() && self.rotation.is_none() {
            return refuse("neither position nor rotation".into(), "a tolerance for at least one of them");
        }
        if let Some(bad) = self.axis.filter(|axis| !Vec3::from(*axis).norm().is_normal()) {
            return refuse(format!("axis {bad:?}"), "three finite numbers, not all 0");
        }
        if self.pose.is_some_and(|pose| !is_rigid(&pose)) {
            return refuse("a pose".into(), "finite numbers, and a rotation");
        }
        match self.axis {
            Some(axis) if self.rotation.is_none() => {
                refuse(format!("axis {axis:?} without rotation"), "a rotation tolerance for the axis")
            }
            _ => Ok(()),
        }
    }

    /// Checks a link that a motion in `scene` keeps.
    ///
    /// # Errors
    /// [`Error::Option`] if a value makes no sense, or a link is not in the scene.
    pub(crate) fn check_in(&self, scene: &Scene) -> Result<()> {
        self.check().and_then(|()| self.check_links(scene))
    }

    /// Checks that the links are in `scene`.
    ///
    /// # Errors
    /// [`Error::Option`] if one is not.
    pub(crate) fn check_links(&self, scene: &Scene) -> Result<()> {
        let count = scene.links.len();
        match [Some(self.link), self.relative_to].into_iter().flatten().find(|link| *link >= count) {
            Some(bad) => {
                let expected = format!("indices below the {count} links");
                Err(Error::Option { name: "keep", value: format!("link {bad}"), expected })
            }
            None => Ok(()),
        }
    }
}

/// How far a kept link is off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct KeptError {
    /// Distance of the link's origin from its place \[m\].
    pub position: f64,
    /// Angle of the link, or of its kept axis, from its orientation \[rad\].
    pub rotation: f64,
}

/// A kept link of one query.
#[derive(Debug, Clone)]
pub struct LinkConstraint {
    /// The frames of the link and of the link that its pose is relative to, and the links' poses on
    /// them.
    link: (usize, Pose),
    base: (usize, Pose),
    /// Pose to keep, in the base's coordinates.
    target: Pose,
    position: Option<f64>,
    rotation: Option<f64>,
    axis: Option<Vec3>,
}

/// Offset of a kept link from its place, in the base's coordinates.
struct Offset {
    base: Pose,
    /// The link's origin in the world.
    origin: Vec3,
    position: Vec3,
    /// A rotation vector \[rad\].
    rotation: Vec3,
}

impl LinkConstraint {
    /// Resolves what a query at `q` keeps.
    pub fn all(scene: &Scene, keep: &[KeptLink], q: &[f64]) -> Vec<Self> {
        if keep.is_empty() {
            return Vec::new();
        }
        let mut poses = Vec::new();
        forward(scene, q, &mut poses);
        let resolve = |keep: &KeptLink| {
            let placed = |link: usize| (scene.links[link].frame, scene.links[link].pose_frame_link);
            let (link, base) = (placed(keep.link), keep.relative_to.map_or((0, Pose::identity()), placed));
            let now = world(&base, &poses).inverse().then(&world(&link, &poses));
            Self {
                target: keep.pose.unwrap_or(now),
                position: keep.position,
                rotation: keep.rotation,
                axis: keep.axis.map(|axis| Vec3::from(axis).normalize()),
                link,
                base,
            }
        };
        keep.iter().map(resolve).collect()
    }

    /// Resolves what a motion keeps: its links are where they are at the first of these
    /// configurations, or at given poses.
    ///
    /// # Errors
    /// [`Error::Option`] if a kept link makes no sense; [`Error::Config`] if one is off at a
    /// configuration, which is named.
    pub fn kept_at(scene: &Scene, keep: &[KeptLink], ends: &[(&str, &[f64])]) -> Result<Vec<Self>> {
        keep.iter().try_for_each(|link| link.check_in(scene))?;
        let kept = Self::all(scene, keep, ends[0].1);
        let mut poses = Vec::new();
        for (name, q) in ends {
            forward(scene, q, &mut poses);
            if let Some(off) = kept.iter().position(|link| link.excess(&poses) > 1.0) {
                let KeptError { position, rotation } = kept[off].error(&poses);
                return Err(Error::Config {
                    element: format!("{name}: kept link `{}`", scene.links[keep[off].link].name),
                    value: format!("off by {position:.1e} m and {rotation:.1e} rad"),
                    expected: "at its place, within the tolerances of `keep`".into(),
                });
            }
        }
        Ok(kept)
    }

    /// Returns the same constraint with narrower tolerances, which leave room for edges to bend:
    /// nine tenths of a tolerance, or what edges of usual lengths need if that is less.
    pub fn narrowed(&self) -> Self {
        let narrow = |tolerance: Option<f64>, room: f64| tolerance.map(|most| (NARROW_SHARE * most).max(most - room));
        let (position, rotation) = (narrow(self.position, ROOM_M), narrow(self.rotation, ROOM_RAD));
        Self { position, rotation, ..self.clone() }
    }

    fn offset(&self, poses: &[Pose]) -> Offset {
        let (base, link) = (world(&self.base, poses), world(&self.link, poses));
        let now = base.inverse().then(&link);
        let rotation = match self.axis {
            None => rotation_vector(&(now.rotation * self.target.rotation.transpose())),
            Some(axis) => between(&(self.target.rotation * axis), &(now.rotation * axis)),
        };
        Offset { origin: link.translation, position: now.translation - self.target.translation, rotation, base }
    }

    /// Returns how far the link is off at the configuration of these poses.
    pub fn error(&self, poses: &[Pose]) -> KeptError {
        let offset = self.offset(poses);
        KeptError { position: offset.position.norm(), rotation: offset.rotation.norm() }
    }

    /// Returns the larger of both errors as a multiple of its tolerance: at most 1 if the link is
    /// kept.
    pub fn excess(&self, poses: &[Pose]) -> f64 {
        let KeptError { position, rotation } = self.error(poses);
        // Where a pose is not a number, the link is not kept.
        let share = |error: f64, tolerance: Option<f64>| {
            tolerance.map_or(0.0, |tolerance| if error.is_finite() { error / tolerance } else { f64::INFINITY })
        };
        share(position, self.position).max(share(rotation, self.rotation))
    }
}

/// Whether a pose is made of finite numbers and a rotation.
fn is_rigid(pose: &Pose) -> bool {
    let off = (pose.rotation.transpose() * pose.rotation - Mat3::identity()).abs().max();
    off <= RIGID_TOLERANCE && pose.rotation.determinant() > 0.0 && pose.translation.iter().all(|x| x.is_finite())
}

fn world((frame, pose): &(usize, Pose), poses: &[Pose]) -> Pose {
    poses[*frame].then(pose)
}

/// Returns the rotation vector \[rad\] of a rotation matrix.
fn rotation_vector(rotation: &Mat3) -> Vec3 {
    let m = rotation;
    let sine = Vec3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]) * 0.5;
    let (length, cosine) = (sine.norm(), 0.5 * (m.trace() - 1.0));
    let angle = elementary::atan2(length, cosine);
    if length > 1e-9 {
        return sine * (angle / length);
    }
    if cosine > 0.0 {
        return sine;
    }
    // Half a turn: the columns of `m + 1` are along the axis.
    let sum = m + Mat3::identity();
    let column = (0..3).map(|k| sum.column(k).into_owned()).max_by(|a, b| a.norm().total_cmp(&b.norm()));
    column.map_or(Vec3::zeros(), |axis| axis.normalize() * angle)
}

/// Returns the rotation vector \[rad\] that turns the unit vector `from` to `to` the shortest way.
fn between(from: &Vec3, to: &Vec3) -> Vec3 {
    let cross = from.cross(to);
    let (length, cosine) = (cross.norm(), from.dot(to));
    if length > 1e-9 {
        return cross * (elementary::atan2(length, cosine) / length);
    }
    if cosine > 0.0 { cross } else { perpendicular(from) * std::f64::consts::PI }
}

/// Returns a unit vector that is perpendicular to a unit vector.
fn perpendicular(axis: &Vec3) -> Vec3 {
    let least = (0..3).min_by(|a, b| axis[*a].abs().total_cmp(&axis[*b].abs())).unwrap_or(0);
    axis.cross(&Vec3::ith(least, 1.0)).normalize()
}

#[cfg(test)]
mod tests;

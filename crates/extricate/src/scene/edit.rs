//! Changes to a scene: obstacles, attached objects, disabled pairs, clearance, metric and weights.
//! Robots and coordinates stay.
//!
//! Every function returns another scene, which shares geometry with this one. Warnings about bodies
//! that were removed are dropped, and warnings about added ones are new.
//! [`crate::Solver::with_scene`] shares the prepared data, too.

use std::collections::{HashMap, HashSet};

use super::assemble::NOTHING_CHECKED;
use super::assemble::bodies::{OncePerMesh, refuse_vast, warn_of_surfaces};
use super::names::{check_name, unknown};
use super::suspicious_units::warn_of_sizes;
use super::{Body, BodyPair, LinkAttachment, MetricKind, Part, Scene};
use crate::cspace::{ConfigSpace, Factor};
use crate::error::{Error, Result, bounded, quoted};
use crate::math::{FARTHEST, Pose};
use crate::robot::Geometry;

/// Name that error messages give in place of a file.
const SCENE: &str = "scene";

impl Body {
    /// Creates an obstacle of one shape; `pose` maps shape coordinates to world coordinates.
    pub fn obstacle(name: impl Into<String>, geometry: Geometry, pose: Pose) -> Self {
        Self { name: name.into(), robot: None, frame: 0, parts: vec![Part { pose_frame_part: pose, geometry }] }
    }

    /// Attaches this body, whose parts are in link coordinates, to the frame of a link.
    pub(super) fn on(mut self, seat: &LinkAttachment) -> Self {
        let place = |part: &mut Part| part.pose_frame_part = seat.pose_frame_link.then(&part.pose_frame_part);
        self.parts.iter_mut().for_each(place);
        Self { robot: None, frame: seat.frame, ..self }
    }

    /// Returns whether it is fixed to the world and no link of a robot.
    pub fn is_obstacle(&self) -> bool {
        self.robot.is_none() && self.frame == 0
    }
}

impl Scene {
    /// Returns this scene with the named obstacles moved. A pose maps the coordinates of the
    /// obstacle's first shape to world coordinates; its other shapes move with the first.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no obstacle has, and for a pose without a rotation matrix
    /// or beyond 1e9 m.
    pub fn moved<'a>(&self, poses: impl IntoIterator<Item = (&'a str, Pose)>) -> Result<Self> {
        let mut scene = self.clone();
        let obstacles = self.index(Body::is_obstacle);
        for (name, pose) in poses {
            let element = format!("obstacle \"{}\"", quoted(name));
            check_pose(&element, &pose)?;
            let body = found(&obstacles, name, &element)?;
            let Some(first) = self.bodies[body].parts.first() else { continue };
            let by = pose.then(&first.pose_frame_part.inverse());
            for (at, part) in scene.bodies[body].parts.iter_mut().enumerate() {
                part.pose_frame_part = if at == 0 { pose } else { by.then(&part.pose_frame_part) };
            }
        }
        Ok(scene)
    }

    /// Returns this scene with another metric.
    pub fn with_metric(&self, metric: MetricKind) -> Self {
        Self { metric, ..self.clone() }
    }

    /// Returns this scene with another clearance \[m\]; pairs with one of their own keep that.
    ///
    /// # Errors
    /// [`Error::Input`] for a clearance that is not within 0 to 1e9.
    pub fn with_clearance(&self, clearance: f64) -> Result<Self> {
        if !(0.0..=1e9).contains(&clearance) {
            return Err(Error::input(SCENE, "clearance", format!("got {clearance}, expected 0 to 1e9 [m]")));
        }
        Ok(Self { clearance, ..self.clone() })
    }

    /// Returns this scene with more obstacles, see [`Body::obstacle`]. Every body that moves is
    /// checked against them.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that is empty, not printable or taken, for an invalid pose, and
    /// for a radius over 1e5 m.
    pub fn with_obstacles(&self, obstacles: impl IntoIterator<Item = Body>) -> Result<Self> {
        let mut scene = self.clone();
        let links = self.links.iter().map(|link| link.name.clone());
        let mut taken: HashSet<String> = self.bodies.iter().map(|body| body.name.clone()).chain(links).collect();
        // Obstacles are not checked against each other, so only pairs with moving bodies are added.
        let moving: Vec<usize> = (0..self.bodies.len()).filter(|&body| self.bodies[body].frame != 0).collect();
        for obstacle in obstacles {
            let element = format!("obstacle \"{}\"", quoted(&obstacle.name));
            if !taken.insert(obstacle.name.clone()) {
                return Err(Error::input(SCENE, element, "the name is taken, expected one of its own"));
            }
            scene.push_among(&moving, Body { robot: None, frame: 0, ..obstacle }, &element)?;
        }
        scene.pairs.sort_unstable();
        Ok(scene.telling(self.bodies.len()))
    }

    /// Returns this scene without the obstacles or attached objects of these names.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no obstacle or attached object has.
    pub fn without<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<Self> {
        let mut goes = vec![false; self.bodies.len()];
        let others = self.index(|body| body.robot.is_none());
        for name in names {
            goes[found(&others, name, &format!("obstacle \"{}\"", quoted(name)))?] = true;
        }
        let mut places = Vec::with_capacity(goes.len());
        let mut next = 0;
        for goes in &goes {
            places.push((!goes).then_some(next));
            next += usize::from(!goes);
        }
        let stays = |pair: &BodyPair| Some(BodyPair { first: places[pair.first]?, second: places[pair.second]? });
        let bodies: Vec<Body> =
            self.bodies.iter().zip(&goes).filter(|(_, goes)| !**goes).map(|(body, _)| body.clone()).collect();
        let pairs = self.pairs.iter().filter_map(stays).collect();
        let mut warnings = self.warnings.clone();
        warnings.retain(|warning| body_told(warning).is_none_or(|name| others.get(name).is_none_or(|at| !goes[*at])));
        let came = bodies.len();
        Ok(Self { bodies, pairs, warnings, ..self.clone() }.telling(came))
    }

    /// Returns this scene without its obstacles; attached objects stay.
    pub fn without_obstacles(&self) -> Self {
        let names = self.bodies.iter().filter(|body| body.is_obstacle()).map(|body| body.name.as_str());
        self.without(names).expect("obstacles of this scene")
    }

    /// Returns this scene with these pairs of bodies no longer checked.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no body and no link has.
    pub fn disabled<'a>(&self, pairs: impl IntoIterator<Item = [&'a str; 2]>) -> Result<Self> {
        let bodies = self.index(|_| true);
        let mut disabled = HashSet::new();
        for [a, b] in pairs {
            let element = || format!("pair [\"{}\", \"{}\"]", quoted(a), quoted(b));
            let body = |name: &str| self.body_or_link(&bodies, name, element);
            let (Some(a), Some(b)) = (body(a)?, body(b)?) else { continue };
            disabled.insert(BodyPair { first: a.min(b), second: a.max(b) });
        }
        let mut scene = self.clone();
        scene.pairs.retain(|pair| !disabled.contains(pair));
        Ok(scene.telling(self.bodies.len()))
    }

    /// Returns this scene with other weights of squared displacements in the joint metric, by
    /// joint as `[translation, rotation]`. A joint with one coordinate takes the second; joints
    /// that are not named keep their weights.
    ///
    /// # Errors
    /// [`Error::Input`] if the scene has another metric, for a name that no joint has, and for
    /// weights that are not within 1e-9 to 1e9.
    pub fn weighted<'a>(&self, weights: impl IntoIterator<Item = (&'a str, [f64; 2])>) -> Result<Self> {
        let element = "metric: weights";
        if self.metric != MetricKind::Joint {
            let problem = format!("got some with the metric {:?}, only that of the joints has them", self.metric);
            return Err(Error::input(SCENE, element, problem));
        }
        let mut of_factors: Vec<f64> = self.space.factors().iter().map(|factor| factor.weight).collect();
        for (name, [translation, rotation]) in weights {
            let Some(joint) = self.joints.iter().find(|joint| joint.name == name) else {
                let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
                return Err(Error::input(SCENE, element, unknown(name, &names)));
            };
            if let Some(bad) = [translation, rotation].iter().find(|weight| !(1e-9..=1e9).contains(*weight)) {
                let problem = format!("`{name}`: got {bad:?}, expected a number from 1e-9 to 1e9");
                return Err(Error::input(SCENE, element, problem));
            }
            let of_joint = |factor: &Factor| joint.q.contains(&factor.q);
            let factors = self.space.factors();
            let own: Vec<usize> = (0..factors.len()).filter(|at| of_joint(&factors[*at])).collect();
            own.iter().for_each(|at| of_factors[*at] = translation);
            own.last().into_iter().for_each(|last| of_factors[*last] = rotation);
        }
        let mut space = ConfigSpace::default();
        for (factor, weight) in self.space.factors().iter().zip(of_factors) {
            space.push(factor.name.clone(), factor.manifold, weight);
        }
        Ok(Self { space, ..self.clone() })
    }

    /// Returns this scene with an object that a link holds, such as a can in a gripper. The pose of
    /// `object` ([`Body::obstacle`]) is in the link's coordinates. The object moves with the link
    /// and is checked against all bodies except those on the link's frame and those in `touch`.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that is taken or unknown, an invalid pose, a shape of large
    /// worlds, and a radius over 1e5 m.
    pub fn attached(&self, object: Body, link: &str, touch: &[&str]) -> Result<Self> {
        self.attached_all([(object, link, touch.to_vec())], usize::MAX)
    }

    /// As [`Scene::attached`] for many objects; stops once there are more than `most_pairs` pairs.
    pub(super) fn attached_all<'a>(
        &self,
        objects: impl IntoIterator<Item = (Body, &'a str, Vec<&'a str>)>,
        most_pairs: usize,
    ) -> Result<Self> {
        let mut scene = self.clone();
        let mut bodies: HashMap<String, usize> =
            self.bodies.iter().enumerate().rev().map(|(index, body)| (body.name.clone(), index)).collect();
        let seats: HashMap<&str, &LinkAttachment> =
            self.links.iter().rev().map(|seat| (seat.name.as_str(), seat)).collect();
        for (object, link, touch) in objects {
            let element = format!("attached \"{}\"", quoted(&object.name));
            let fault = |problem: String| Err(Error::input(SCENE, &element, problem));
            if bodies.contains_key(&object.name) || seats.contains_key(object.name.as_str()) {
                return fault("the name is taken, expected one of its own".into());
            }
            if object.parts.iter().any(|part| part.geometry.is_scenery()) {
                return fault("shape: got a shape of large worlds, expected one that a link can hold".into());
            }
            let Some(seat) = seats.get(link) else {
                if self.links.is_empty() {
                    return fault("this model was written by a version that kept no links: learn it anew".into());
                }
                let names: Vec<&str> = self.links.iter().map(|seat| seat.name.as_str()).collect();
                return fault(format!("link: {}", unknown(link, &names)));
            };
            let mut touched = HashSet::new();
            for name in touch {
                match bodies.get(name) {
                    Some(&body) => drop(touched.insert(body)),
                    None if seats.contains_key(name) => {}
                    None => {
                        let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
                        return Err(Error::input(SCENE, format!("{element}: touch"), unknown(name, &names)));
                    }
                }
            }
            bodies.insert(object.name.clone(), scene.bodies.len());
            scene.push(object.on(seat), &element, &touched)?;
            if scene.pairs.len() > most_pairs {
                break;
            }
        }
        scene.pairs.sort_unstable();
        Ok(scene.telling(self.bodies.len()))
    }

    /// Returns this scene with more warnings, such as those of [`crate::entries::read_obstacles`]
    /// about the files that it reads.
    pub fn with_warnings(mut self, told: impl IntoIterator<Item = String>) -> Self {
        self.warnings.extend(told);
        Self { warnings: bounded(self.warnings), ..self }
    }

    /// Adds warnings about new bodies, from index `first` on, and about a lack of checked pairs.
    pub(super) fn telling(mut self, first: usize) -> Self {
        let mut warnings = std::mem::take(&mut self.warnings);
        let (came, mut known) = (&self.bodies[first..], OncePerMesh::default());
        came.iter().for_each(|body| warn_of_surfaces(body, &mut known, &mut warnings));
        if !came.is_empty() {
            warn_of_sizes(&self, came, &mut warnings);
        }
        // The scene before the change may have left this warning.
        warnings.retain(|warning| warning != NOTHING_CHECKED);
        if self.pairs.is_empty() {
            warnings.push(NOTHING_CHECKED.into());
        }
        Self { warnings: bounded(warnings), ..self }
    }

    /// Adds a body and its pairs with all bodies on other frames, except those in `touch`.
    fn push(&mut self, body: Body, element: &str, touch: &HashSet<usize>) -> Result<()> {
        let meets = |first: &usize| self.bodies[*first].frame != body.frame && !touch.contains(first);
        let others: Vec<usize> = (0..self.bodies.len()).filter(meets).collect();
        self.push_among(&others, body, element)
    }

    /// Adds a body and its pairs with `others`.
    fn push_among(&mut self, others: &[usize], body: Body, element: &str) -> Result<()> {
        check_name(&body.name).map_err(|problem| Error::input(SCENE, element, problem))?;
        body.parts.iter().try_for_each(|part| check_pose(element, &part.pose_frame_part))?;
        refuse_vast(SCENE, &body)?;
        let second = self.bodies.len();
        self.pairs.extend(others.iter().map(|&first| BodyPair { first, second }));
        self.bodies.push(body);
        Ok(())
    }

    /// Maps names to bodies, considering those that `is_meant` selects; the first of a name counts.
    pub(super) fn index(&self, is_meant: impl Fn(&Body) -> bool) -> HashMap<&str, usize> {
        let meant = self.bodies.iter().enumerate().filter(|(_, body)| is_meant(body));
        meant.rev().map(|(index, body)| (body.name.as_str(), index)).collect()
    }

    /// Finds a body by its name; `None` stands for a link without geometry, which touches nothing.
    pub(super) fn body_or_link(
        &self,
        bodies: &HashMap<&str, usize>,
        name: &str,
        element: impl FnOnce() -> String,
    ) -> Result<Option<usize>> {
        match bodies.get(name) {
            Some(body) => Ok(Some(*body)),
            None if self.links.iter().any(|link| link.name == name) => Ok(None),
            None => found(bodies, name, &element()).map(Some),
        }
    }
}

/// Returns the name of the obstacle or attached object that a warning is about.
fn body_told(warning: &str) -> Option<&str> {
    let rest = warning.strip_prefix("obstacle `").or_else(|| warning.strip_prefix("attached `"))?;
    rest.split_once('`').map(|(name, _)| name)
}

fn found(bodies: &HashMap<&str, usize>, name: &str, element: &str) -> Result<usize> {
    bodies.get(name).copied().ok_or_else(|| {
        let mut names: Vec<(usize, &str)> = bodies.iter().map(|(name, body)| (*body, *name)).collect();
        names.sort_unstable();
        let names: Vec<&str> = names.into_iter().map(|(_, name)| name).collect();
        Error::input(SCENE, element, unknown(name, &names))
    })
}

fn check_pose(element: &str, pose: &Pose) -> Result<()> {
    let rotation = &pose.rotation;
    let is_rotation =
        (rotation * rotation.transpose() - crate::math::Mat3::identity()).norm() < 1e-9 && rotation.determinant() > 0.0;
    if is_rotation && pose.translation.iter().all(|x| x.abs() <= FARTHEST) {
        return Ok(());
    }
    let (at, turned) = (pose.translation.as_slice(), rotation.as_slice());
    let problem = format!("pose: got {at:?} and the columns {turned:?}, expected within 1e9 [m] and a rotation");
    Err(Error::input(SCENE, element, problem))
}

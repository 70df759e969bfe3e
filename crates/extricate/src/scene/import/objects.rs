//! Converts MoveIt's objects, which have several shapes, to entries of one shape each.

use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::message_pose::MessagePose;
use super::value::At;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::{Geometry, LoadLimit, LoadLimits, TriangleMesh, Voxels};
use crate::scene::file::{AttachedEntry, ObstacleEntry, SceneFile, ShapeEntry};

/// Number of sides of the pyramid that replaces a cone.
const CONE_SIDES: u32 = 64;

/// A shape of an imported object.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Full sides of a box \[m\].
    Box([f64; 3]),
    /// Radius of a sphere \[m\].
    Sphere(f64),
    /// Radius and length \[m\].
    Cylinder([f64; 2]),
    /// Radius and height \[m\]; the apex is up, the origin in the middle.
    Cone([f64; 2]),
    /// Coefficients of `a x + b y + c z + d = 0`.
    Plane([f64; 4]),
    Mesh(Arc<TriangleMesh>),
    /// Path and scale of a mesh file.
    MeshFile(String, [f64; 3]),
    /// Occupied cells of a map, for obstacles alone.
    Voxels(Arc<Voxels>),
}

/// A named object and its shapes, each with its pose in the world or in the link that holds it.
#[derive(Debug, Clone)]
pub struct Object {
    pub name: String,
    pub shapes: Vec<(Shape, MessagePose)>,
}

/// Collects objects and notes, and converts them to the entries of a scene file.
#[derive(Debug)]
pub struct Objects {
    entries: SceneFile,
    notes: Vec<String>,
    noted: HashSet<String>,
    /// Names of all objects, in order.
    all: Vec<String>,
    /// Names of the entries of each object.
    names: HashMap<String, Vec<String>>,
    /// Names of objects with shapes that are obstacles.
    standing: HashSet<String>,
    /// Names of all entries.
    taken: HashSet<String>,
    /// Number of triangles of all cones.
    triangles: usize,
}

impl Objects {
    pub fn new(limits: &LoadLimits) -> Self {
        let (notes, noted, all, names, standing, taken) = Default::default();
        let entries = SceneFile { limits: limits.clone(), ..SceneFile::default() };
        Self { entries, notes, noted, all, names, standing, taken, triangles: 0 }
    }

    /// Adds a note for the user, unless it repeats one.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        if self.noted.insert(text.clone()) {
            self.notes.push(text);
        }
    }

    /// Adds a note for each key of a message that is not `known`.
    pub fn note_unknown(&mut self, at: &At, known: &[&str]) -> Result<()> {
        for key in at.unknown(known)? {
            let place = if at.path.is_empty() { String::new() } else { format!("{}: ", at.path) };
            self.note(format!("{place}the key `{}` is not taken, expected {}", quoted(key), known.join(", ")));
        }
        Ok(())
    }

    /// Returns the names of an object's entries; `None` for an unknown object.
    pub fn names_of(&self, object: &str) -> Option<&[String]> {
        self.names.get(object).map(Vec::as_slice)
    }

    pub fn all(&self) -> Vec<String> {
        self.all.clone()
    }

    pub fn is_obstacle(&self, object: &str) -> bool {
        self.standing.contains(object)
    }

    /// Returns the entries and the notes.
    pub fn finish(self) -> (SceneFile, Vec<String>) {
        (self.entries, self.notes)
    }

    pub fn entries(&mut self) -> &mut SceneFile {
        &mut self.entries
    }

    pub fn stand(&mut self, file: &str, object: Object) -> Result<()> {
        if !object.shapes.is_empty() {
            self.standing.insert(object.name.clone());
        }
        for (name, shape, pose) in self.entries_of(file, object)? {
            self.entries.obstacle.push(ObstacleEntry { name, shape, pose: pose.entry() });
        }
        Ok(())
    }

    /// Adds an object that a link holds.
    pub fn attach(&mut self, file: &str, object: Object, link: &str, touch: &[String]) -> Result<()> {
        if object.shapes.iter().any(|(shape, _)| matches!(shape, Shape::Plane(_))) {
            let problem = "got a plane, expected a shape that a link can hold";
            return Err(Error::input(file, format!("attached object \"{}\"", object.name), problem));
        }
        for (name, shape, pose) in self.entries_of(file, object)? {
            let (link, touch) = (link.to_string(), touch.to_vec());
            self.entries.attached.push(AttachedEntry { name, link, shape, pose: pose.entry(), touch });
        }
        Ok(())
    }

    /// Converts an object to one entry for each shape, with unique names; notes what changes.
    fn entries_of(&mut self, file: &str, object: Object) -> Result<Vec<(String, ShapeEntry, MessagePose)>> {
        let Object { name: object, shapes } = object;
        let element = format!("object \"{}\"", quoted(&object));
        let limits = self.entries.limits.clone();
        limits.check(LoadLimit::NameBytes, object.len(), file, &element)?;
        limits.check(LoadLimit::Obstacles, self.taken.len() + shapes.len(), file, &element)?;
        if self.names.contains_key(&object) {
            return Err(Error::input(file, element, "the name occurs twice, expected every object to have its own"));
        }
        if shapes.is_empty() {
            self.note(format!("{element} has no shape: it is left out"));
        }
        let names: Vec<String> = match shapes.len() {
            1 => vec![object.clone()],
            count => (1..=count).map(|number| format!("{object}-{number}")).collect(),
        };
        if let Some(twice) = names.iter().find(|name| !self.taken.insert((*name).clone())) {
            return Err(Error::input(file, element, format!("`{twice}` is another object's name already")));
        }
        if let [first, .., last] = names.as_slice() {
            self.note(format!("{element} has {} shapes: they are `{first}` to `{last}`", names.len()));
        }
        self.all.push(object.clone());
        self.names.insert(object, names.clone());
        let entry = |(name, (shape, pose)): (String, (Shape, MessagePose))| {
            let shape = self.entry(file, &element, shape)?;
            Ok((name, shape, pose))
        };
        names.into_iter().zip(shapes).map(entry).collect()
    }

    fn entry(&mut self, file: &str, element: &str, shape: Shape) -> Result<ShapeEntry> {
        let mut entry = ShapeEntry::default();
        match shape {
            Shape::Box(sides) => entry.cuboid = Some(sides),
            Shape::Sphere(radius) => entry.sphere = Some(radius),
            Shape::Cylinder(sizes) => entry.cylinder = Some(sizes),
            Shape::Cone([radius, height]) => {
                if !(radius > 0.0 && height > 0.0 && radius.max(height) < f64::INFINITY) {
                    let problem = format!("cone: got {radius} and {height}, expected a radius and a height > 0 [m]");
                    return Err(Error::input(file, element, problem));
                }
                let beyond = 100.0 * (1.0 / (PI / f64::from(CONE_SIDES)).cos() - 1.0);
                self.note(format!(
                    "{element}: a cone is taken for the pyramid of {CONE_SIDES} sides around it, {beyond:.2} % wider at its corners"
                ));
                let cone = cone(radius, height);
                self.triangles += cone.triangles.len();
                self.entries.limits.check(LoadLimit::Triangles, self.triangles, file, element)?;
                (entry.triangles, entry.convex) = (Some(Arc::new(cone)), true);
            }
            Shape::Plane([a, b, c, d]) => {
                let length = Vec3::new(a, b, c).norm();
                if !(length > 0.0 && length.is_finite() && d.is_finite()) {
                    let problem =
                        format!("plane: got {:?}, expected a, b, c, d of a x + b y + c z + d = 0", [a, b, c, d]);
                    return Err(Error::input(file, element, problem));
                }
                self.note(format!(
                    "{element}: a plane is taken for all that lies behind it (a x + b y + c z <= -d), not for a thin sheet"
                ));
                (entry.half_space, entry.offset) = (Some([a, b, c].map(|x| x / length)), Some(-d / length));
            }
            Shape::Mesh(mesh) => entry.triangles = Some(mesh),
            Shape::Voxels(voxels) => entry.scenery = Some(Geometry::Voxels(voxels)),
            Shape::MeshFile(path, scale) => {
                entry.mesh = Some(path);
                entry.scale = (scale != [1.0; 3]).then_some(crate::scene::file::ScaleEntry::Axes(scale));
            }
        }
        Ok(entry)
    }
}

/// Builds the pyramid around a cone, whose sides touch it.
fn cone(radius: f64, height: f64) -> TriangleMesh {
    let (half, rim) = (height / 2.0, radius / (PI / f64::from(CONE_SIDES)).cos());
    let corner = |k: u32| {
        let (sine, cosine) = (TAU * f64::from(k) / f64::from(CONE_SIDES)).sin_cos();
        Vec3::new(rim * cosine, rim * sine, -half)
    };
    let vertices = (0..CONE_SIDES).map(corner).chain([Vec3::new(0.0, 0.0, half), Vec3::new(0.0, 0.0, -half)]);
    let sides = (0..CONE_SIDES).flat_map(|k| {
        let next = (k + 1) % CONE_SIDES;
        [[k, next, CONE_SIDES], [next, k, CONE_SIDES + 1]]
    });
    TriangleMesh::new(vertices.collect(), sides.collect())
}

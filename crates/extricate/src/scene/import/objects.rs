//! Objects of several shapes and planes, as MoveIt has them, to entries of one shape each.

use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::place::Place;
use super::value::At;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits, TriangleMesh};
use crate::scene::file::{AttachedEntry, ObstacleEntry, SceneFile, ShapeEntry};

/// Sides of the pyramid that stands for a cone.
const SIDES: u32 = 64;

/// A shape as the formats have it.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Full sides \[m\].
    Box([f64; 3]),
    /// Radius \[m\].
    Sphere(f64),
    /// Radius and length \[m\].
    Cylinder([f64; 2]),
    /// Radius and height \[m\], the apex up, the origin in the middle.
    Cone([f64; 2]),
    /// `a x + b y + c z + d = 0`.
    Plane([f64; 4]),
    /// As it is.
    Mesh(Arc<TriangleMesh>),
    /// Path and scale.
    MeshFile(String, [f64; 3]),
}

/// A named object and its shapes, each with its place in the world, or in the link that holds it.
#[derive(Debug, Clone)]
pub struct Object {
    pub name: String,
    pub shapes: Vec<(Shape, Place)>,
}

/// Objects on their way into a scene file.
#[derive(Debug)]
pub struct Objects {
    entries: SceneFile,
    notes: Vec<String>,
    noted: HashSet<String>,
    /// Objects in order, and by object the names of its entries.
    all: Vec<String>,
    names: HashMap<String, Vec<String>>,
    /// Objects that stand in the world.
    standing: HashSet<String>,
    taken: HashSet<String>,
    /// Triangles of the meshes that were made here.
    triangles: usize,
}

impl Objects {
    /// None, and how many there may be.
    pub fn new(limits: &LoadLimits) -> Self {
        let (notes, noted, all, names, standing, taken) = Default::default();
        let entries = SceneFile { limits: limits.clone(), ..SceneFile::default() };
        Self { entries, notes, noted, all, names, standing, taken, triangles: 0 }
    }

    /// Something that the user should know.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        if self.noted.insert(text.clone()) {
            self.notes.push(text);
        }
    }

    /// Tells keys of a message that mean nothing.
    pub fn note_unknown(&mut self, at: &At, known: &[&str]) -> Result<()> {
        for key in at.unknown(known)? {
            let place = if at.path.is_empty() { String::new() } else { format!("{}: ", at.path) };
            self.note(format!("{place}the key `{}` is not taken, expected {}", quoted(key), known.join(", ")));
        }
        Ok(())
    }

    /// The names of the entries of an object, if there is such an object.
    pub fn names_of(&self, object: &str) -> Option<&[String]> {
        self.names.get(object).map(Vec::as_slice)
    }

    /// Names of all objects.
    pub fn all(&self) -> Vec<String> {
        self.all.clone()
    }

    /// Whether an object stands in the world.
    pub fn is_obstacle(&self, object: &str) -> bool {
        self.standing.contains(object)
    }

    /// All that was read.
    pub fn finish(self) -> (SceneFile, Vec<String>) {
        (self.entries, self.notes)
    }

    /// What may still be added to.
    pub fn entries(&mut self) -> &mut SceneFile {
        &mut self.entries
    }

    /// Adds an obstacle.
    pub fn stand(&mut self, file: &str, object: Object) -> Result<()> {
        if !object.shapes.is_empty() {
            self.standing.insert(object.name.clone());
        }
        for (name, shape, place) in self.told(file, object)? {
            self.entries.obstacle.push(ObstacleEntry { name, shape, pose: place.entry() });
        }
        Ok(())
    }

    /// Adds an object that a link holds.
    pub fn attach(&mut self, file: &str, object: Object, link: &str, touch: &[String]) -> Result<()> {
        if object.shapes.iter().any(|(shape, _)| matches!(shape, Shape::Plane(_))) {
            let problem = "got a plane, expected a shape that a link can hold";
            return Err(Error::input(file, format!("attached object \"{}\"", object.name), problem));
        }
        for (name, shape, place) in self.told(file, object)? {
            let (link, touch) = (link.to_string(), touch.to_vec());
            self.entries.attached.push(AttachedEntry { name, link, shape, pose: place.entry(), touch });
        }
        Ok(())
    }

    /// One entry a shape, with names of their own, and what there is to say of them.
    fn told(&mut self, file: &str, object: Object) -> Result<Vec<(String, ShapeEntry, Place)>> {
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
        let entry = |(name, (shape, place)): (String, (Shape, Place))| {
            let shape = self.entry(file, &element, shape)?;
            Ok((name, shape, place))
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
                let beyond = 100.0 * (1.0 / (PI / f64::from(SIDES)).cos() - 1.0);
                self.note(format!(
                    "{element}: a cone is taken for the pyramid of {SIDES} sides around it, {beyond:.2} % wider at its corners"
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
            Shape::MeshFile(path, scale) => {
                entry.mesh = Some(path);
                entry.scale = (scale != [1.0; 3]).then_some(crate::scene::file::ScaleEntry::Axes(scale));
            }
        }
        Ok(entry)
    }
}

/// Around a cone: its sides touch it.
fn cone(radius: f64, height: f64) -> TriangleMesh {
    let (half, rim) = (height / 2.0, radius / (PI / f64::from(SIDES)).cos());
    let corner = |k: u32| {
        let (sine, cosine) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
        Vec3::new(rim * cosine, rim * sine, -half)
    };
    let vertices = (0..SIDES).map(corner).chain([Vec3::new(0.0, 0.0, half), Vec3::new(0.0, 0.0, -half)]);
    let sides = (0..SIDES).flat_map(|k| {
        let next = (k + 1) % SIDES;
        [[k, next, SIDES], [next, k, SIDES + 1]]
    });
    TriangleMesh::new(vertices.collect(), sides.collect())
}

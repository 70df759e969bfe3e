//! A scene as text: the entries of its TOML file, and the files that they name.

use std::fmt::Write as _;
use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use anyhow::Result;
use extricate::geometry::TriangleMesh;
use extricate::internals::scene::assemble::assemble;
use extricate::{Error, Scene};

use super::mesh_file;
use super::robots::Robot;

#[derive(Debug, Clone)]
pub enum Shape {
    /// A box by its full side lengths \[m\].
    Box([f64; 3]),
    /// Radius and length, along z.
    Cylinder([f64; 2]),
    /// A mesh as it is, not its hull.
    Mesh(TriangleMesh),
    /// The convex hull of the mesh.
    Hull(TriangleMesh),
}

#[derive(Debug, Clone)]
pub struct Obstacle {
    pub name: String,
    pub shape: Shape,
    /// Position of its centre \[m\].
    pub xyz: [f64; 3],
    /// Roll, pitch and yaw \[rad\].
    pub rpy: [f64; 3],
}

#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Name of the scene file, without its ending.
    pub name: String,
    pub text: String,
    /// Paths, relative to the scene file, and contents of the files that it names.
    pub files: Vec<(String, Vec<u8>)>,
    /// Number of draws until the scene was accepted.
    pub draws: usize,
}

impl Written {
    /// Begins a scene without robots and obstacles.
    pub fn new(name: &str) -> Self {
        let text = "clearance = 1e-4\nmetric = { kind = \"joint\" }\n".to_string();
        Self { name: name.to_string(), text, files: Vec::new(), draws: 1 }
    }

    /// Adds a robot. An empty `name` is left out of the entry; `raw` keeps meshes as they are if
    /// the robot allows it, else they become convex hulls.
    pub fn robot(&mut self, robot: &Robot, name: &str, xyz: [f64; 3], raw: bool) {
        let name = if name.is_empty() { String::new() } else { format!("name = \"{name}\"\n") };
        let geometry = if raw && robot.raw { "mesh" } else { "convex-hull" };
        self.line(&format!(
            "\n[[robot]]\n{name}{}geometry = \"{geometry}\"\npose = {{ xyz = {xyz:?} }}\n{}",
            robot.entry, robot.pairs
        ));
        for file in &robot.files {
            if !self.files.contains(file) {
                self.files.push(file.clone());
            }
        }
    }

    /// Adds obstacles. Numbers are rounded to a tenth of a millimetre, so that the file does not
    /// depend on the last bits of a machine's arithmetic.
    pub fn obstacles(&mut self, obstacles: &[Obstacle]) {
        for Obstacle { name, shape, xyz, rpy } in obstacles {
            let (xyz, rpy) = (xyz.map(rounded), rpy.map(rounded));
            let path = mesh_file(&self.name, name, shape).map(|file| {
                let path = file.0.clone();
                self.files.push(file);
                path
            });
            let shape = match (shape, path.unwrap_or_default()) {
                (Shape::Box(sides), _) => format!("box = {:?}", sides.map(rounded)),
                (Shape::Cylinder(sizes), _) => format!("cylinder = {:?}", sizes.map(rounded)),
                (Shape::Mesh(_), path) => format!("mesh = \"{path}\""),
                (Shape::Hull(_), path) => format!("mesh = \"{path}\", convex = true"),
            };
            self.line(&format!(
                "\n[[obstacle]]\nname = \"{name}\"\nshape = {{ {shape} }}\npose = {{ xyz = {xyz:?}, rpy = {rpy:?} }}"
            ));
        }
    }

    /// The scene file and all files that it names, except those of fetched robots.
    pub fn all_files(&self) -> Vec<(String, Vec<u8>)> {
        let own = (format!("{}.toml", self.name), self.text.clone().into_bytes());
        std::iter::once(own).chain(self.files.iter().cloned()).collect()
    }

    /// Assembles the scene as a program that loads its files would.
    pub fn assembled(&self) -> Result<Scene> {
        let scene = assemble(Path::new("scene.toml"), &self.text, &mut |path| {
            let wanted: PathBuf = path.components().filter(|part| part.as_os_str() != ".").collect();
            if let Some((_, contents)) = self.files.iter().find(|(name, _)| Path::new(name) == wanted) {
                return Ok(contents.clone());
            }
            // Fetched robots lie outside of the scene's folder, so their paths are absolute.
            let found = if wanted.is_absolute() { std::fs::read(&wanted) } else { Err(ErrorKind::NotFound.into()) };
            found.map_err(|source: IoError| Error::Read { path: path.into(), source })
        });
        Ok(scene?)
    }

    fn line(&mut self, line: &str) {
        // Writing to a `String` cannot fail.
        let _ = writeln!(self.text, "{line}");
    }
}

/// Rounds to four decimals.
fn rounded(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

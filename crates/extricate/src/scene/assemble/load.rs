//! Reads the URDF, SRDF and mesh files that a scene file names, each mesh once. `robot/packages`
//! resolves paths in packages.

use std::collections::{BTreeMap, HashMap};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::bodies::replace_meshes;
use super::loaded::{LoadedRobot, ReadFile};
use crate::error::{Error, Result, quoted};
use crate::robot::formats::xml::{decoded, package_name};
use crate::robot::packages::{PackageSearch, PackageUri, file_path};
use crate::robot::srdf::{self, Srdf};
use crate::robot::urdf::{self, Shapes, Wanted};
use crate::robot::{LoadLimit, LoadLimits, Robot, TriangleMesh, formats};
use crate::scene::file::{CutMesh, GeometryKind, RobotEntry, SceneFile};
use crate::scene::names::{robot_names, unknown};

/// Reads and caches the files of one scene.
pub struct Files<'a> {
    /// Name of the scene file in messages.
    file: String,
    /// Folder that paths in the scene file are relative to.
    folder: PathBuf,
    read: ReadFile<'a>,
    cut: Option<CutMesh>,
    limits: LoadLimits,
    search: PackageSearch,
    meshes: HashMap<PathBuf, Arc<TriangleMesh>>,
    /// Scaled meshes by path and bits of the scale factors.
    scaled: HashMap<(PathBuf, [u64; 3]), Arc<TriangleMesh>>,
    /// Number of triangles in `meshes` and `scaled`.
    triangles: usize,
    /// Number of bytes of text that was read.
    text_bytes: usize,
    /// Name of the package in each folder, from its `package.xml`.
    package_names: HashMap<PathBuf, Option<String>>,
    mesh_warnings: Vec<String>,
}

/// Largest number of `packages` of one entry, because every mesh is searched in each.
const MAX_PACKAGES: usize = 1000;

/// A URDF that a scene file names.
pub struct Source<'a> {
    /// Element that names it, for messages.
    pub element: &'a str,
    /// Its path in the scene file.
    pub urdf: &'a str,
    /// Folders where `package://` is looked up first.
    pub packages: &'a [String],
    /// Kind of its shapes, and treatment of their meshes.
    pub geometry: GeometryKind,
    /// Treatment of the meshes of single links, by name.
    pub links: &'a BTreeMap<String, GeometryKind>,
    /// Returns whether the scene has limits for the joint of this name.
    pub is_replaced: &'a dyn Fn(&str) -> bool,
}

impl<'a> Files<'a> {
    /// Creates an empty cache for the `scene` whose file is at `path`.
    pub fn new(path: &Path, scene: &SceneFile, read: ReadFile<'a>) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self {
            file: path.display().to_string(),
            folder,
            read,
            cut: scene.cut,
            limits: scene.limits.clone(),
            search: scene.search.clone(),
            meshes: HashMap::new(),
            scaled: HashMap::new(),
            triangles: 0,
            text_bytes: 0,
            package_names: HashMap::new(),
            mesh_warnings: Vec::new(),
        }
    }

    /// Reads every robot and makes their names unique.
    pub fn robots<'e>(
        &mut self,
        entries: &'e [RobotEntry],
        warnings: &mut Vec<String>,
    ) -> Result<Vec<LoadedRobot<'e>>> {
        let mut robots = Vec::with_capacity(entries.len());
        for (index, entry) in entries.iter().enumerate() {
            robots.push(self.robot(index, entry, warnings)?);
        }
        let names = robot_names(&self.file, entries, robots.iter().map(|loaded| loaded.robot.name.as_str()))?;
        for (loaded, name) in robots.iter_mut().zip(names) {
            loaded.name = name;
        }
        Ok(robots)
    }

    fn robot<'e>(
        &mut self,
        index: usize,
        entry: &'e RobotEntry,
        warnings: &mut Vec<String>,
    ) -> Result<LoadedRobot<'e>> {
        let source = Source {
            element: &format!("robot {}: urdf", index + 1),
            urdf: &entry.urdf,
            packages: &entry.packages,
            geometry: entry.geometry,
            links: &entry.links,
            is_replaced: &|joint| entry.limits.contains_key(joint),
        };
        let (file, robot) = self.links(&source, warnings)?;
        let (mut of_srdf, mut group) = (Srdf::default(), None);
        if let Some(srdf) = &entry.srdf {
            let path = self.folder.join(srdf);
            let file = path.display().to_string();
            let text = self.text(&path, &format!("robot {}: srdf", index + 1))?;
            let srdf = srdf::parse_within(&file, &text, &self.limits)?;
            group = match &entry.group {
                Some(group) => Some(srdf.group_joints(&file, group, &robot)?),
                None => None,
            };
            of_srdf = srdf;
        } else if let Some(group) = &entry.group {
            let problem = format!("got `{group}` without an SRDF, expected `srdf = ..` that defines it");
            return Err(Error::input(&self.file, format!("robot \"{}\": group", robot.name), problem));
        }
        Ok(LoadedRobot { name: robot.name.clone(), urdf: file, robot, srdf: of_srdf, group, entry })
    }

    /// Reads a URDF and replaces its meshes as requested; also returns its name for messages.
    pub fn links(&mut self, source: &Source, warnings: &mut Vec<String>) -> Result<(String, Robot)> {
        let Source { element, urdf, packages, geometry, links, is_replaced } = *source;
        let path = self.folder.join(urdf);
        let file = path.display().to_string();
        let text = self.text(&path, element)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        if packages.len() > MAX_PACKAGES {
            let problem = format!("got {} packages, expected at most {MAX_PACKAGES}", packages.len());
            return Err(Error::input(&self.file, element, problem));
        }
        let packages: Vec<PathBuf> = packages.iter().map(|package| self.folder.join(package)).collect();
        let shapes = if geometry == GeometryKind::Visual { Shapes::Visual } else { Shapes::Collision };
        let limits = self.limits.clone();
        let mut found: HashMap<String, PathBuf> = HashMap::new();
        let mut load = |uri: &str, scale: [f64; 3]| {
            if !found.contains_key(uri) {
                found.insert(uri.to_owned(), self.mesh_of(&file, uri, &folder, &packages)?);
            }
            self.scaled(&found[uri], scale).map_err(|error| named(&file, &in_mesh(uri), error))
        };
        let mut robot =
            urdf::parse_within(&file, &text, &Wanted { shapes, limits: &limits, is_replaced }, &mut load, warnings)?;
        let fault = |problem: String| Error::input(&self.file, format!("robot \"{}\": links", robot.name), problem);
        for (name, kind) in links {
            if *kind == GeometryKind::Visual {
                return Err(fault(format!("`{name}`: got visual, expected mesh, convex-hull or convex-parts")));
            }
            if !robot.links.iter().any(|link| link.name == *name) {
                let known: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
                return Err(fault(unknown(name, &known)));
            }
        }
        let kind = |link: &str| links.get(link).copied().unwrap_or(geometry);
        replace_meshes(&mut robot, kind, self.cut, warnings)
            .map_err(|problem| Error::input(&self.file, "geometry", problem))?;
        Ok((file, robot))
    }

    /// Returns the warnings about the meshes that were read.
    pub fn into_mesh_warnings(self) -> Vec<String> {
        self.mesh_warnings
    }

    /// Returns the scaled mesh at a path of the scene file; `element` names it in messages.
    pub fn mesh(&mut self, element: &str, path: &str, scale: [f64; 3]) -> Result<Arc<TriangleMesh>> {
        let path = self.folder.join(path);
        match self.mesh_at(&path).map_err(|error| named(&self.file, element, error))? {
            Some(_) => self.scaled(&path, scale).map_err(|error| named(&self.file, element, error)),
            None => {
                let problem = format!("got {}, expected a file (not found)", path.display());
                Err(Error::not_found(&self.file, element, problem))
            }
        }
    }

    /// Returns the scaled mesh at a path; every scale of a mesh is computed once.
    fn scaled(&mut self, path: &Path, scale: [f64; 3]) -> Result<Arc<TriangleMesh>> {
        let mesh =
            self.mesh_at(path)?.ok_or_else(|| Error::Read { path: path.into(), source: ErrorKind::NotFound.into() })?;
        if scale == [1.0; 3] {
            return Ok(mesh);
        }
        let key = (path.to_path_buf(), scale.map(f64::to_bits));
        if let Some(scaled) = self.scaled.get(&key) {
            return Ok(Arc::clone(scaled));
        }
        self.count_triangles(path, &mesh)?;
        let scaled = Arc::new(mesh.scaled(scale));
        self.scaled.insert(key, Arc::clone(&scaled));
        Ok(scaled)
    }

    fn count_triangles(&mut self, path: &Path, mesh: &TriangleMesh) -> Result<()> {
        self.triangles += mesh.triangles.len();
        let element = format!("mesh {} and those before it", path.display());
        self.limits.check(LoadLimit::Triangles, self.triangles, &self.file, &element)
    }

    /// Reads the file at a path of the scene file. Returns its name for messages and its bytes.
    pub fn bytes(&mut self, element: &str, path: &str) -> Result<(String, Vec<u8>)> {
        let path = self.folder.join(path);
        let bytes = (self.read)(&path).map_err(|error| named(&self.file, element, error))?;
        Ok((path.display().to_string(), bytes))
    }

    /// Finds the file that the URDF `file` in `folder` calls `uri`.
    fn mesh_of(&mut self, file: &str, uri: &str, folder: &Path, packages: &[PathBuf]) -> Result<PathBuf> {
        let written = file_path(uri);
        let Some(address) = PackageUri::of(&written) else {
            // `join` drops the folder if the path is absolute.
            let path = folder.join(&written);
            return match self.mesh_at(&path).map_err(|error| named(file, &in_mesh(uri), error))? {
                Some(_) => Ok(path),
                None => Err(Error::not_found(file, in_mesh(uri), format!("not found, tried {}", path.display()))),
            };
        };
        address.check().map_err(|problem| Error::input(file, in_mesh(uri), problem))?;
        let search = std::mem::take(&mut self.search);
        let roots = search.roots(address.package, folder, packages, |folder| self.package_at(folder));
        self.search = search;
        let mut denied = None;
        for root in roots {
            let path = root.join(address.rest);
            match self.mesh_at(&path) {
                Ok(Some(_)) => return Ok(path),
                Ok(None) => {}
                // Nobody named the folders above the URDF, so an unreadable one is no fault yet.
                Err(error @ Error::Read { .. }) if is_denied(&error) => denied = denied.or(Some(error)),
                Err(error) => return Err(named(file, &in_mesh(uri), error)),
            }
        }
        if let Some(error) = denied {
            return Err(named(file, &in_mesh(uri), error));
        }
        let tried = self.search.in_words(folder, packages);
        let package = quoted(address.package);
        let problem = format!(
            "not found, tried the package `{package}` in {tried}; add the folder that holds `{package}`, or the one whose \
             package.xml calls it so, to `packages`"
        );
        Err(Error::not_found(file, in_mesh(uri), problem))
    }

    /// Returns the package name in a folder's `package.xml`, if that can be read.
    fn package_at(&mut self, folder: &Path) -> Option<String> {
        if let Some(known) = self.package_names.get(folder) {
            return known.clone();
        }
        let name = (self.read)(&folder.join("package.xml")).ok().and_then(|bytes| package_name(&decoded(&bytes)));
        self.package_names.insert(folder.to_path_buf(), name.clone());
        name
    }

    /// Returns the mesh at a path; `None` if there is no such file.
    fn mesh_at(&mut self, path: &Path) -> Result<Option<Arc<TriangleMesh>>> {
        if let Some(mesh) = self.meshes.get(path) {
            return Ok(Some(Arc::clone(mesh)));
        }
        let bytes = match (self.read)(path) {
            Ok(bytes) => bytes,
            Err(Error::Read { source, .. })
                if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
            {
                return Ok(None);
            }
            Err(error) => return Err(error),
        };
        let name = path.display().to_string();
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut neighbour = |uri: &str| {
            (self.read)(&folder.join(uri)).map_err(|error| named(&name, &format!("uri \"{}\"", quoted(uri)), error))
        };
        let mesh = formats::parse_among(&name, &bytes, &self.limits, &mut neighbour, &mut self.mesh_warnings)?;
        let mesh = Arc::new(mesh);
        self.count_triangles(path, &mesh)?;
        self.meshes.insert(path.to_path_buf(), Arc::clone(&mesh));
        Ok(Some(mesh))
    }

    fn text(&mut self, path: &Path, element: &str) -> Result<String> {
        let bytes = (self.read)(path).map_err(|error| named(&self.file, element, error))?;
        self.text_bytes += bytes.len();
        self.limits.check(LoadLimit::TextBytes, self.text_bytes, &self.file, element)?;
        Ok(decoded(&bytes))
    }
}

fn is_denied(error: &Error) -> bool {
    matches!(error, Error::Read { source, .. } if source.kind() == ErrorKind::PermissionDenied)
}

fn in_mesh(uri: &str) -> String {
    format!("mesh \"{}\"", quoted(uri))
}

/// Adds the `element` of `file` that names an unreadable file to its error.
fn named(file: &str, element: &str, error: Error) -> Error {
    match error {
        Error::Read { path, source } => {
            let problem = format!("got {}, expected a file that can be read ({source})", path.display());
            Error::named(file, element, problem, source.kind())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> SceneFile {
        SceneFile::default()
    }

    #[test]
    fn packages_are_called_what_their_package_xml_says() {
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        for (urdf, packages) in [("v/arm/urdf", &["v"][..]), ("v/arm", &[]), ("elsewhere", &["v/arm"])] {
            let mut read = |path: &Path| match path.to_str() {
                Some("v/arm/package.xml") => Ok(b"<package format='2'><name> arm_support\n</name></package>".to_vec()),
                Some("v/package.xml") => Ok(b"not XML".to_vec()),
                Some("v/arm/meshes/link.obj") => Ok(obj.to_vec()),
                _ => Err(Error::Read { path: path.to_path_buf(), source: ErrorKind::NotFound.into() }),
            };
            let (file, scene) = (Path::new("s.toml"), scene());
            let mut files = Files::new(file, &scene, &mut read);
            let packages: Vec<PathBuf> = packages.iter().map(PathBuf::from).collect();
            let mut found = |uri: &str| files.mesh_of("r.urdf", uri, Path::new(urdf), &packages);
            let mesh = PathBuf::from("v/arm/meshes/link.obj");
            assert_eq!(found("package://arm_support/meshes/link.obj").unwrap(), mesh, "{urdf}");
            assert_eq!(found("package://arm/meshes/link.obj").unwrap(), mesh, "{urdf}");
            assert_eq!(found("package://arm\\meshes\\link.obj").unwrap(), mesh, "{urdf}");
            assert!(found("package://leg/meshes/link.obj").is_err());
            assert!(found("package://arm\\..\\..\\link.obj").unwrap_err().to_string().contains("inside the package"));
            assert!(
                found("package://arm/../arm/meshes/link.obj").unwrap_err().to_string().contains("inside the package")
            );
        }
    }

    #[test]
    fn other_addresses_start_from_the_urdf() {
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let mut read = |path: &Path| match path.starts_with("s/urdf/../m") || path.starts_with("/m") {
            true => Ok(obj.to_vec()),
            false => Err(Error::Read { path: path.to_path_buf(), source: ErrorKind::NotADirectory.into() }),
        };
        let scene = scene();
        let mut files = Files::new(Path::new("s.toml"), &scene, &mut read);
        for (uri, path) in
            [("file:///m/a.obj", "/m/a.obj"), ("/m/a.obj", "/m/a.obj"), ("..\\m\\a.obj", "s/urdf/../m/a.obj")]
        {
            assert_eq!(files.mesh_of("u", uri, Path::new("s/urdf"), &[]).unwrap(), PathBuf::from(path));
        }
        let missing = files.mesh_of("u", "n/a.obj", Path::new("s/urdf"), &[]).unwrap_err().to_string();
        assert_eq!(missing, "u: mesh \"n/a.obj\": not found, tried s/urdf/n/a.obj");
    }

    #[test]
    fn meshes_are_read_once_and_missing_ones_list_every_path() {
        let stl = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let mut reads = Vec::new();
        let mut read = |path: &Path| {
            reads.push(path.display().to_string());
            if path == Path::new("s/b/arm/a.stl") {
                return Ok(stl.to_vec());
            }
            Err(Error::Read { path: path.into(), source: ErrorKind::NotFound.into() })
        };
        let scene = scene();
        let mut files = Files::new(Path::new("s/scene.toml"), &scene, &mut read);
        let tried = [PathBuf::from("s/a"), PathBuf::from("s/b")];
        let (uri, folder) = ("package://arm/a.stl", Path::new(""));
        assert_eq!(files.mesh_of("u.urdf", uri, folder, &tried).unwrap(), Path::new("s/b/arm/a.stl"));
        let first = files.mesh("obstacle", "b/arm/a.stl", [1.0; 3]).unwrap();
        assert!(Arc::ptr_eq(&first, &files.mesh("obstacle", "b/arm/a.stl", [1.0; 3]).unwrap()));
        let scaled = files.mesh("obstacle", "b/arm/a.stl", [2.0, 1.0, 1.0]).unwrap();
        assert!(Arc::ptr_eq(&scaled, &files.mesh("obstacle", "b/arm/a.stl", [2.0, 1.0, 1.0]).unwrap()));
        assert_eq!(files.triangles, 2);
        let missing = files.mesh_of("u.urdf", uri, folder, &tried[..1]).unwrap_err().to_string();
        assert_eq!(
            missing,
            "u.urdf: mesh \"package://arm/a.stl\": not found, tried the package `arm` in `packages`: s/a; the URDF's folders: \
             none; AMENT_PREFIX_PATH: not set; ROS_PACKAGE_PATH: not set; add the folder that holds `arm`, or the one \
             whose package.xml calls it so, to `packages`"
        );
        let missing = files.mesh("obstacle \"c\": mesh", "c.stl", [1.0; 3]).unwrap_err().to_string();
        assert_eq!(missing, "s/scene.toml: obstacle \"c\": mesh: got s/c.stl, expected a file (not found)");
        assert_eq!(reads.iter().filter(|path| *path == "s/b/arm/a.stl").count(), 1);
    }
}

//! Reads worlds from scene files, files and texts of other programs, and finds packages.

use std::path::PathBuf;

use extricate::{LoadOptions, files, load_scene_within};
use pyo3::prelude::*;

use super::Scene;
use super::load_limits::{Limits, limits_of};
use crate::entries::lists::Folders;
use crate::error::{exception, warn, warned};
use crate::long_call;

#[pymethods]
impl Scene {
    /// Returns the robots of this scene in the world of a file.
    ///
    /// path: a scene file (TOML) without a robot: its obstacles replace those of this scene, and
    ///     its attached objects, disabled pairs and padding are added. Or a world that MoveIt
    ///     wrote: .scene text, or a PlanningScene as .yaml or .json. A UserWarning names what of it
    ///     is not used.
    /// load_limits: limits of what the files may hold, as in `Scene.load`.
    /// packages: folders in which `package://NAME/...` is looked up first.
    ///
    /// Raises OSError for a file that cannot be read, ValueError for what cannot be used in it.
    #[pyo3(signature = (path, *, load_limits = None, packages = Folders::default()), text_signature = "($self, path, *, load_limits=None, packages=())")]
    fn in_world(
        &self,
        py: Python<'_>,
        path: PathBuf,
        load_limits: Option<Limits>,
        packages: Folders,
    ) -> PyResult<Self> {
        let options = LoadOptions::default().limits(limits_of(load_limits)?).packages(packages.of("packages")?);
        let robots = self.inner().clone();
        let scene = long_call::apart(py, move || files::load_world(&robots, &path, &options))?.map_err(exception)?;
        self.told(py, scene)
    }

    /// As `in_world`, for the text of a file. Messages say `name`, whose extension sets the format.
    fn _in_world_text(&self, py: Python<'_>, name: String, text: String) -> PyResult<Self> {
        let robots = self.inner().clone();
        let load = move || files::load_world_text(&robots, &name, &text, &LoadOptions::default());
        let scene = long_call::apart(py, load)?.map_err(exception)?;
        self.told(py, scene)
    }
}

/// Writes a world of MoveIt as a scene file, its meshes and octomap into a folder beside it.
///
/// path: .scene text, or a PlanningScene as .yaml or .json.
/// output: the scene file to write (TOML).
/// robot: the URDF that the scene file then names; or a scene file or a Scene, which serves only to
///     look up links and frames. Without it the file is a world for `Scene.in_world`.
/// load_limits: limits of what the files may hold, as in `Scene.load`.
/// Returns the paths that were written, the scene file first. A UserWarning and the head of the
/// scene file name what is left out or replaced by something else.
///
/// Raises OSError for files that cannot be read or written, ValueError for what cannot be used.
#[pyfunction]
#[pyo3(signature = (path, output, *, robot = None, load_limits = None))]
pub fn import_world(
    py: Python<'_>,
    path: PathBuf,
    output: PathBuf,
    robot: Option<&Bound<'_, PyAny>>,
    load_limits: Option<Limits>,
) -> PyResult<Vec<PathBuf>> {
    let limits = limits_of(load_limits)?;
    let (mut robots, mut urdf) = (None, None);
    if let Some(robot) = robot {
        if let Ok(scene) = robot.cast::<Scene>() {
            robots = Some(scene.get().inner().clone());
        } else {
            let file: PathBuf = robot.extract()?;
            urdf = files::is_urdf(&file).map_err(exception)?.then(|| file.clone());
            let loaded = long_call::pooled(py, || load_scene_within(&file, &limits))?;
            robots = Some(warned(py, loaded.map_err(exception)?)?);
        }
    }
    let import = || files::import_world(&path, &output, robots.as_deref(), urdf.as_deref(), &limits);
    let done = long_call::pooled(py, import)?.map_err(exception)?;
    done.notes.iter().try_for_each(|note| warn(py, note))?;
    Ok([output].into_iter().chain(done.meshes).collect())
}

/// Returns the folder of a package that a file names, by the rule for meshes of URDFs.
#[pyfunction]
pub fn _find_package(package: &str, near: PathBuf, packages: Vec<PathBuf>) -> Option<PathBuf> {
    files::find_package(package, &near, &packages)
}

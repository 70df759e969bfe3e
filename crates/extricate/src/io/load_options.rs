//! How scenes are loaded: what their files may hold, and where packages are. The one place that
//! reads the environment.

use std::env;
use std::path::{Path, PathBuf};

use super::files::read_within;
use crate::robot::formats::xml::{decoded, package_name};
use crate::robot::packages::{PackageSearch, PackageUri};
use crate::robot::{LoadLimit, LoadLimits};

/// How a scene is loaded.
///
/// ```
/// use extricate::{LoadOptions, load_scene_with};
/// let options = LoadOptions { packages: vec!["ws/src".into()], ..LoadOptions::default() };
/// assert!(load_scene_with("missing.urdf", &options).is_err());
/// ```
#[derive(Debug, Clone, Default)]
pub struct LoadOptions {
    /// How much the files may hold.
    pub limits: LoadLimits,
    /// Folders in which packages of `package://` addresses are looked up, before those that a scene
    /// file names, those that the URDF lies in, and those of `AMENT_PREFIX_PATH` and
    /// `ROS_PACKAGE_PATH`.
    pub packages: Vec<PathBuf>,
}

/// The folder of a package that the file `near` names, by the rule by which meshes of URDFs are
/// found; `given` are looked in first.
pub fn find_package(package: &str, near: &Path, given: &[PathBuf]) -> Option<PathBuf> {
    PackageUri { package, rest: "" }.check().ok()?;
    let limits = LoadLimits::default();
    let name_of = |folder: &Path| {
        let bytes = read_within(&folder.join("package.xml"), &limits, LoadLimit::FileBytes).ok()?;
        package_name(&decoded(&bytes))
    };
    let folder = near.parent().unwrap_or(Path::new(""));
    package_search(given).roots(package, folder, &[], name_of).into_iter().find(|root| root.is_dir())
}

/// Where packages are looked up in this process: in the folders `given`, those that URDFs lie in,
/// and those of ROS.
pub fn package_search(given: &[PathBuf]) -> PackageSearch {
    let folders = |name: &str| -> Vec<PathBuf> {
        let listed = env::var_os(name).unwrap_or_default();
        env::split_paths(&listed).filter(|folder| !folder.as_os_str().is_empty()).collect()
    };
    PackageSearch {
        given: given.to_vec(),
        working_folder: env::current_dir().unwrap_or_default(),
        ament_prefixes: folders("AMENT_PREFIX_PATH"),
        ros_folders: folders("ROS_PACKAGE_PATH"),
    }
}

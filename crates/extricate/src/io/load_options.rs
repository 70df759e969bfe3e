//! Limits and packages for loading scenes. Only this file reads the environment.

use std::env;
use std::path::{Path, PathBuf};

use super::files::read_within;
use crate::interface::setters;
use crate::robot::formats::xml::{decoded, package_name};
use crate::robot::packages::{PackageSearch, PackageUri};
use crate::robot::{LoadLimit, LoadLimits};

/// How a scene is loaded.
///
/// ```
/// use extricate::{LoadOptions, load_scene_with};
/// let options = LoadOptions::default().packages(vec!["ws/src".into()]);
/// assert!(load_scene_with("missing.urdf", &options).is_err());
/// ```
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Limits on the contents of files.
    pub limits: LoadLimits,
    /// Folders in which packages of `package://` addresses are looked up first. After them come
    /// those that a scene file names, those that the URDF lies in, and those of `AMENT_PREFIX_PATH`
    /// and `ROS_PACKAGE_PATH`.
    pub packages: Vec<PathBuf>,
}

setters! { LoadOptions { limits: LoadLimits, packages: Vec<PathBuf> } }

/// Returns the folder of a package that the file `near` names, found as meshes of URDFs are; the
/// folders `given` come first.
pub fn find_package(package: &str, near: &Path, given: &[PathBuf]) -> Option<PathBuf> {
    PackageUri { package, rest: "" }.check().ok()?;
    let limits = LoadLimits::default();
    let name_of = |folder: &Path| {
        let bytes = read_within(&folder.join("package.xml"), &limits, LoadLimit::FileBytes).ok()?;
        package_name(&decoded(&bytes))
    };
    let folder = near.parent().unwrap_or(Path::new(""));
    let roots = package_search(given).roots(package, folder, &[], name_of);
    // A folder that only has the package's name, as repositories often do, may contain it.
    let is_package = |root: &&PathBuf| root.join("package.xml").is_file();
    roots.iter().find(is_package).or_else(|| roots.iter().find(|root| root.is_dir())).cloned()
}

/// Returns the folders in which this process finds packages: the folders `given`, those that URDFs
/// lie in, and those of ROS.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repository_called_like_its_package_is_not_the_package() {
        let folder = tempfile::tempdir().unwrap();
        let repository = folder.path().join("arm");
        let near = repository.join("arm_moveit");
        for inside in ["arm", "arm_moveit"] {
            std::fs::create_dir_all(repository.join(inside)).unwrap();
            let text = format!("<package><name>{inside}</name></package>");
            std::fs::write(repository.join(inside).join("package.xml"), text).unwrap();
        }
        let found = find_package("arm", &near.join("arm.xacro"), &[]).unwrap();
        assert_eq!(found.canonicalize().unwrap(), repository.join("arm").canonicalize().unwrap());
        // Without a package.xml, a folder of that name has to do.
        std::fs::remove_file(repository.join("arm").join("package.xml")).unwrap();
        let found = find_package("arm", &near.join("arm.xacro"), &[]).unwrap();
        assert!(found.ends_with("arm"), "{found:?}");
    }
}

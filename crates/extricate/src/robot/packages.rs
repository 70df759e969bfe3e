//! Where the package of a `package://` address may be: one rule for URDFs, xacro files and scenes.
//! Only makes paths; the caller passes in the function that reads `package.xml` files.

use std::path::{Component, Path, PathBuf};

use crate::error::{listed, quoted};

/// Folders to search for packages, besides those that a robot's entry in a scene names and those
/// above its URDF.
#[derive(Debug, Clone, Default)]
pub struct PackageSearch {
    /// Folders that the caller gave, which are searched first.
    pub given: Vec<PathBuf>,
    /// Folder from which relative paths start, so that the folders above it are known. If it is
    /// empty, they are not searched.
    pub working_folder: PathBuf,
    /// `AMENT_PREFIX_PATH`: a package is at `PREFIX/share/NAME`.
    pub ament_prefixes: Vec<PathBuf>,
    /// `ROS_PACKAGE_PATH`: a package is at `ENTRY/NAME`.
    pub ros_folders: Vec<PathBuf>,
}

/// A `package://` or `model://` address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PackageUri<'a> {
    /// Name of the package.
    pub package: &'a str,
    /// Path inside the package.
    pub rest: &'a str,
}

impl<'a> PackageUri<'a> {
    /// Parses an address; `None` for one of another kind. Some exporters write
    /// `package:///arm/a.stl`, which names the package `arm` too.
    pub fn of(uri: &'a str) -> Option<Self> {
        let path = uri.strip_prefix("package://").or_else(|| uri.strip_prefix("model://"))?;
        let path = path.trim_start_matches('/');
        let (package, rest) = path.split_once('/').unwrap_or((path, ""));
        Some(Self { package, rest: rest.trim_start_matches('/') })
    }

    /// Checks that the address stays inside its package.
    ///
    /// # Errors
    /// A package that is not the name of a folder, or a path that leaves it.
    pub fn check(&self) -> Result<(), String> {
        let mut parts = Path::new(self.package).components();
        if !matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None)) {
            return Err(format!("got the package `{}`, expected the name of a folder", quoted(self.package)));
        }
        let mut depth = 0_i64;
        for part in Path::new(self.rest).components() {
            depth += match part {
                Component::Normal(_) => 1,
                Component::CurDir => 0,
                _ => -1,
            };
            if depth < 0 {
                return Err(format!("got the path `{}`, expected one inside the package", quoted(self.rest)));
            }
        }
        Ok(())
    }
}

impl PackageSearch {
    /// Returns the folders that may be the package of a URDF in `folder`, likeliest first. They are
    /// in or at the given folders and those of the scene (`named`), then in or at those above the
    /// URDF, then where ROS keeps packages. `name_of` returns the package name in a folder's
    /// `package.xml`.
    pub fn roots(
        &self,
        package: &str,
        folder: &Path,
        named: &[PathBuf],
        mut name_of: impl FnMut(&Path) -> Option<String>,
    ) -> Vec<PathBuf> {
        let above = self.above(folder);
        let mut roots = Vec::new();
        for folder in self.given.iter().chain(named).chain(&above) {
            if is_called(folder, package) || name_of(folder).as_deref() == Some(package) {
                roots.push(folder.clone());
            }
            roots.extend([folder.join(package), folder.join("share").join(package)]);
        }
        roots.extend(self.ament_prefixes.iter().map(|prefix| prefix.join("share").join(package)));
        roots.extend(self.ros_folders.iter().map(|entry| entry.join(package)));
        roots
    }

    /// Lists the places that [`PackageSearch::roots`] tries, for messages.
    pub fn in_words(&self, folder: &Path, named: &[PathBuf]) -> String {
        let shown = |folders: &[PathBuf], none: &str| match folders {
            [] => none.to_string(),
            folders => listed(folders.iter().map(|folder| folder.display().to_string())),
        };
        let given: Vec<PathBuf> = self.given.iter().chain(named).cloned().collect();
        let above = match &self.above(folder)[..] {
            [nearest, .., _] => format!("{} and the folders above it", quoted(&nearest.display().to_string())),
            few => shown(few, "none"),
        };
        format!(
            "`packages`: {}; the URDF's folders: {above}; AMENT_PREFIX_PATH: {}; ROS_PACKAGE_PATH: {}",
            shown(&given, "none"),
            shown(&self.ament_prefixes, "not set"),
            shown(&self.ros_folders, "not set"),
        )
    }

    /// Returns `folder` and the folders above it, the innermost first.
    fn above(&self, folder: &Path) -> Vec<PathBuf> {
        let mut whole = PathBuf::new();
        for part in self.working_folder.join(folder).components() {
            match part {
                Component::ParentDir if whole.file_name().is_some() => drop(whole.pop()),
                Component::CurDir => {}
                part => whole.push(part),
            }
        }
        whole.ancestors().filter(|folder| !folder.as_os_str().is_empty()).map(Path::to_path_buf).collect()
    }
}

/// Returns the path that the address of a file names: without `file://`, and with slashes for the
/// backslashes that programs on Windows write. `file:///C:/arm.stl` is on the drive `C:`.
pub fn file_path(uri: &str) -> String {
    let path = uri.replace('\\', "/");
    let path = path.strip_prefix("file://").unwrap_or(&path);
    let is_on_drive = matches!(path.as_bytes(), [b'/', drive, b':', ..] if drive.is_ascii_alphabetic());
    path[usize::from(is_on_drive)..].to_string()
}

fn is_called(folder: &Path, name: &str) -> bool {
    folder.file_name().is_some_and(|own| own == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search() -> PackageSearch {
        PackageSearch {
            given: vec!["g".into()],
            working_folder: "/w".into(),
            ament_prefixes: vec!["/opt/ros".into()],
            ros_folders: vec!["/r1".into(), "/r2".into()],
        }
    }

    fn roots(search: &PackageSearch, folder: &str, named: &[&str], package_xml: &str) -> Vec<String> {
        let named: Vec<PathBuf> = named.iter().map(PathBuf::from).collect();
        let name_of = |folder: &Path| (folder == Path::new(package_xml)).then(|| "arm".to_string());
        let roots = search.roots("arm", Path::new(folder), &named, name_of);
        roots.iter().map(|root| root.display().to_string().replace('\\', "/")).collect()
    }

    #[test]
    fn packages_are_looked_for_in_order() {
        assert_eq!(
            roots(&search(), "x/../v/./urdf", &["n"], "/w/v"),
            [
                "g/arm",
                "g/share/arm",
                "n/arm",
                "n/share/arm",
                "/w/v/urdf/arm",
                "/w/v/urdf/share/arm",
                "/w/v",
                "/w/v/arm",
                "/w/v/share/arm",
                "/w/arm",
                "/w/share/arm",
                "/arm",
                "/share/arm",
                "/opt/ros/share/arm",
                "/r1/arm",
                "/r2/arm",
            ]
        );
        let none = PackageSearch::default();
        assert_eq!(
            roots(&none, "arm/urdf", &[], ""),
            ["arm/urdf/arm", "arm/urdf/share/arm", "arm", "arm/arm", "arm/share/arm"]
        );
        assert!(roots(&none, "", &[], "").is_empty());
        let words = search().in_words(Path::new("v"), &["n".into()]);
        assert_eq!(
            words.replace('\\', "/"),
            "`packages`: g, n; the URDF's folders: /w/v and the folders above it; AMENT_PREFIX_PATH: /opt/ros; \
             ROS_PACKAGE_PATH: /r1, /r2"
        );
    }

    #[test]
    fn addresses_of_windows_are_paths() {
        for (uri, path) in [
            ("file:///C:/m/a.stl", "C:/m/a.stl"),
            ("file:///C:\\m\\a.stl", "C:/m/a.stl"),
            ("C:\\m\\a.stl", "C:/m/a.stl"),
            ("m\\a.stl", "m/a.stl"),
            ("\\\\host\\share\\a.stl", "//host/share/a.stl"),
            ("file:///m/a.stl", "/m/a.stl"),
            ("file:///m:/a.stl/b", "m:/a.stl/b"),
            ("/m", "/m"),
            ("", ""),
        ] {
            assert_eq!(file_path(uri), path, "{uri}");
        }
    }

    #[test]
    fn addresses_do_not_leave_their_package() {
        for uri in ["package://arm/m/a.stl", "package:///arm/m/a.stl", "model://arm//m/a.stl"] {
            assert_eq!(PackageUri::of(uri), Some(PackageUri { package: "arm", rest: "m/a.stl" }), "{uri}");
        }
        assert_eq!(PackageUri::of("m/a.stl"), None);
        let check = |uri: &'static str| PackageUri::of(uri).unwrap().check();
        for uri in ["package://arm", "package://arm/m/../n/a.stl", "package://arm/./a.stl"] {
            assert_eq!(check(uri), Ok(()), "{uri}");
        }
        for uri in ["package://../a.stl", "package://./a.stl", "package://", "package://arm/../b/a.stl"] {
            assert!(check(uri).unwrap_err().contains("expected"), "{uri}");
        }
    }
}

//! The scene file format (TOML), as users write it.
//!
//! ```toml
//! clearance = 1e-4                  # [m], the default | { world = 0.02, self = 1e-4 }: pairs with obstacles, other pairs
//! padding = { LINK = 0.01 }         # added toward obstacles
//! metric = { kind = "joint" }       # joint | object-norm | max-displacement
//!                                   # joint takes weights = { JOINT = w or [translation, rotation] }
//! [[robot]]
//! urdf = "../robots/panda/panda.urdf"
//! name = "panda"                    # optional: qualifies names, as in panda/link0; default: the URDF's name
//! srdf = "../robots/panda/panda.srdf"        # optional: disables pairs and defines groups
//! group = "arm"                     # optional: an SRDF group; other joints are locked, at `locked` or nearest to 0
//! packages = ["../robots"]          # folders where package:// is looked up, before those above the URDF
//! geometry = "mesh"                 # mesh (default) | convex-hull: every mesh of this robot becomes its convex hull
//!                                   # | convex-parts: several convex hulls that cover it | visual
//! links = { LINK = "convex-parts" } # mesh, convex-hull or convex-parts for some links
//! base = "planar"                   # fixed (default) | planar | floating, relative to `pose`
//! bounds = { min = [-1, -1], max = [1, 1] }  # planar: x, y and optionally yaw; floating: x, y, z
//! pose = { xyz = [0, 0, 0], rpy = [0, 0, 0] }
//!                                   # or quat_xyzw = [x, y, z, w], or quat_wxyz = [w, x, y, z]
//! locked = { JOINT = 0.02 }         # rad or m
//! limits = { JOINT = [-1, 1], OTHER = { min = [-1, -1], max = [1, 1] } }  # replace the URDF's
//!
//! [[obstacle]]
//! name = "box"
//! shape = { box = [0.2, 0.6, 0.4] } # full sides | { sphere = r } | { cylinder = [r, length] } | { capsule = [r, length] }
//!                                   # | { mesh = "part.stl", scale = 1.0 or [x, y, z], convex = true }, or convex-parts
//!                                   # | { urdf = "table.urdf", packages = [".."], geometry = "mesh" }: nothing in it moves
//!                                   # | { points = "cloud.xyz" or [[x, y, z], ..], radius = r }
//!                                   # | { voxels = "cells.csv" or [[i, j, k], ..], size = s }
//!                                   # | { half-space = [nx, ny, nz], offset = d }
//!                                   # | { height-field = "heights.csv" or [[h, ..], ..], size = s }
//! pose = { xyz = [0.45, 0, 0.45], rpy = [0, 0, 0] }
//!
//! [[attached]]                      # held by a link: moves with it
//! name = "can"
//! link = "hand"
//! shape = { cylinder = [0.03, 0.1] }
//! pose = { xyz = [0, 0, 0.1] }      # in the link's coordinates
//! touch = ["finger_left", "finger_right"]    # not checked against these
//!
//! [pairs]
//! disable = [["link_a", "link_b"], ["robot/link", "obstacle"]]
//! enable = [["palm", "finger"]]      # checked although one joint joins them, or an SRDF disables them
//! clearance = [["link_a", "link_c", 1e-4]]   # [m], overrides all other clearances
//! ```
//! Paths are relative to the scene file.

pub mod arrays;
pub mod limits;
pub mod pose_entry;
pub mod shape_entry;
pub mod toml_errors;
pub mod world_file;

use std::collections::BTreeMap;

use serde::Deserialize;

use super::clearances::ClearanceEntry;
use super::metric_kind::MetricKind;
use crate::error::{Error, Result};
use crate::math::FARTHEST;
use crate::robot::packages::PackageSearch;
use crate::robot::{LoadLimit, LoadLimits, TriangleMesh};
use arrays::{exactly, pairs_of_names};
use limits::{BoundsEntry, LimitsEntry};
pub use pose_entry::PoseEntry;
pub use shape_entry::{RowsEntry, ShapeEntry};
use toml_errors::explain;

/// A whole scene file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Least distance that checked pairs keep; 1e-4 m if absent.
    pub clearance: Option<ClearanceEntry>,
    /// Metric of the configuration space; the joint metric if absent.
    pub metric: Option<MetricEntry>,
    /// The robots, in the order of their coordinates.
    #[serde(default)]
    pub robot: Vec<RobotEntry>,
    /// Obstacles, which do not move.
    #[serde(default)]
    pub obstacle: Vec<ObstacleEntry>,
    /// Objects that links hold.
    #[serde(default)]
    pub attached: Vec<AttachedEntry>,
    /// Pairs that are disabled, enabled in spite of a rule, or have a clearance of their own.
    #[serde(default)]
    pub pairs: PairsEntry,
    /// Length \[m\] by name that a link adds to its clearance toward obstacles, or an obstacle to
    /// that of all its pairs.
    #[serde(default)]
    pub padding: BTreeMap<String, f64>,
    /// Cuts meshes into convex parts; `io` sets it, as `scene` may not use `collision`.
    #[serde(skip)]
    #[doc(hidden)]
    pub cut: Option<CutMesh>,
    /// Limits on what the named files may hold; the caller sets them.
    #[serde(skip)]
    pub limits: LoadLimits,
    /// Folders of packages beside the `packages` of robots; the caller sets them.
    #[serde(skip)]
    pub search: PackageSearch,
}

/// Returns convex hulls that together cover a mesh, and an estimate of how far they stick out of
/// it \[m\].
pub type CutMesh = fn(&TriangleMesh) -> (Vec<TriangleMesh>, f64);

/// `metric = { kind = .., weights = .. }` of a scene file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table `{ kind = .., weights = .. }`")]
pub struct MetricEntry {
    /// The metric; `joint` if absent.
    #[serde(default = "default_metric")]
    pub kind: MetricKind,
    /// Weights of squared displacements by joint, 1 for others; only the joint metric uses them.
    #[serde(default)]
    pub weights: BTreeMap<String, WeightEntry>,
}

fn default_metric() -> MetricKind {
    MetricKind::Joint
}

impl Default for MetricEntry {
    fn default() -> Self {
        Self { kind: default_metric(), weights: BTreeMap::new() }
    }
}

/// The weight of one joint.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected a number, or [translation, rotation] for a joint that has both")]
pub enum WeightEntry {
    /// One weight for all its coordinates.
    Uniform(f64),
    /// Weights of its translations and of its rotation.
    Split(#[serde(deserialize_with = "exactly")] [f64; 2]),
}

/// `[[robot]]` of a scene file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotEntry {
    /// Path of the URDF file.
    pub urdf: String,
    /// Qualifies the names of its links and joints; the URDF's name if absent.
    pub name: Option<String>,
    /// Path of the SRDF file.
    pub srdf: Option<String>,
    /// SRDF group whose joints move; the others are locked.
    pub group: Option<String>,
    /// Folders where `package://` is looked up first.
    #[serde(default)]
    pub packages: Vec<String>,
    /// Kind of its shapes, and treatment of their meshes.
    #[serde(default)]
    pub geometry: GeometryKind,
    /// Treatment of the meshes of single links, by name.
    #[serde(default)]
    pub links: BTreeMap<String, GeometryKind>,
    /// How its root link may move, relative to `pose`.
    #[serde(default)]
    pub base: BaseKind,
    /// Limits of a moving base [m, rad].
    pub bounds: Option<BoundsEntry>,
    /// Pose of the root link in the world; a moving base moves relative to it.
    #[serde(default)]
    pub pose: PoseEntry,
    /// Positions of joints that are locked, by name \[rad or m\].
    #[serde(default)]
    pub locked: BTreeMap<String, f64>,
    /// Limits that replace the URDF's or stand in for missing ones.
    #[serde(default)]
    pub limits: BTreeMap<String, LimitsEntry>,
}

/// Kind of a robot's shapes, and treatment of their meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GeometryKind {
    /// Collision shapes with their meshes as they are.
    #[default]
    Mesh,
    /// Each mesh becomes its convex hull.
    ConvexHull,
    /// Each mesh becomes several convex hulls that cover it.
    ConvexParts,
    /// Shapes of `<visual>` instead of `<collision>` elements, with their meshes as they are.
    Visual,
}

/// How a robot's root link may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BaseKind {
    /// The root link does not move.
    #[default]
    Fixed,
    /// Its coordinates are x, y \[m\] and yaw \[rad\].
    Planar,
    /// Its coordinates are x, y, z \[m\] and a unit quaternion x, y, z, w.
    Floating,
}

/// `[[obstacle]]` of a scene file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleEntry {
    /// Name, unique among obstacles, links and attached objects.
    pub name: String,
    /// Shape in its own coordinates.
    pub shape: ShapeEntry,
    /// Pose of the shape in the world.
    #[serde(default)]
    pub pose: PoseEntry,
}

/// `[[attached]]`: an object that a link holds.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttachedEntry {
    /// Name, unique among obstacles, links and attached objects.
    pub name: String,
    /// Name of the link, which needs no geometry.
    pub link: String,
    /// Shape in its own coordinates.
    pub shape: ShapeEntry,
    /// Pose of the shape in the link's coordinates.
    #[serde(default)]
    pub pose: PoseEntry,
    /// Names of links, obstacles and attached objects that it is not checked against.
    #[serde(default)]
    pub touch: Vec<String>,
}

/// How a mesh is scaled.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected a number or [x, y, z]")]
pub enum ScaleEntry {
    /// One factor for every axis.
    Uniform(f64),
    /// Factors along x, y and z.
    Axes(#[serde(deserialize_with = "exactly")] [f64; 3]),
}

/// `[pairs]` of a scene file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairsEntry {
    /// Pairs of names that are not checked, in addition to those of SRDFs.
    #[serde(default, deserialize_with = "pairs_of_names")]
    pub disable: Vec<[String; 2]>,
    /// Pairs of names that are checked although one joint joins them or an SRDF disables them.
    #[serde(default, deserialize_with = "pairs_of_names")]
    pub enable: Vec<[String; 2]>,
    /// Clearance of pairs of names \[m\]; it overrides all others and padding.
    #[serde(default)]
    pub clearance: Vec<(String, String, f64)>,
}

/// Parses the `text` of a scene file; `file` is its name in messages.
///
/// # Errors
/// [`Error::Input`] with line and column if the text is not TOML, has an unknown key or a value of
/// the wrong type. [`Error::Input`] also if a clearance or padding is outside 0 to 1e9 m.
pub fn parse(file: &str, text: &str) -> Result<SceneFile> {
    parse_within(file, text, &LoadLimits::default())
}

/// As [`parse`], within limits; they also apply to the files that the scene names.
///
/// # Errors
/// As [`parse`], and if the text exceeds the limits.
pub fn parse_within(file: &str, text: &str, limits: &LoadLimits) -> Result<SceneFile> {
    limits.check(LoadLimit::TextBytes, text.len(), file, "file")?;
    limits.check(LoadLimit::Values, most_values(text), file, "scene")?;
    let scene: SceneFile = toml::from_str(text).map_err(|error| explain(file, text, &error))?;
    scene.check(file)?;
    Ok(SceneFile { limits: limits.clone(), ..scene })
}

/// Returns a bound on the number of values in a text in TOML or JSON: one of these characters sets
/// off each. Block lists in YAML escape it; the limits of the YAML parser count those.
pub fn most_values(text: &str) -> usize {
    text.bytes().filter(|byte| matches!(byte, b',' | b'=' | b'[' | b'{' | b':')).count()
}

impl SceneFile {
    /// Checks clearances and padding, which need no other part of the scene.
    ///
    /// # Errors
    /// [`Error::Input`] for a length outside 0 to 1e9 m.
    pub fn check(&self, file: &str) -> Result<()> {
        let (world, own) = self.clearance.unwrap_or_default().lengths();
        let of_scene = [("clearance", Some(world)), ("clearance: self", own)];
        let of_scene = of_scene.into_iter().filter_map(|(element, length)| Some((element.to_string(), length?)));
        let of_pair = |(a, b, length): &(String, String, f64)| (format!("pairs: clearance [{a:?}, {b:?}]"), *length);
        let padding = self.padding.iter().map(|(name, length)| (format!("padding: {name}"), *length));
        let mut lengths = of_scene.chain(self.pairs.clearance.iter().map(of_pair)).chain(padding);
        match lengths.find(|(_, length)| !(0.0..=FARTHEST).contains(length)) {
            None => Ok(()),
            Some((element, bad)) => Err(Error::input(file, element, format!("got {bad}, expected 0 to 1e9 [m]"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse("s.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn everything_in_the_format_is_read() {
        let scene = parse(
            "s.toml",
            r#"
            metric = { kind = "joint", weights = { a = 2, base = [1, 0.5] } }
            [[robot]]
            urdf = "a.urdf"
            base = "planar"
            bounds = { min = [-1, -1], max = [1, 1] }
            limits = { a = [0, 1], b = { min = [0], max = [1] } }
            [[obstacle]]
            name = "part"
            shape = { mesh = "part.stl", scale = [1, 2, 3], convex = true }
            [[obstacle]]
            name = "box"
            shape = { box = [1, 2, 3] }
            pose = { xyz = [0, 0, 1] }
            [pairs]
            disable = [["a", "b"]]
            enable = [["b", "c"]]
            "#,
        )
        .unwrap();
        assert!(scene.clearance.is_none());
        assert!(matches!(scene.metric.unwrap().weights["base"], WeightEntry::Split([1.0, 0.5])));
        assert!(matches!(scene.robot[0].limits["a"], LimitsEntry::Interval([0.0, 1.0])));
        assert!(matches!(scene.obstacle[0].shape.scale, Some(ScaleEntry::Axes([1.0, 2.0, 3.0]))));
        assert_eq!(scene.obstacle[1].pose.xyz, [0.0, 0.0, 1.0]);
        assert_eq!(scene.pairs.disable, [["a".to_string(), "b".to_string()]]);
        assert_eq!(scene.pairs.enable, [["b".to_string(), "c".to_string()]]);
    }

    #[test]
    fn messages_name_place_and_alternatives() {
        let unknown = message("clearance = 0.1\nclerance = 2");
        assert!(unknown.contains("line 2, column 1") && unknown.contains("`clerance`"), "{unknown}");
        assert!(unknown.contains("`clearance`") && unknown.contains("`obstacle`"), "{unknown}");
        assert!(message("[[robot]]\nurdf = 'a'\nbase = 'flying'").contains("`floating`"));
        assert!(message("metric = { kind = 'euclid' }").contains("`object-norm`"));
        assert!(message("metric = { weights = { a = 'x' } }").contains("[translation, rotation]"));
        assert!(message("[[robot]]\nurdf = 'a'\nlimits = { a = 1 }").contains("[lower, upper]"));
        assert!(message("[[robot]]\nurdf = 'a'\n= 1").contains("line 3"));
        assert!(message("[[robot]]\nname = 'a'").contains("`urdf`"));
        assert!(message("clearance = -1").contains("got -1, expected 0 to 1e9"));
        assert!(message("clearance = nan").contains("NaN"));
    }
}

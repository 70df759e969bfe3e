//! Converts `Robot` and the obstacles of Python to the entries of a scene file, which the library
//! checks and assembles.

pub mod clearance;
pub mod lists;
pub mod meshes;
pub mod pose;
pub mod scenery;

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

use extricate::entries::{
    BaseKind, BoundsEntry, GeometryKind, LimitsEntry, MetricEntry, ObstacleEntry, PairsEntry, PoseEntry, RobotEntry,
    SceneFile, ShapeEntry, WeightEntry,
};
use extricate::parts::PackageSearch;
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

use crate::error::exception;
use crate::rows::arrays::{floats, numbers, tuple};
use clearance::{Clearance, length};
use lists::Folders;
use meshes::{fixture, mesh};
use pose::pose;

/// Name, in messages, of a scene that was made in Python.
pub const NAME: &str = "scene";

/// The entries of a scene, and the texts in place of files that they name.
pub struct Description {
    pub entries: SceneFile,
    /// The name and the content of each text.
    pub texts: Vec<(String, String)>,
}

/// The argument `obstacles`, any iterable of Python objects.
#[derive(Default)]
pub struct Obstacles<'py>(pub Vec<Bound<'py, PyAny>>);

impl<'py> FromPyObject<'_, 'py> for Obstacles<'py> {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong =
            |_| PyTypeError::new_err(format!("obstacles: got {}, expected a list of Box, Sphere, ...", kind(&value)));
        Ok(Self(value.try_iter().map_err(wrong)?.collect::<PyResult<_>>()?))
    }
}

/// The arguments of `Scene` besides robots and obstacles.
pub struct Options<'py> {
    pub clearance: Clearance,
    /// `joint`, `object-norm` or `max-displacement`.
    pub metric: String,
    /// Weights by joint: one number, or one for translations and one for the rotation.
    pub weights: Option<Bound<'py, PyMapping>>,
    /// Pairs of bodies that are not checked.
    pub disable: Vec<[String; 2]>,
    /// Pairs of bodies that are checked although a rule of the scene disables them.
    pub enable: Vec<[String; 2]>,
    /// Padding by body \[m\].
    pub padding: Option<Bound<'py, PyMapping>>,
    /// Pairs of bodies with a clearance of their own \[m\].
    pub pair_clearance: Vec<(String, String, f64)>,
    /// Folders in which packages are looked up first.
    pub packages: Vec<PathBuf>,
}

/// Reads the arguments of `Scene`.
///
/// # Errors
/// `TypeError` for a value of the wrong type, `ValueError` for one of the wrong shape; both say
/// what was expected.
pub fn describe(
    robots: &Bound<'_, PyAny>,
    obstacles: &[Bound<'_, PyAny>],
    options: Options<'_>,
) -> PyResult<Description> {
    let mut texts = Vec::new();
    let is_one = robots.hasattr("urdf")? || text_or_path(robots).is_ok();
    let list: Vec<Bound<'_, PyAny>> = if is_one {
        vec![robots.clone()]
    } else {
        let expected = || format!("robot: got {}, expected a URDF (path or text), a Robot or a list", kind(robots));
        robots.extract().map_err(|_| PyTypeError::new_err(expected()))?
    };
    let robot = list.iter().enumerate().map(|(at, r)| robot_entry(at, r, &mut texts)).collect::<PyResult<_>>()?;
    // A robot of another simulator may bring the obstacles around it.
    let brought = |name: &str| -> PyResult<Vec<Bound<'_, PyAny>>> {
        let with = list.iter().filter(|robot| robot.hasattr(name).unwrap_or(false));
        Ok(with.map(|robot| robot.getattr(name)?.extract()).collect::<PyResult<Vec<Vec<_>>>>()?.concat())
    };
    let [disable, enable] = both_pairs([options.disable, options.enable], &list)?;
    let mut all = brought("obstacles")?;
    all.extend(obstacles.iter().cloned());
    let entries = obstacle_entries(&all, Vec::new())?;
    let metric = options.metric.parse().map_err(exception)?;
    let weight = |element: &str, value: &Bound<'_, PyAny>| match floats(element, value)?[..] {
        [all] => Ok(WeightEntry::Uniform(all)),
        [translation, rotation] => Ok(WeightEntry::Split([translation, rotation])),
        _ => Err(PyValueError::new_err(format!("{element}: expected a number or (translation, rotation)"))),
    };
    let weights = options.weights.map_or(Ok(BTreeMap::new()), |weights| by_name("weights", &weights, weight))?;
    let entries = SceneFile {
        clearance: Some(options.clearance.entry()),
        metric: Some(MetricEntry { kind: metric, weights }),
        robot,
        obstacle: entries,
        attached: Vec::new(),
        pairs: PairsEntry { disable, enable, clearance: options.pair_clearance },
        cut: None,
        limits: extricate::LoadLimits::default(),
        search: PackageSearch { given: options.packages, ..PackageSearch::default() },
        padding: options.padding.map_or(Ok(BTreeMap::new()), |padding| by_name("padding", &padding, length))?,
    };
    Ok(Description { entries, texts })
}

/// Returns the pairs to disable and those to enable: all of the caller, and those that robots of
/// another simulator bring, unless the caller names the same pair.
fn both_pairs(mut both: [Vec<[String; 2]>; 2], robots: &[Bound<'_, PyAny>]) -> PyResult<[Vec<[String; 2]>; 2]> {
    let all_said = both.concat();
    for robot in robots {
        for (at, attribute) in ["disable", "enable"].into_iter().enumerate() {
            if !robot.hasattr(attribute).unwrap_or(false) {
                continue;
            }
            // The caller may write `robot/link` for a link.
            let prefix = name_of(robot)?.map(|name| format!("{name}/")).unwrap_or_default();
            let plain = |pair: &[String; 2]| {
                let mut pair = pair.clone().map(|name| name.strip_prefix(&prefix).unwrap_or(&name).to_owned());
                pair.sort();
                pair
            };
            let said: HashSet<[String; 2]> = all_said.iter().map(plain).collect();
            let brought: Vec<[String; 2]> = robot.getattr(attribute)?.extract()?;
            both[at].extend(brought.into_iter().filter(|pair| !said.contains(&plain(pair))));
        }
    }
    Ok(both)
}

/// Returns the name of a robot: its own, or that in the first element of its URDF text.
fn name_of(robot: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
    if let Some(name) = robot.getattr("name")?.extract()? {
        return Ok(Some(name));
    }
    let urdf = text_or_path(&robot.getattr("urdf")?)?;
    let named = urdf.strip_prefix("<robot name=\"").and_then(|rest| rest.split_once('"'));
    Ok(named.map(|(name, _)| name.to_owned()))
}

/// Returns the entries of obstacles. Those without a name get one that is not in `taken`.
///
/// # Errors
/// As [`describe`].
pub fn obstacle_entries(obstacles: &[Bound<'_, PyAny>], mut taken: Vec<String>) -> PyResult<Vec<ObstacleEntry>> {
    let mut entries = Vec::with_capacity(obstacles.len());
    for (at, given) in obstacles.iter().enumerate() {
        entries.push(obstacle_entry(at + 1, given, &taken)?);
        taken.push(entries[at].name.clone());
    }
    Ok(entries)
}

fn robot_entry(at: usize, given: &Bound<'_, PyAny>, texts: &mut Vec<(String, String)>) -> PyResult<RobotEntry> {
    let number = at + 1;
    let mut source = |what: &str, value: &Bound<'_, PyAny>| -> PyResult<String> {
        let text = text_or_path(value)
            .map_err(|_| PyTypeError::new_err(format!("{what}: got {}, expected a path or XML text", kind(value))))?;
        if !text.trim_start().starts_with('<') {
            return Ok(text);
        }
        let name = format!("{what} of robot {number}");
        texts.push((name.clone(), text));
        Ok(name)
    };
    if text_or_path(given).is_ok() {
        return Ok(plain_robot(source("urdf", given)?));
    }
    if !given.hasattr("urdf")? {
        let found = kind(given);
        return Err(PyTypeError::new_err(format!(
            "robot {number}: got {found}, expected a URDF (path or text) or a Robot"
        )));
    }
    let get = |name: &str| given.getattr(name);
    let optional = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> { Ok(Some(get(name)?).filter(|v| !v.is_none())) };
    let mut entry = plain_robot(source("urdf", &get("urdf")?)?);
    entry.name = get("name")?.extract()?;
    entry.group = get("group")?.extract()?;
    entry.srdf = optional("srdf")?.map(|srdf| source("srdf", &srdf)).transpose()?;
    entry.packages = folders("packages", &get("packages")?)?;
    entry.geometry = geometry("geometry", &get("geometry")?)?;
    entry.base = match get("base")?.extract::<String>()?.as_str() {
        "fixed" => BaseKind::Fixed,
        "planar" => BaseKind::Planar,
        "floating" => BaseKind::Floating,
        other => return Err(unknown("base", other, &["fixed", "planar", "floating"])),
    };
    entry.bounds = optional("bounds")?.map(|value| bounds("bounds", &value)).transpose()?;
    entry.pose = pose("pose", &get("pose")?)?;
    let mapping = |name: &str| -> PyResult<Bound<'_, PyMapping>> {
        let value = get(name)?;
        let found = kind(&value);
        value.cast_into().map_err(|_| PyTypeError::new_err(format!("{name}: got {found}, expected a dict by joint")))
    };
    entry.locked = by_name("locked", &mapping("locked")?, |element, value| match floats(element, value)?[..] {
        [position] => Ok(position),
        _ => Err(PyValueError::new_err(format!("{element}: expected one number [rad or m]"))),
    })?;
    entry.limits = by_name("limits", &mapping("limits")?, limits)?;
    entry.links = by_name("links", &mapping("links")?, geometry)?;
    Ok(entry)
}

/// Reads a list of folders into the form of a scene file.
///
/// # Errors
/// As [`describe`].
pub fn folders(element: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    value.extract::<Folders>()?.of(element)?.into_iter().map(unicode).collect()
}

/// Reads the option that says how meshes are used.
///
/// # Errors
/// `ValueError` for an unknown word.
pub fn geometry(element: &str, value: &Bound<'_, PyAny>) -> PyResult<GeometryKind> {
    match value.extract::<String>()?.as_str() {
        "mesh" => Ok(GeometryKind::Mesh),
        "convex-hull" => Ok(GeometryKind::ConvexHull),
        "convex-parts" => Ok(GeometryKind::ConvexParts),
        "visual" => Ok(GeometryKind::Visual),
        other => Err(unknown(element, other, &["mesh", "convex-hull", "convex-parts", "visual"])),
    }
}

fn plain_robot(urdf: String) -> RobotEntry {
    RobotEntry {
        urdf,
        name: None,
        srdf: None,
        group: None,
        packages: Vec::new(),
        geometry: GeometryKind::default(),
        links: BTreeMap::new(),
        base: BaseKind::default(),
        bounds: None,
        pose: PoseEntry::default(),
        locked: BTreeMap::new(),
        limits: BTreeMap::new(),
    }
}

/// Returns the entry of one obstacle: `number` is its place from 1, `taken` are names to avoid.
fn obstacle_entry(number: usize, given: &Bound<'_, PyAny>, taken: &[String]) -> PyResult<ObstacleEntry> {
    let class = kind(given);
    let has = |name: &str| given.hasattr(name).unwrap_or(false);
    if !has("pose") || !has("name") {
        return Err(PyTypeError::new_err(format!(
            "obstacle {number}: got {class}, expected Box, Sphere, Cylinder, Capsule, Mesh, Fixture, Points, Voxels, HalfSpace or HeightField"
        )));
    }
    let name = match given.getattr("name")?.extract::<Option<String>>()? {
        Some(name) => name,
        // The name of the class, with the first number that is free.
        None => {
            (number..).map(|k| format!("{}{k}", class.to_lowercase())).find(|n| !taken.contains(n)).expect("endless")
        }
    };
    let size = |what: &str| -> PyResult<f64> {
        let element = format!("obstacle \"{name}\": {what}");
        match floats(&element, &given.getattr(what)?)?[..] {
            [size] => Ok(size),
            _ => Err(PyValueError::new_err(format!("{element}: expected one number [m]"))),
        }
    };
    let mut shape = ShapeEntry::default();
    match class.as_str() {
        "Box" => {
            let element = format!("obstacle \"{name}\": size");
            let sides = floats(&element, &given.getattr("size")?)?;
            let wrong = |_| PyValueError::new_err(format!("{element}: expected the three full sides (x, y, z) [m]"));
            shape.cuboid = Some(sides.try_into().map_err(wrong)?);
        }
        "Sphere" => shape.sphere = Some(size("radius")?),
        "Cylinder" => shape.cylinder = Some([size("radius")?, size("length")?]),
        "Capsule" => shape.capsule = Some([size("radius")?, size("length")?]),
        "Mesh" => mesh(&format!("obstacle \"{name}\""), given, &mut shape)?,
        "Fixture" => fixture(&format!("obstacle \"{name}\""), given, &mut shape)?,
        _ => {
            let Some((scenery, left_out)) = scenery::geometry(&class, &format!("obstacle \"{name}\""), given)? else {
                let problem = format!("obstacle \"{name}\": got {class}, expected Box, Sphere, ...");
                return Err(PyTypeError::new_err(problem));
            };
            (shape.scenery, shape.left_out) = (Some(scenery), left_out);
        }
    }
    let pose = pose(&format!("obstacle \"{name}\": pose"), &given.getattr("pose")?)?;
    Ok(ObstacleEntry { name, shape, pose })
}

fn limits(element: &str, value: &Bound<'_, PyAny>) -> PyResult<LimitsEntry> {
    let both = bounds(element, value)?;
    match (&both.min[..], &both.max[..]) {
        (&[lower], &[upper]) => Ok(LimitsEntry::Interval([lower, upper])),
        _ => Ok(LimitsEntry::Bounds(both)),
    }
}

/// Reads `(lower, upper)`: two numbers, or two sequences of them.
fn bounds(element: &str, value: &Bound<'_, PyAny>) -> PyResult<BoundsEntry> {
    let wrong = |_| PyTypeError::new_err(format!("{element}: got {}, expected (lower, upper)", kind(value)));
    let [min, max]: [Bound<'_, PyAny>; 2] = value.extract().map_err(wrong)?;
    Ok(BoundsEntry { min: floats(element, &min)?, max: floats(element, &max)? })
}

/// Reads the values of a dict by name.
///
/// # Errors
/// As [`describe`].
pub fn by_name<T>(
    what: &str,
    mapping: &Bound<'_, PyMapping>,
    read: impl Fn(&str, &Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<BTreeMap<String, T>> {
    let mut all = BTreeMap::new();
    for item in mapping.items()? {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let wrong = |_| PyTypeError::new_err(format!("{what}: got the key {name}, expected names"));
        let name: String = name.extract().map_err(wrong)?;
        let value = read(&format!("{what}[\"{name}\"]"), &value)?;
        all.insert(name, value);
    }
    Ok(all)
}

/// Reads an array of shape (n, 3).
pub fn rows_of_three(element: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let array = numbers(element, value)?;
    match array.shape() {
        [_, 3] => Ok(array.as_slice().expect("checked").chunks_exact(3).map(|r| [r[0], r[1], r[2]]).collect()),
        shape => Err(PyValueError::new_err(format!("{element}: got shape {}, expected (n, 3)", tuple(shape)))),
    }
}

/// Returns a `str` as it is, and an `os.PathLike` as its path.
///
/// # Errors
/// If `value` is neither, or the path is not Unicode.
pub fn text_or_path(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = value.cast::<PyString>() {
        return text.extract();
    }
    unicode(value.extract()?)
}

fn unicode(path: PathBuf) -> PyResult<String> {
    path.into_os_string()
        .into_string()
        .map_err(|path| PyValueError::new_err(format!("got the path {}, expected one that is Unicode", path.display())))
}

/// Makes the exception for a word that is none of the known ones.
pub fn unknown(what: &str, found: &str, known: &[&str]) -> PyErr {
    let known: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
    PyValueError::new_err(format!("{what}: got \"{found}\", expected {}", known.join(" or ")))
}

/// Returns the name of the class of `value`.
pub fn kind(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

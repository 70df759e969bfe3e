//! Assembles a resolved [`Scene`] from a scene file and the robots that it names.

pub mod bodies;
pub mod clearances;
pub mod coordinates;
pub mod fixtures;
pub mod frames;
pub mod joint_roles;
pub mod load;
pub mod loaded;
pub mod obstacles;
pub mod pairs;
pub mod sound;
pub mod workspace_radius;

use std::collections::BTreeMap;
use std::path::Path;

use super::file::{self, GeometryKind, RobotEntry, SceneFile};
use super::names::{NameIndex, Named, unique};
use super::suspicious_units::warn_of_sizes;
use super::{Body, LinkAttachment, MetricKind, Scene};
use crate::error::{Error, Result, bounded};
use crate::math::Pose;
use crate::robot::{Geometry, Link, LinkGeometry, LoadLimit};
use bodies::{OncePerMesh, link_bodies, refuse_vast, warn_of_surfaces};
use clearances::clearances_of;
use coordinates::coordinates;
use fixtures::read_others;
use frames::{FramePlacement, Tree};
use load::Files;
use loaded::LoadedRobot;
pub use loaded::ReadFile;
use obstacles::Others;
use pairs::{PairName, PairRules, SrdfNames, checked, pairs_of_scene};

/// Warning about a scene without checked pairs.
pub const NOTHING_CHECKED: &str = "no pair of bodies is checked: every configuration within the limits is free";

/// Parses the TOML `text` of the scene file at `path` and every file that it names.
///
/// # Errors
/// [`Error::Input`] that names the file, the element, the value and what was expected; errors of
/// `read`.
pub fn assemble(path: &Path, text: &str, read: ReadFile) -> Result<Scene> {
    assemble_entries(path, &file::parse(&path.display().to_string(), text)?, read)
}

/// As [`assemble`], for a scene that is already parsed or was built in code. Its paths are relative
/// to the folder of `path`.
///
/// # Errors
/// As [`assemble`].
pub fn assemble_entries(path: &Path, scene: &SceneFile, read: ReadFile) -> Result<Scene> {
    let name = path.display().to_string();
    scene.check(&name)?;
    let mut warnings = Vec::new();
    let mut files = Files::new(path, scene, read);
    let robots = files.robots(&scene.robot, &mut warnings)?;
    let others = read_others(&name, scene, true, &mut files, &mut warnings)?;
    warnings.extend(files.into_mesh_warnings());
    build(&name, scene, &robots, others, warnings)
}

/// A shape by which a link is seen. No check uses it.
#[derive(Debug, Clone)]
pub struct Visual {
    /// Name of the link in the scene.
    pub link: String,
    /// Maps coordinates of the shape to those of the link.
    pub pose_link_shape: Pose,
    /// The shape in its own coordinates.
    pub geometry: Geometry,
    /// Red, green, blue and opacity, each from 0 to 1; `None` if the URDF states no colour.
    pub rgba: Option<[f64; 4]>,
}

/// Reads the `<visual>` elements of the robots of a scene; all else is as in
/// [`assemble_entries`].
///
/// # Errors
/// As [`assemble_entries`], but no scene is built.
pub fn visuals(path: &Path, scene: &SceneFile, read: ReadFile) -> Result<Vec<Visual>> {
    let seen = |entry: &RobotEntry| RobotEntry {
        geometry: GeometryKind::Visual,
        links: BTreeMap::new(),
        srdf: None,
        group: None,
        ..entry.clone()
    };
    let entries: Vec<RobotEntry> = scene.robot.iter().map(seen).collect();
    let robots = Files::new(path, scene, read).robots(&entries, &mut Vec::new())?;
    let names = unique(&robots.iter().flat_map(link_names).collect::<Vec<_>>());
    let links = robots.into_iter().flat_map(|loaded| loaded.robot.links).zip(names);
    let of_link = |(link, name): (Link, String)| {
        let shape = move |LinkGeometry { pose_link_geometry, geometry, rgba }| Visual {
            link: name.clone(),
            pose_link_shape: pose_link_geometry,
            geometry,
            rgba,
        };
        link.collision.into_iter().map(shape)
    };
    Ok(links.flat_map(of_link).collect())
}

/// Builds a scene from parsed robots and obstacles without reading files; `file` is the name of the
/// scene file in messages.
pub fn build(
    file: &str,
    entry: &SceneFile,
    robots: &[LoadedRobot],
    Others { obstacles, attached }: Others,
    mut warnings: Vec<String>,
) -> Result<Scene> {
    if robots.is_empty() {
        return Err(Error::input(file, "robot", "got none, expected at least one [[robot]]"));
    }
    let named: Vec<Named> = robots.iter().flat_map(link_names).collect();
    let limits = &entry.limits;
    limits.check(LoadLimit::Links, named.len(), file, "robot")?;
    let linked = NameIndex::new(named.clone());
    if let Some(body) = obstacles.iter().chain(&attached).find(|body| linked.has_plain(&body.name)) {
        let kind = if obstacles.iter().any(|other| other.name == body.name) { "obstacle" } else { "attached" };
        let problem = "a link has the same name, expected a name of its own";
        return Err(Error::input(file, format!("{kind} \"{}\"", body.name), problem));
    }
    let metric = entry.metric.clone().unwrap_or_default();
    let coordinates = coordinates(file, &metric, robots, &obstacles, &mut warnings)?;
    let mut tree = Tree::default();
    let mut bodies: Vec<Body> = Vec::new();
    let mut link_names = unique(&named).into_iter();
    let mut links: Vec<LinkAttachment> = Vec::new();
    for (index, loaded) in robots.iter().enumerate() {
        let mut root =
            FramePlacement { frame: 0, pose_frame_link: loaded.entry.pose.pose(file, &loaded.element("placement"))? };
        let own = &coordinates.robots[index];
        if let Some(base) = &own.base {
            root = tree.attach(root, &base.mover());
        }
        let seats = tree.add_robot(&loaded.robot, root, &own.roles, &own.names, &own.places);
        let seats = all_seats(loaded, seats)?;
        let names: Vec<String> = link_names.by_ref().take(seats.len()).collect();
        refuse_scenery(loaded, &seats)?;
        bodies.extend(link_bodies(index, &loaded.robot, &seats, &names));
        links.extend(names.into_iter().zip(seats).map(|(name, seat)| LinkAttachment {
            name,
            frame: seat.frame,
            pose_frame_link: seat.pose_frame_link,
        }));
    }
    bodies.iter().try_for_each(|body| refuse_vast(file, body))?;
    bodies.extend(obstacles);
    for (object, entry) in attached.into_iter().zip(&entry.attached) {
        bodies.push(held(file, object, &entry.link, &linked, &links)?);
    }
    let mut known = OncePerMesh::default();
    bodies.iter().for_each(|body| warn_of_surfaces(body, &mut known, &mut warnings));

    if metric.kind != MetricKind::Joint && bodies.iter().all(|body| body.frame == 0) {
        let problem = "no link that moves has geometry whose displacement it could measure, expected kind = \"joint\"";
        return Err(Error::input(file, "metric", problem));
    }
    let names = pair_names(robots, &bodies);
    let index = NameIndex::new(names.iter().map(|name| name.named).collect());
    let rules = pair_rules(file, entry, robots, (&index, &names, &bodies), &mut warnings)?;
    let pairs = checked(&bodies, &tree.carriers, &rules, limits.get(LoadLimit::Pairs))
        .map_err(|found| Error::input(file, "pairs", limits.exceeded(LoadLimit::Pairs, found)))?;
    let clearances = clearances_of(entry, &|element, name| {
        let body = index.find(name).map_err(|problem| Error::input(file, element, problem))?;
        Ok(names[body].body.map(|body| bodies[body].name.clone()))
    })?;
    if pairs.is_empty() {
        warnings.push(NOTHING_CHECKED.into());
    }
    let (clearance, metric) = (entry.clearance.unwrap_or_default().lengths().0, metric.kind);
    let coordinates::Coordinates { joints, space, rigid, .. } = coordinates;
    let frames = tree.frames;
    let mut scene =
        Scene { clearance, metric, joints, space, frames, bodies, pairs, warnings, links, clearances, rigid };
    let others: Vec<Body> = scene.bodies.iter().filter(|body| body.robot.is_none()).cloned().collect();
    let mut warnings = std::mem::take(&mut scene.warnings);
    warn_of_sizes(&scene, &others, &mut warnings);
    Ok(Scene { warnings: bounded(warnings), ..scene })
}

/// Fixes an attached object to the frame of its link.
fn held(file: &str, object: Body, link: &str, names: &NameIndex, links: &[LinkAttachment]) -> Result<Body> {
    let element = format!("attached \"{}\": link", object.name);
    let seat = &links[names.find(link).map_err(|problem| Error::input(file, element, problem))?];
    Ok(object.on(seat))
}

fn link_names<'a>(loaded: &'a LoadedRobot) -> impl Iterator<Item = Named<'a>> {
    let robot = Some(loaded.name.as_str());
    loaded.robot.links.iter().map(move |link| Named { robot, name: &link.name })
}

/// Refuses planes on links that move: they are unbounded, and bounds on motion and moments do not
/// handle them.
fn refuse_scenery(loaded: &LoadedRobot, seats: &[FramePlacement]) -> Result<()> {
    let is_scenery = |link: &crate::robot::Link| link.collision.iter().any(|shape| shape.geometry.is_scenery());
    let mut links = loaded.robot.links.iter().zip(seats);
    let Some((link, _)) = links.find(|(link, seat)| seat.frame != 0 && is_scenery(link)) else { return Ok(()) };
    let problem = "got a <plane> on a link that moves, expected it on one that does not: a plane has no end, and what is \
                   behind it is solid; a <box> can move";
    Err(Error::input(&loaded.urdf, format!("link \"{}\"", link.name), problem))
}

fn all_seats(loaded: &LoadedRobot, seats: Vec<Option<FramePlacement>>) -> Result<Vec<FramePlacement>> {
    let links = loaded.robot.links.iter().zip(seats);
    let seat = |(link, seat): (&crate::robot::Link, Option<FramePlacement>)| {
        seat.ok_or_else(|| {
            let problem = "no chain of joints leads from the root link to it, expected one tree";
            Error::input(&loaded.urdf, format!("link \"{}\"", link.name), problem)
        })
    };
    links.map(seat).collect()
}

/// Lists everything that pairs may name. The order of `bodies` is links that have geometry, then
/// obstacles, then attached objects.
fn pair_names<'a>(robots: &'a [LoadedRobot], bodies: &'a [Body]) -> Vec<PairName<'a>> {
    let mut next = 0..bodies.len();
    let mut all = Vec::new();
    for loaded in robots {
        for (link, named) in loaded.robot.links.iter().zip(link_names(loaded)) {
            all.push(PairName { named, body: if link.collision.is_empty() { None } else { next.next() } });
        }
    }
    all.extend(next.map(|body| PairName { named: Named { robot: None, name: &bodies[body].name }, body: Some(body) }));
    all
}

fn pair_rules(
    file: &str,
    entry: &SceneFile,
    robots: &[LoadedRobot],
    (index, all, bodies): (&NameIndex, &[PairName], &[Body]),
    warnings: &mut Vec<String>,
) -> Result<PairRules> {
    let mut rules = PairRules::default();
    let names = SrdfNames::new(all);
    for (index, loaded) in robots.iter().enumerate() {
        rules.add_srdf((index, &loaded.name), &loaded.srdf, &names);
    }
    let find = |name: &str| index.find(name).map(|at| all[at].body);
    let (disabled, enabled) = pairs_of_scene(file, entry, &find, bodies, warnings)?;
    rules.add_scene(disabled, enabled);
    Ok(rules)
}

#[cfg(test)]
mod tests {
    use crate::robot::JointKind::*;
    use crate::robot::{Geometry, Robot};
    use crate::scene::Scene;
    use crate::scene::testing::{PLAIN, chain, scene, scene_with};

    const BALL: &str = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.5 }\n";

    fn pairs(scene: &Scene) -> Vec<String> {
        (0..scene.pairs.len()).map(|pair| scene.pair_names(crate::scene::PairId::new(pair)).join(" ")).collect()
    }

    #[test]
    fn first_links_are_checked_against_obstacles_but_not_against_the_base() {
        let arm = chain(&[Revolute, Fixed, Revolute]);
        let checked = pairs(&scene(&format!("{PLAIN}{BALL}"), std::slice::from_ref(&arm)).unwrap());
        assert_eq!(checked, ["l0 l3", "l1 ball", "l2 ball", "l3 ball"]);
        let text = format!("{PLAIN}{BALL}[pairs]\ndisable = [['l3', 'ball'], ['arm/l2', 'ball']]");
        let srdf = [["l0".to_string(), "l3".into()], ["gone".into(), "l3".into()]];
        assert_eq!(pairs(&scene_with(&text, &[arm], &srdf, None).unwrap()), ["l1 ball"]);
    }

    #[test]
    fn neighbours_are_checked_if_the_scene_enables_them() {
        let arm = chain(&[Revolute, Fixed, Revolute]);
        let text = |pairs: &str| format!("{PLAIN}{BALL}[pairs]\n{pairs}");
        let scene_of = |pairs: &str| scene(&text(pairs), std::slice::from_ref(&arm));
        let enabled = scene_of("enable = [['l1', 'l0'], ['arm/l2', 'l3'], ['l3', 'ball']]").unwrap();
        assert_eq!(pairs(&enabled), ["l0 l1", "l0 l3", "l1 ball", "l2 l3", "l2 ball", "l3 ball"]);
        assert!(enabled.warnings.iter().all(|warning| !warning.contains("enable")), "{:?}", enabled.warnings);
        // A pair that never moves is left out with a warning.
        let fixed = scene_of("enable = [['l1', 'l2'], ['l0', 'ball']]").unwrap();
        assert_eq!(pairs(&fixed), ["l0 l3", "l1 ball", "l2 ball", "l3 ball"]);
        let told = "pairs: enable [\"l1\", \"l2\"]: nothing moves one against the other: the pair is not checked";
        assert_eq!(fixed.warnings.iter().filter(|warning| warning.contains("nothing moves")).count(), 2);
        assert!(fixed.warnings.contains(&told.to_string()), "{:?}", fixed.warnings);
        let message = |pairs: &str| scene_of(pairs).unwrap_err().to_string();
        assert!(
            message("enable = [['l1', 'l9']]").contains("pairs: enable [\"l1\", \"l9\"]: got `l9`, expected one of")
        );
        assert!(message("enable = [['l1', 'l1']]").contains("got one body twice"));
        assert!(message("enable = [['l1', 'l0'], ['l0', 'l1']]").contains("[\"l0\", \"l1\"]: got the pair twice"));
        let both = message("enable = [['l3', 'ball']]\ndisable = [['ball', 'l3']]");
        assert!(
            both.contains("pairs: enable [\"l3\", \"ball\"]: got a pair that `disable` or `touch` takes out"),
            "{both}"
        );
        let held = "[[attached]]\nname = 'can'\nlink = 'l3'\nshape = { sphere = 0.1 }\ntouch = ['l2']\n";
        let touched = format!("{PLAIN}{held}[pairs]\nenable = [['can', 'l2']]");
        assert!(scene(&touched, std::slice::from_ref(&arm)).unwrap_err().to_string().contains("`touch` takes out"));
    }

    #[test]
    fn a_link_without_geometry_that_a_scene_enables_is_told() {
        let mut arm = chain(&[Revolute, Revolute]);
        arm.links[1].collision.clear();
        let scene = scene(&format!("{PLAIN}{BALL}[pairs]\nenable = [['l1', 'l2']]"), &[arm]).unwrap();
        assert!(scene.warnings.iter().any(|warning| warning.contains("without geometry touches nothing")));
    }

    #[test]
    fn a_moving_base_is_checked_against_obstacles_and_other_robots() {
        let moving = "base = 'planar'\nbounds = { min = [-1, -1], max = [1, 1] }\n";
        let text = format!("{PLAIN}name = 'a'\n{moving}{PLAIN}name = 'b'\n{BALL}");
        let scene = scene(&text, &[chain(&[Revolute]), chain(&[Planar])]).unwrap();
        let expected = ["a/l0 b/l0", "a/l0 b/l1", "a/l0 ball", "a/l1 b/l0", "a/l1 b/l1", "a/l1 ball", "b/l1 ball"];
        assert_eq!(pairs(&scene), expected);
    }

    #[test]
    fn links_without_geometry_have_names_but_no_body() {
        let mut arm = chain(&[Revolute, Revolute]);
        arm.links[1].collision.clear();
        let text = format!("{PLAIN}{BALL}[pairs]\ndisable = [['l1', 'ball'], ['l2', 'ball']]");
        assert_eq!(pairs(&scene(&text, &[arm]).unwrap()), ["l0 l2"]);
    }

    #[test]
    fn faults_name_element_and_expectation() {
        let message = |text: &str| scene(text, &[chain(&[Revolute])]).unwrap_err().to_string();
        assert!(message(BALL).contains("expected at least one [[robot]]"));
        assert!(message(&format!("{PLAIN}{}", BALL.replace("ball", "l1"))).contains("obstacle \"l1\": a link has"));
        assert!(message(&format!("{PLAIN}[pairs]\ndisable = [['l1', 'bal']]")).contains("got `bal`, expected one of"));
        assert!(
            message(&format!("{PLAIN}pose = {{ rpy = [0, nan, 0] }}"))
                .contains("robot \"arm\": placement: pose: got NaN")
        );
        let mut parted = chain(&[Revolute, Revolute]);
        parted.joints[1].parent = 2;
        assert!(scene(PLAIN, &[parted]).unwrap_err().to_string().contains("arm.urdf: link \"l2\": no chain"));
    }

    #[test]
    fn a_metric_of_displacements_needs_something_that_is_displaced() {
        let mut arm = chain(&[Revolute]);
        arm.links[1].collision.clear();
        for kind in ["object-norm", "max-displacement"] {
            let text = format!("metric = {{ kind = '{kind}' }}\n{PLAIN}{BALL}");
            let message = scene(&text, std::slice::from_ref(&arm)).unwrap_err().to_string();
            assert!(message.contains("metric: no link that moves has geometry"), "{message}");
            assert!(scene(&text, &[chain(&[Revolute])]).is_ok());
        }
        assert!(scene(&format!("{PLAIN}{BALL}"), &[arm]).is_ok());
    }

    #[test]
    fn vast_bodies_are_refused() {
        let of = |size: &str| scene(&format!("{PLAIN}{}", BALL.replace("0.5", size)), &[chain(&[Revolute])]);
        assert!(of("1e5").is_ok());
        let message = of("1.1e5").unwrap_err().to_string();
        assert!(message.contains("body \"ball\": got a shape with a radius of 1.1e5 m"), "{message}");
    }

    #[test]
    fn planes_stand_still() {
        let mut arm = chain(&[Fixed, Revolute]);
        let plane = Geometry::HalfSpace { normal: [0.0, 0.0, 1.0], offset: 0.0 };
        arm.links[1].collision[0].geometry = plane.clone();
        let scene_of = |text: &str, arm: &Robot| scene(text, std::slice::from_ref(arm));
        assert_eq!(pairs(&scene_of(&format!("{PLAIN}[pairs]\ndisable = [['l0', 'l2']]"), &arm).unwrap()), [""; 0]);
        assert_eq!(pairs(&scene_of(&format!("{PLAIN}name = 'a'\n{PLAIN}name = 'b'\n"), &arm).unwrap()).len(), 0);
        let moving = "base = 'planar'\nbounds = { min = [-1, -1], max = [1, 1] }\n";
        let refused = |message: String, link: &str| {
            assert!(
                message.contains(&format!("arm.urdf: link \"{link}\": got a <plane> on a link that moves")),
                "{message}"
            );
        };
        refused(scene_of(&format!("{PLAIN}{moving}"), &arm).unwrap_err().to_string(), "l1");
        arm.links[2].collision[0].geometry = plane;
        refused(scene_of(PLAIN, &arm).unwrap_err().to_string(), "l2");
    }

    #[test]
    fn nothing_to_check_is_told() {
        let scene = scene(PLAIN, &[chain(&[Revolute])]).unwrap();
        assert!(scene.pairs.is_empty() && scene.warnings[0].contains("no pair of bodies is checked"));
    }
}

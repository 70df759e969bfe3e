//! A world file for a robot that is already loaded: its obstacles replace those of a scene, its
//! attached objects and pairs join them.

use std::path::Path;

use super::SceneFile;
use crate::error::{Error, Result, bounded};
use crate::robot::LoadLimit;
use crate::scene::assemble::clearances::clearances_of;
use crate::scene::assemble::fixtures::read_others;
use crate::scene::assemble::load::Files;
use crate::scene::assemble::obstacles::Others;
use crate::scene::assemble::pairs::pairs_of_scene;
use crate::scene::assemble::{ReadFile, assemble_entries};
use crate::scene::clearances::Clearances;
use crate::scene::{Body, Scene, file};

/// Puts the robots of a scene into the world that the TOML `text` of the file at `path` describes.
///
/// A file with a `[[robot]]` is a whole scene and replaces `robots`. Otherwise its obstacles
/// replace those of `robots`, and its clearance does if it gives one. Attached objects, disabled
/// and enabled pairs, clearances of pairs and padding are added.
///
/// # Errors
/// As [`crate::scene::assemble::assemble`]; [`Error::Input`] for a metric, which belongs to robots.
pub fn in_world(robots: &Scene, path: &Path, text: &str, read: ReadFile) -> Result<Scene> {
    let name = path.display().to_string();
    in_world_of_entries(robots, path, &file::parse(&name, text)?, read)
}

/// As [`in_world`], for a world that is already parsed or was built in code.
///
/// # Errors
/// As [`in_world`].
pub fn in_world_of_entries(robots: &Scene, path: &Path, world: &SceneFile, read: ReadFile) -> Result<Scene> {
    let name = path.display().to_string();
    if !world.robot.is_empty() {
        return assemble_entries(path, world, read);
    }
    world.check(&name)?;
    if world.metric.is_some() {
        let problem = "got one in a world without a [[robot]], expected it in the scene of the robot";
        return Err(Error::input(&name, "metric", problem));
    }
    let mut scene = robots.without_obstacles();
    let mut files = Files::new(path, world, read);
    let Others { obstacles, attached } = read_others(&name, world, true, &mut files, &mut scene.warnings)?;
    scene.warnings.extend(files.into_mesh_warnings());
    let in_file = |error| named(&name, error);
    let moving = scene.bodies.iter().filter(|body| body.frame != 0).count();
    let pairs = scene.pairs.len().saturating_add(moving.saturating_mul(obstacles.len()));
    world.limits.check(LoadLimit::Pairs, pairs, &name, "pairs")?;
    scene = scene.with_obstacles(obstacles).map_err(in_file)?;
    let attached = attached.into_iter().zip(&world.attached);
    let attached =
        attached.map(|(object, entry)| (object, entry.link.as_str(), entry.touch.iter().map(String::as_str).collect()));
    scene = scene.attached_all(attached, world.limits.get(LoadLimit::Pairs)).map_err(in_file)?;
    world.limits.check(LoadLimit::Pairs, scene.pairs.len(), &name, "pairs")?;
    let bodies = scene.index(|_| true);
    let body = |wanted: &str| {
        scene.body_or_link(&bodies, wanted, String::new).map_err(|error| match error {
            Error::Input { problem, .. } => problem,
            other => other.to_string(),
        })
    };
    let mut warnings = Vec::new();
    let (disabled, enabled) = pairs_of_scene(&name, world, &body, &scene.bodies, &mut warnings)?;
    let find = |element: String, wanted: &str| {
        let body = scene.body_or_link(&bodies, wanted, || element).map_err(in_file)?;
        Ok(body.map(|body| scene.bodies[body].name.clone()))
    };
    let Clearances { own, pairs, padding } = clearances_of(world, &find)?;
    drop(bodies);
    scene.pairs.retain(|pair| !disabled.contains(pair));
    scene.pairs.extend(enabled);
    scene.pairs.sort_unstable();
    scene.pairs.dedup();
    world.limits.check(LoadLimit::Pairs, scene.pairs.len(), &name, "pairs")?;
    scene.warnings.extend(warnings);
    if let Some(clearance) = world.clearance {
        (scene.clearance, scene.clearances.own) = (clearance.lengths().0, own);
    }
    scene.clearances.pairs.extend(pairs);
    scene.clearances.padding.extend(padding);
    let came = scene.bodies.len();
    Ok(scene.telling(came))
}

/// Reads the obstacles of a world that is already parsed or was built in code; also returns
/// warnings about their files.
///
/// # Errors
/// As [`in_world`].
pub fn obstacles_of_entries(path: &Path, world: &SceneFile, read: ReadFile) -> Result<(Vec<Body>, Vec<String>)> {
    let (mut files, mut warnings) = (Files::new(path, world, read), Vec::new());
    let others = read_others(&path.display().to_string(), world, false, &mut files, &mut warnings)?;
    warnings.extend(files.into_mesh_warnings());
    Ok((others.obstacles, bounded(warnings)))
}

/// Names the file that requests a change to a scene in the error of that change.
fn named(file: &str, error: Error) -> Error {
    match error {
        Error::Input { element, problem, .. } => Error::input(file, element, problem),
        other => other,
    }
}

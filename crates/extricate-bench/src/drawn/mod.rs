//! Random scenes, to measure what queries miss on scenes that nobody selected.
//!
//! A drawn scene is kept if a reasonable share of its configurations collides, with obstacles too,
//! and no fixed link is inside an obstacle. Otherwise it is drawn again. Scenes with a fixed
//! construction (carts, voxels) are written without this test.

mod entry;
mod obstacles;
mod robots;
mod sane;
mod told;

use std::collections::BTreeSet;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use anyhow::{Context, Result, bail};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use crate::files::stl;
use entry::{Shape, Written};
use obstacles::KINDS;
use robots::Robot;

/// Draws after which a scene is given up.
const MAX_DRAWS: usize = 500;
/// Accepted share of colliding configurations. It is estimated from a sample, so the limits are
/// tighter than the 10 % and 90 % that scenes are meant to have.
const COLLIDING_SHARE: RangeInclusive<f64> = 0.13..=0.87;
/// Accepted share for several arms, of which two or more should often collide at once.
const ARMS_COLLIDING_SHARE: RangeInclusive<f64> = 0.5..=0.87;

/// Writes all scenes of `seed` into `folder`, and for each a JSON line that describes it. If
/// `fetched` is given, its robots are drawn among obstacles too.
pub fn draw(folder: &Path, seed: u64, fetched: Option<&Path>, mut output: impl Write) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut written = BTreeSet::new();
    let mut keep = |scene: Written, output: &mut dyn Write| -> Result<()> {
        let found = sane::inspect(&scene)?;
        for (path, contents) in scene.all_files() {
            // Scenes share the files of their robots.
            if written.insert(path.clone()) {
                let path = folder.join(path);
                std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
                std::fs::write(&path, contents).with_context(|| path.display().to_string())?;
            }
        }
        let line = json!({
            "scene": format!("{}.toml", scene.name),
            "coordinates": found.coordinates,
            "obstacles": found.obstacles,
            "colliding": found.share,
            "with_obstacles": found.with_obstacles,
            "draws": scene.draws,
        });
        Ok(writeln!(output, "{line}")?)
    };
    for robot in robots::all(fetched)? {
        for (kind, _) in KINDS {
            keep(among(kind, &robot, seed)?, &mut output)?;
        }
    }
    for (cubes, side) in told::CLUTTERS {
        keep(clutter(cubes, side, seed)?, &mut output)?;
    }
    for arms in 2..=4 {
        keep(several_arms(arms, seed)?, &mut output)?;
    }
    for count in told::CART_COUNTS {
        for wall in told::WALLS {
            keep(told::carts(count, wall), &mut output)?;
        }
    }
    let name = format!("voxels-{seed}");
    keep(told::voxels(&mut random(&name), &name), &mut output)
}

/// Draws a scene of one robot among obstacles of a kind.
fn among(kind: &str, robot: &Robot, seed: u64) -> Result<Written> {
    let (_, obstacles) = KINDS.iter().find(|(name, _)| *name == kind).context("an unknown kind")?;
    drawn(format!("{kind}-{}-{seed}", robot.name), COLLIDING_SHARE, |scene, rng| {
        scene.robot(robot, "", [0.0; 3], kind == "ring" || kind == "mesh");
        scene.obstacles(&obstacles(rng, &robot.space));
    })
}

/// Draws the seven-joint arm among small cubes.
fn clutter(cubes: usize, side: f64, seed: u64) -> Result<Written> {
    let arm = robots::seven_joint_arm();
    drawn(format!("clutter-{cubes}-{seed}"), COLLIDING_SHARE, |scene, rng| {
        scene.robot(&arm, "", [0.0; 3], false);
        scene.obstacles(&obstacles::cubes(rng, cubes, side));
    })
}

/// Draws arms that cannot reach each other, each with an obstacle of its own in front.
fn several_arms(count: usize, seed: u64) -> Result<Written> {
    let arm = robots::seven_joint_arm();
    drawn(format!("arms-{count}-{seed}"), ARMS_COLLIDING_SHARE, |scene, rng| {
        for k in 0..count {
            let at = [0.0, robots::ARM_SPACING_M * k as f64, 0.0];
            scene.robot(&arm, &format!("arm_{}", k + 1), at, false);
        }
        for k in 0..count {
            let mut own = obstacles::before(rng, &arm.space);
            own.name = format!("obstacle_{}", k + 1);
            own.xyz[1] += robots::ARM_SPACING_M * k as f64;
            scene.obstacles(&[own]);
        }
    })
}

fn drawn(name: String, share: RangeInclusive<f64>, write: impl Fn(&mut Written, &mut ChaCha8Rng)) -> Result<Written> {
    let mut rng = random(&name);
    for draws in 1..=MAX_DRAWS {
        let mut scene = Written { draws, ..Written::new(&name) };
        write(&mut scene, &mut rng);
        if sane::is_sane(&scene, share.clone())? {
            return Ok(scene);
        }
    }
    bail!("{name}: {MAX_DRAWS} draws, none with a share of colliding configurations in {share:?}")
}

/// A generator seeded by the scene's name, so that adding a kind or a robot changes no other scene.
fn random(name: &str) -> ChaCha8Rng {
    // FNV-1a: G. Fowler, L. C. Noll, K.-P. Vo, The FNV non-cryptographic hash algorithm.
    let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    ChaCha8Rng::seed_from_u64(name.bytes().fold(0xcbf2_9ce4_8422_2325, fold))
}

/// Path and contents of the mesh file of an obstacle, if it has a mesh.
fn mesh_file(scene: &str, obstacle: &str, shape: &Shape) -> Option<(String, Vec<u8>)> {
    match shape {
        Shape::Mesh(mesh) | Shape::Hull(mesh) => Some((format!("meshes/{scene}-{obstacle}.stl"), stl(mesh))),
        Shape::Box(_) | Shape::Cylinder(_) => None,
    }
}

#[cfg(test)]
mod tests;

//! Whether a drawn scene is worth asking: what the exact checker says of it.

use std::ops::RangeInclusive;

use anyhow::Result;
use extricate::geometry::Body;
use extricate::internals::collision::{PairScratch, PreparedShape};
use extricate::internals::cspace::sampling::uniform;
use extricate::{Checker, Label, Scene};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::entry::Written;

/// Configurations that the share is told from: it is within 3 % of what it seems, two times in
/// twenty aside.
const SAMPLES: usize = 1000;
/// With so few it is clear already that a scene is nearly free or nearly always collides.
const FIRST: usize = 100;

/// What a scene is.
#[derive(Debug)]
pub struct Look {
    /// The share of uniform configurations that collide.
    pub share: f64,
    /// The share of uniform configurations that collide with an obstacle.
    pub with_obstacles: f64,
    /// How many coordinates a configuration has.
    pub coordinates: usize,
    /// How many obstacles there are.
    pub obstacles: usize,
}

/// Loads a scene and samples it.
pub fn look(written: &Written) -> Result<Look> {
    let scene = written.assembled()?;
    let (coordinates, obstacles) = (scene.space().nq(), scene.bodies().iter().filter(|b| b.robot.is_none()).count());
    let with_obstacles = share(&Checker::new(with_obstacles(&scene)?.into()), SAMPLES);
    Ok(Look { share: share(&Checker::new(scene.into()), SAMPLES), with_obstacles, coordinates, obstacles })
}

/// Whether the share of colliding configurations is in `range`, as many at least collide with
/// obstacles, and nothing that cannot move is in one. As fewer than all collide, no pair always
/// does.
///
/// The share with obstacles counts by itself, as hands collide with themselves more often than not:
/// what is drawn around one out of its reach would be no scene of its own.
pub fn is_sane(written: &Written, range: RangeInclusive<f64>) -> Result<bool> {
    let scene = written.assembled()?;
    if fixed_link_collides(&scene) {
        return Ok(false);
    }
    let (least, most) = (*range.start(), *range.end());
    let (obstacles, all) = (Checker::new(with_obstacles(&scene)?.into()), Checker::new(scene.into()));
    if share(&obstacles, FIRST) < 0.5 * least || share(&all, FIRST) > 0.5 * (1.0 + most) {
        return Ok(false);
    }
    Ok(share(&obstacles, SAMPLES) >= least && share(&all, SAMPLES) <= most)
}

/// The scene with pairs of a link and an obstacle alone.
fn with_obstacles(scene: &Scene) -> Result<Scene> {
    let pairs = scene.pairs().iter().map(|pair| [pair.first, pair.second].map(|body| &scene.bodies()[body]));
    let of_links = pairs.filter(|pair| pair.iter().all(|body| body.robot.is_some()));
    Ok(scene.disabled(of_links.map(|pair| pair.map(|body| body.name.as_str())))?)
}

/// The share of uniform configurations that collide.
fn share(checker: &Checker, samples: usize) -> f64 {
    let space = checker.scene().space();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut configs = vec![0.0; samples * space.nq()];
    configs.chunks_exact_mut(space.nq()).for_each(|q| uniform(space, &mut rng, q));
    let mut labels = vec![Label::Free; samples];
    checker.label_batch(&configs, &mut labels);
    labels.iter().filter(|label| **label == Label::Colliding).count() as f64 / samples as f64
}

/// Whether a link that cannot move is in an obstacle. Scenes do not check such pairs.
fn fixed_link_collides(scene: &Scene) -> bool {
    let fixed: Vec<&Body> = scene.bodies().iter().filter(|body| body.frame == 0).collect();
    let mut scratch = PairScratch::default();
    let mut near = |a: &Body, b: &Body| {
        a.parts.iter().any(|p| {
            let Some(shape) = PreparedShape::new(&p.geometry) else { return false };
            b.parts.iter().any(|o| {
                let pose = p.pose_frame_part.inverse().then(&o.pose_frame_part);
                PreparedShape::new(&o.geometry)
                    .is_some_and(|other| shape.is_nearer(&other, &pose, scene.clearance(), &mut scratch))
            })
        })
    };
    fixed.iter().any(|a| a.robot.is_some() && fixed.iter().any(|b| b.robot.is_none() && near(a, b)))
}

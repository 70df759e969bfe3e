//! Decides with the exact checker whether a drawn scene is worth querying.

use std::ops::RangeInclusive;

use anyhow::Result;
use extricate::geometry::Body;
use extricate::internals::collision::{PairScratch, PreparedShape};
use extricate::internals::cspace::sampling::uniform;
use extricate::{Checker, Label, Scene};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::entry::Written;

/// Configurations from which a share is estimated: its standard error is at most 1.6 percent.
const SAMPLES: usize = 1000;
/// A first sample: enough to reject scenes that are nearly free or nearly always collide.
const FIRST_SAMPLES: usize = 100;

#[derive(Debug)]
pub struct Inspection {
    /// Share of uniform configurations that collide.
    pub share: f64,
    /// Share of uniform configurations that collide with an obstacle.
    pub with_obstacles: f64,
    pub coordinates: usize,
    pub obstacles: usize,
}

/// Loads a scene and estimates its shares.
pub fn inspect(written: &Written) -> Result<Inspection> {
    let scene = written.assembled()?;
    let (coordinates, obstacles) = (scene.space().nq(), scene.bodies().iter().filter(|b| b.robot.is_none()).count());
    let with_obstacles = share(&Checker::new(with_obstacles(&scene)?.into()), SAMPLES);
    Ok(Inspection { share: share(&Checker::new(scene.into()), SAMPLES), with_obstacles, coordinates, obstacles })
}

/// Whether the shares of configurations that collide, and that collide with obstacles, lie in
/// `range`, and no fixed link is inside an obstacle. The upper limit also excludes pairs that
/// always collide.
///
/// Obstacles have a share of their own because hands mostly collide with themselves: obstacles out
/// of their reach would add nothing.
pub fn is_sane(written: &Written, range: RangeInclusive<f64>) -> Result<bool> {
    let scene = written.assembled()?;
    if fixed_link_collides(&scene) {
        return Ok(false);
    }
    let (least, most) = (*range.start(), *range.end());
    let (obstacles, all) = (Checker::new(with_obstacles(&scene)?.into()), Checker::new(scene.into()));
    if share(&obstacles, FIRST_SAMPLES) < 0.5 * least || share(&all, FIRST_SAMPLES) > 0.5 * (1.0 + most) {
        return Ok(false);
    }
    Ok(share(&obstacles, SAMPLES) >= least && share(&all, SAMPLES) <= most)
}

/// The scene with only the pairs of a link and an obstacle.
fn with_obstacles(scene: &Scene) -> Result<Scene> {
    let pairs = scene.pairs().iter().map(|pair| [pair.first, pair.second].map(|body| &scene.bodies()[body]));
    let of_links = pairs.filter(|pair| pair.iter().all(|body| body.robot.is_some()));
    Ok(scene.disabled(of_links.map(|pair| pair.map(|body| body.name.as_str())))?)
}

/// Share of uniform configurations that collide.
fn share(checker: &Checker, samples: usize) -> f64 {
    let space = checker.scene().space();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut configs = vec![0.0; samples * space.nq()];
    configs.chunks_exact_mut(space.nq()).for_each(|q| uniform(space, &mut rng, q));
    let mut labels = vec![Label::Free; samples];
    checker.label_batch(&configs, &mut labels);
    labels.iter().filter(|label| **label == Label::Colliding).count() as f64 / samples as f64
}

/// Whether a link that cannot move is inside an obstacle; scenes do not check such pairs.
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

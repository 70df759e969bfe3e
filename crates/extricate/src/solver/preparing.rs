//! Preparing a scene, and whether a model may be asked in it.

use std::collections::HashSet;
use std::thread;

use rayon::ThreadPoolBuilder;

use crate::collision::shared_shape;
use crate::error::{Error, Result};
use crate::robot::Geometry;
use crate::scene::{MetricKind, Scene};

/// Whether a scene has no mesh, cloud or grid that `before` has not: what is new then is prepared
/// by the calling thread, in less time than it takes to start others.
pub fn is_small_change(before: &Scene, scene: &Scene) -> bool {
    let known: HashSet<usize> = shapes(before).filter_map(shared_shape).collect();
    // Equal shapes that were read twice are told apart by their pointers alone.
    let is_known = |shape: &Geometry| match shared_shape(shape) {
        Some(pointer) => known.contains(&pointer) || shapes(before).any(|other| other == shape),
        None => true,
    };
    shapes(scene).all(is_known)
}

/// Runs `work`, which prepares a scene, on threads of its own.
///
/// A thread of another pool that waits takes up other work of that pool meanwhile, and would wait
/// for itself if that work needs what is being prepared.
pub fn apart<T: Send>(work: &(dyn Fn() -> T + Sync)) -> T {
    let pooled = || match ThreadPoolBuilder::new().build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    };
    if rayon::current_thread_index().is_none() {
        return pooled();
    }
    thread::scope(|scope| {
        let worker = thread::Builder::new().spawn_scoped(scope, pooled);
        match worker.map(|worker| worker.join()) {
            Ok(Ok(made)) => made,
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(_) => work(),
        }
    })
}

fn shapes(scene: &Scene) -> impl Iterator<Item = &Geometry> {
    scene.bodies.iter().flat_map(|body| &body.parts).map(|part| &part.geometry)
}

/// Whether a model that was learned in `learned` may be asked in `scene`: obstacles, checked pairs
/// and clearance may differ; what stored configurations and distances between them mean must not.
///
/// # Errors
/// [`Error::Input`] if coordinates, limits, weights or the metric differ; for the metrics of
/// displacement, also if what moves does.
pub fn fits(learned: &Scene, scene: &Scene) -> Result<()> {
    let differs = |element: &str, problem: String| Err(Error::input("scene", element, problem));
    if scene.metric != learned.metric {
        let problem = format!("got {}, expected that of the model, {}", scene.metric.name(), learned.metric.name());
        return differs("metric", problem);
    }
    if scene.space != learned.space {
        let (new, old) = (scene.space.factors(), learned.space.factors());
        let at = new.iter().zip(old).position(|(a, b)| a != b).unwrap_or(new.len().min(old.len()));
        let name = new.get(at).or(old.get(at)).map_or("", |factor| &factor.name);
        let problem = "got other coordinates, limits or weights than the model's, expected the same: learn it anew";
        return differs(&format!("joint \"{name}\""), problem.into());
    }
    if scene.metric != MetricKind::Joint
        && (scene.frames != learned.frames || !scene.moving_bodies().eq(learned.moving_bodies()))
    {
        let problem = "got other moving bodies than the model's, by which its metric measures: learn it anew";
        return differs("robots", problem.into());
    }
    Ok(())
}

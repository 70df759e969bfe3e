//! Preparation of a scene, and the test whether a model fits it.

use std::thread;

use rayon::ThreadPoolBuilder;

use crate::collision::shared_shape;
use crate::error::{Error, Result};
use crate::scene::correspondence::by_name;
use crate::scene::{Body, MetricKind, Part, Scene};

/// Returns whether each body of `scene` that has a mesh, a cloud or a grid is also in `before`,
/// under its name and with equal shapes. The calling thread then prepares the rest faster than it
/// could start other threads.
pub fn is_small_change(before: &Scene, scene: &Scene) -> bool {
    let is_known = |(body, namesake): (&Body, Option<usize>)| {
        let has_large_shape = body.parts.iter().any(|part| shared_shape(&part.geometry).is_some());
        !has_large_shape || namesake.is_some_and(|at| are_alike(&before.bodies[at].parts, &body.parts))
    };
    scene.bodies.iter().zip(by_name(before, scene)).all(is_known)
}

/// Returns whether two bodies have equal shapes; several shapes must also have equal poses.
fn are_alike(one: &[Part], other: &[Part]) -> bool {
    match (one, other) {
        ([one], [other]) => one.geometry == other.geometry,
        _ => one == other,
    }
}

/// Runs `work`, which prepares a scene, on threads of its own.
///
/// A waiting thread of another pool takes up other work of that pool meanwhile. It would wait for
/// itself if that work needed what is being prepared.
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

/// Checks that a model learned in `learned` may be used in `scene`. Obstacles, checked pairs and
/// clearance may differ, but not what stored configurations and distances between them mean.
///
/// # Errors
/// [`Error::Input`] if coordinates, limits, weights or the metric differ; for the metrics of
/// displacement, also if the moving bodies differ.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::robot::{Geometry, TriangleMesh};
    use crate::scene::builtin;

    #[test]
    fn a_mesh_that_is_new_or_has_another_name_is_no_small_change() {
        let corners = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
        let mesh = || TriangleMesh::from_arrays(&corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        let wedge = Geometry::Mesh(mesh().into());
        let named = |name: &str, geometry: &Geometry| Body::obstacle(name, geometry.clone(), Pose::at([2.0, 0.0, 0.0]));
        let bare = builtin::scene("planar-arm").unwrap();
        let ball = named("ball", &Geometry::Sphere { radius: 0.1 });
        let scene = bare.with_obstacles([named("wedge", &wedge)]).unwrap();
        let moved = scene.moved([("wedge", Pose::at([3.0, 0.0, 0.0]))]).unwrap();
        let read_again = bare.with_obstacles([named("wedge", &Geometry::Mesh(mesh().into()))]).unwrap();
        for small in [&scene, &moved, &read_again, &bare, &scene.with_obstacles([ball]).unwrap()] {
            assert!(is_small_change(&scene, small));
        }
        assert!(!is_small_change(&bare, &scene));
        assert!(!is_small_change(&scene, &scene.with_obstacles([named("other", &wedge)]).unwrap()));
    }
}

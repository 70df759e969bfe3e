//! Many grasps of many objects by one hand, as data sets hold them.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::hand::Hand;
use super::options::ReleaseOptions;
use super::report::Grasp;
use crate::cspace::Config;
use crate::error::Result;
use crate::query::{QueryScratch, World};
use crate::scene::Body;

/// What became of a grasp: `None` where nothing free was found; the message where its object cannot
/// be used.
pub type Released = std::result::Result<Option<Grasp>, String>;

/// Releases grasps, each of the object of its number, which `object_of` gives; in order, on all
/// threads of the current rayon pool. `world` is the hand without the objects: what is prepared of
/// it is shared, and each object is prepared once.
///
/// # Guarantee
/// Each is what [`Hand::release`] says of it alone, whatever the number of threads.
pub fn release_batch(
    world: &World,
    grasps: &[(usize, Config)],
    object_of: &(dyn Fn(usize) -> Result<Body> + Sync),
    options: &ReleaseOptions,
) -> Vec<Released> {
    let mut by_object: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    grasps.iter().enumerate().for_each(|(at, (object, _))| by_object.entry(*object).or_default().push(at));
    let by_object: Vec<(usize, Vec<usize>)> = by_object.into_iter().collect();
    let of_object = |(object, places): &(usize, Vec<usize>)| -> Vec<(usize, Released)> {
        let prepared = object_of(*object).and_then(|body| with_object(world, body));
        let (world, hand) = match prepared {
            Ok(prepared) => prepared,
            Err(error) => return places.iter().map(|at| (*at, Err(error.to_string()))).collect(),
        };
        let release = |scratch: &mut QueryScratch, at: &usize| {
            let grasp = hand.release(&world.view(), &grasps[*at].1, options, scratch);
            (*at, Ok(grasp))
        };
        places.par_iter().map_init(QueryScratch::default, release).collect()
    };
    let mut found: Vec<(usize, Released)> = by_object.par_iter().flat_map_iter(of_object).collect();
    found.sort_unstable_by_key(|(at, _)| *at);
    found.into_iter().map(|(_, released)| released).collect()
}

fn with_object(world: &World, body: Body) -> Result<(World, Hand)> {
    let name = body.name.clone();
    let scene = world.scene().with_obstacles([body])?;
    let hand = Hand::new(&scene, &name)?;
    Ok((world.with_scene(scene), hand))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::math::{Pose, Vec3};
    use crate::robot::Geometry;
    use crate::scene::builtin;

    #[test]
    fn batches_say_what_single_releases_say() {
        let scene = builtin::scene("hand").unwrap();
        let world = World::new(scene.clone());
        let object_of = |number: usize| match number {
            2 => Err(Error::input("objects", "object 2", "got none")),
            _ => {
                let pose = Pose::translation(Vec3::new(0.0, 0.0, 0.08));
                let radius = 0.02 + 0.01 * number as f64;
                Ok(Body::obstacle("object", Geometry::Sphere { radius }, pose))
            }
        };
        let config = |curl: f64| scene.config(&[0.0, curl, 0.0, curl, curl]).unwrap();
        let grasps: Vec<(usize, Config)> = (0..24).map(|k| (k % 4, config(0.3 + 0.02 * k as f64))).collect();
        let options = ReleaseOptions::default();
        let found = release_batch(&world, &grasps, &object_of, &options);
        assert_eq!(found.len(), grasps.len());
        let mut moved = 0;
        for ((number, q), found) in grasps.iter().zip(&found) {
            if *number == 2 {
                assert!(found.as_ref().unwrap_err().contains("object 2"));
                continue;
            }
            let (world, hand) = with_object(&world, object_of(*number).unwrap()).unwrap();
            let alone = hand.release(&world.view(), q, &options, &mut QueryScratch::default());
            assert_eq!(found.as_ref().unwrap(), &alone);
            moved += usize::from(alone.is_some_and(|grasp| grasp.moved > 0.0));
        }
        assert!(moved > 6, "{moved}");
    }
}

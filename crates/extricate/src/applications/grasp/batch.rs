//! Releases many grasps of many objects by one hand, as data sets hold them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::hand::Hand;
use super::options::ReleaseOptions;
use super::release::release;
use super::report::Grasp;
use crate::cspace::Config;
use crate::error::Result;
use crate::query::QueryScratch;
use crate::query::prepared::Prepared;
use crate::scene::Body;
use crate::solver::Solver;

/// Result of one grasp of a batch: `None` if nothing free was found, the message if its object
/// cannot be used.
pub type Released = std::result::Result<Option<Grasp>, String>;

impl Solver {
    /// Releases grasps, each given by the number of its object and a configuration, on all threads
    /// of the current rayon pool. `object_of` returns the object of a number. Results are in the
    /// order of `grasps`. The scene is the hand without the objects: what is prepared for it is
    /// shared, and each object is prepared once.
    ///
    /// # Guarantee
    /// Each result is the one that [`Solver::release`] returns for that grasp alone, whatever the
    /// number of threads.
    pub fn release_batch(
        &self,
        grasps: &[(usize, Config)],
        object_of: &(dyn Fn(usize) -> Result<Body> + Sync),
        options: &ReleaseOptions,
    ) -> Vec<Released> {
        let found = Mutex::new(Vec::with_capacity(grasps.len()));
        let keep = |at: usize, released: Released| {
            found.lock().unwrap_or_else(PoisonError::into_inner).push((at, released));
        };
        self.release_each(grasps, object_of, options, &keep);
        let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        found.sort_unstable_by_key(|(at, _)| *at);
        found.into_iter().map(|(_, released)| released).collect()
    }

    /// As [`Solver::release_batch`], but calls `tell` with each result, and its index in `grasps`,
    /// once it is known. Objects come in ascending order of their numbers, as far as threads allow.
    pub fn release_each(
        &self,
        grasps: &[(usize, Config)],
        object_of: &(dyn Fn(usize) -> Result<Body> + Sync),
        options: &ReleaseOptions,
        tell: &(dyn Fn(usize, Released) + Sync),
    ) {
        let mut by_object: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        grasps.iter().enumerate().for_each(|(at, (object, _))| by_object.entry(*object).or_default().push(at));
        let hand = self.prepared();
        by_object.iter().par_bridge().for_each(|(object, places)| {
            let prepared = object_of(*object).and_then(|body| with_object(hand, body));
            let (prepared, hand) = match prepared {
                Ok(prepared) => prepared,
                Err(error) => return places.iter().for_each(|at| tell(*at, Err(error.to_string()))),
            };
            let context = prepared.context();
            places.par_iter().for_each_init(QueryScratch::default, |scratch, at| {
                tell(*at, Ok(release(&hand, &context, &grasps[*at].1, options, scratch)));
            });
        });
    }
}

fn with_object(prepared: &Prepared, body: Body) -> Result<(Prepared, Hand)> {
    let name = body.name.clone();
    let scene = prepared.scene().with_obstacles([body])?;
    let hand = Hand::new(&scene, &name)?;
    Ok((prepared.with_scene(scene), hand))
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
        let solver = Solver::new(scene.clone());
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
        let found = solver.release_batch(&grasps, &object_of, &options);
        assert_eq!(found.len(), grasps.len());
        let mut moved = 0;
        for ((number, q), found) in grasps.iter().zip(&found) {
            if *number == 2 {
                assert!(found.as_ref().unwrap_err().contains("object 2"));
                continue;
            }
            let with_object = scene.with_obstacles([object_of(*number).unwrap()]).unwrap();
            let hand = Hand::new(&with_object, "object").unwrap();
            let alone = solver.with_scene(with_object).unwrap().release(&hand, q, &options);
            assert_eq!(found.as_ref().unwrap(), &alone);
            moved += usize::from(alone.is_some_and(|grasp| grasp.moved > 0.0));
        }
        assert!(moved > 6, "{moved}");
    }
}
